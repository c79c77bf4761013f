// Keys, and the list of them.
import { button, make } from './dom';
import { SPEEDS, type Playback } from './playback';
import type { Session } from './session';
import type { Timeline } from './timeline/timeline';
import { toggleLoop } from './transport';

const LIST: [string, string][] = [
  ['Space', 'play, pause'], [', .', 'one frame back, on'], ['← →', 'a tenth of a second back, on'], ['Home End', 'start, end'],
  ['[ ]', 'loop from here, to here'], ['L', 'loop on, off'], ['S', 'slower, then full speed'], ['+ - 0', 'timeline closer, wider, whole'],
  ['1 2 3 4', 'portrait, three-quarter, profile, mouth'], ['Ctrl+Z, Ctrl+Y', 'undo, redo'],
  ['Tab', 'from lane to lane'], ['Ctrl+← Ctrl+→', 'from handle to handle in a lane'], ['← →', 'handle: one frame (Shift: five)'],
  ['↑ ↓', 'handle: value (Shift: more)'], ['Delete', 'handle: remove; border: back where it was'],
  ['drag over lanes', 'choose keys (Shift: further ones)'], ['Ctrl+A, Ctrl+C, X, V', 'keys: choose all, copy, cut, paste at the playhead'], ['Alt+[ Alt+]', 'chosen values smaller, larger'], ['T', 'tangent of the chosen keys: auto, flat, linear, step'],
  ['M, Shift+← →', 'marker here, to the markers'], ['right click, Shift+F10', 'what can be done there'],
  ['double click', 'add a point or a key; on a word: loop it; on a sound: correct it'], ['wheel, Ctrl+wheel, Alt+wheel', 'scroll, zoom time, zoom values'], ['middle button', 'pan'], ['Enter', 'in the text: perform'], ['?', 'this list'],
];

export function helpDialog(): HTMLDialogElement {
  const dialog = make('dialog', { class: 'help-dialog', 'aria-label': 'Shortcuts' });
  dialog.append(make('h2', {}, 'Shortcuts'),
    make('dl', {}, ...LIST.flatMap(([keys, what]) => [make('dt', {}, make('kbd', {}, keys)), make('dd', {}, what)])),
    button('Close', () => dialog.close(), { class: 'primary' }));
  return dialog;
}

export function listenToKeys(parts: { playback: Playback; session: Session; timeline: Timeline; help: () => void; view: (place: number) => void }): void {
  const { playback, session, timeline, help, view } = parts;
  const plain: Record<string, () => void> = {
    ' ': () => playback.toggle(), ',': () => playback.step(-1), '.': () => playback.step(1),
    ArrowLeft: () => playback.seek(playback.now - 0.1), ArrowRight: () => playback.seek(playback.now + 0.1),
    Home: () => playback.seek(0), End: () => playback.seek(playback.seconds),
    '[': () => playback.setLoop([playback.now, playback.loop?.[1] ?? playback.seconds]),
    ']': () => playback.setLoop([playback.loop?.[0] ?? 0, playback.now]),
    l: () => toggleLoop(playback), s: () => { playback.speed = slower(playback.speed); },
    '+': () => timeline.window.zoom(1 / 1.6, playback.now), '=': () => timeline.window.zoom(1 / 1.6, playback.now),
    '-': () => timeline.window.zoom(1.6, playback.now), 0: () => timeline.window.fit(), '?': help,
    t: () => timeline.nextTangent(), m: () => timeline.addMarker(), Delete: () => timeline.deleteChosen(), Backspace: () => timeline.deleteChosen(), Escape: () => timeline.selection.clear(),
    1: () => view(0), 2: () => view(1), 3: () => view(2), 4: () => view(3),
  };
  document.addEventListener('keydown', (event) => {
    if (event.defaultPrevented || document.querySelector('dialog[open]') !== null) return;
    const control = event.ctrlKey || event.metaKey;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    if (types(event.target)) return;
    if (control && key === 'z') done(event, () => (event.shiftKey ? session.redoEdit() : session.undo()));
    else if (control && key === 'y') done(event, () => session.redoEdit());
    else if (control && key === 'a') done(event, () => timeline.selectAll());
    else if (control && key === 'c' && timeline.selection.size > 0) done(event, () => timeline.copy());
    else if (control && key === 'x' && timeline.selection.size > 0) done(event, () => timeline.copy(true));
    else if (control && key === 'v') done(event, () => timeline.paste());
    else if (event.altKey && (key === ']' || key === '[')) done(event, () => timeline.scale(key === ']' ? 1.1 : 1 / 1.1));
    else if (!control && event.shiftKey && (key === 'ArrowLeft' || key === 'ArrowRight')) done(event, () => timeline.toMarker(key === 'ArrowRight' ? 1 : -1));
    else if (!control && !event.altKey && plain[key] !== undefined && !acts(event.target, key)) done(event, plain[key]);
  });
}

function done(event: KeyboardEvent, act: () => void): void {
  event.preventDefault();
  act();
}

const slower = (speed: number): number => [...SPEEDS].reverse().find((value) => value < speed) ?? 1;

/** Whether a key belongs to a field in which one writes. */
function types(target: EventTarget | null): boolean {
  if (target instanceof HTMLTextAreaElement || target instanceof HTMLSelectElement) return true;
  return target instanceof HTMLInputElement && !['checkbox', 'range', 'file', 'button'].includes(target.type);
}

/** Whether the focused control answers the key itself. */
function acts(target: EventTarget | null, key: string): boolean {
  if (!(target instanceof HTMLElement)) return false;
  const arrows = key.startsWith('Arrow') || key === 'Home' || key === 'End';
  if (target instanceof HTMLInputElement) return target.type === 'range' ? arrows : key === ' ';
  return key === ' ' && ['BUTTON', 'SUMMARY', 'A', 'LABEL'].includes(target.tagName);
}
