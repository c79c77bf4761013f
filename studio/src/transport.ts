// Play, step, speed, loop, undo.
import { button, icon, ICONS, make, options } from './dom';
import { SPEEDS, type Playback } from './playback';
import type { Session } from './session';

export function transport(playback: Playback, session: Session, live: HTMLElement, help: () => void): HTMLElement {
  const play = button('Play', () => playback.toggle(), { class: 'play', 'data-do': 'play' }, icon(ICONS.play, true));
  const clock = make('output', { class: 'clock', 'aria-label': 'Time' });
  const frame = make('span', { class: 'frame' });
  const speed = make('select', { 'aria-label': 'Speed' });
  options(speed, SPEEDS.map((value): [string, string] => [String(value), value === 1 ? '1×' : `${value}×`]), '1');
  speed.addEventListener('change', () => { playback.speed = Number(speed.value); });
  const loop = button('Loop', () => toggleLoop(playback), { 'aria-pressed': 'false', 'data-do': 'loop' }, icon(ICONS.loop));
  const undo = button('Undo', () => session.undo(), { 'data-do': 'undo', disabled: true, title: 'Undo (Ctrl+Z)' }, icon(ICONS.undo));
  const redo = button('Redo', () => session.redoEdit(), { 'data-do': 'redo', disabled: true, title: 'Redo (Ctrl+Y)' }, icon(ICONS.redo));

  const tell = (seconds: number): void => {
    clock.textContent = `${seconds.toFixed(2)} / ${playback.seconds.toFixed(2)} s`;
    frame.textContent = `frame ${Math.min(Math.floor(seconds * playback.fps + 1e-6), Math.max((session.take?.frames ?? 1) - 1, 0))}`;
  };
  playback.on('time', tell);
  playback.on('state', () => {
    const { playing } = playback;
    play.replaceChildren(icon(playing ? ICONS.pause : ICONS.play, true));
    play.setAttribute('aria-label', playing ? 'Pause' : 'Play');
    play.title = playing ? 'Pause (Space)' : 'Play (Space)';
    loop.setAttribute('aria-pressed', String(playback.loop !== null));
    speed.value = String(playback.speed);
    tell(playback.now);
  });
  session.on('layer', () => { undo.disabled = !session.canUndo; redo.disabled = !session.canRedo; });
  tell(0);
  return make('div', { class: 'transport', role: 'toolbar', 'aria-label': 'Playback' },
    button('To the start', () => playback.seek(playback.loop?.[0] ?? 0), { 'data-do': 'start' }, icon(ICONS.start)),
    button('One frame back', () => playback.step(-1), { 'data-do': 'back', title: 'One frame back (,)' }, icon(ICONS.back)),
    play,
    button('One frame on', () => playback.step(1), { 'data-do': 'on', title: 'One frame on (.)' }, icon(ICONS.on)),
    make('div', { class: 'times' }, clock, frame), speed, loop,
    make('span', { class: 'gap' }), undo, redo, make('span', { class: 'gap wide' }), live,
    button('Shortcuts', help, { 'data-do': 'help', title: 'Shortcuts (?)' }, icon(ICONS.help)));
}

/** Switches the loop on over what is seen around the playhead, or off. */
export function toggleLoop(playback: Playback): void {
  playback.setLoop(playback.loop === null ? [0, playback.seconds] : null);
}
