// How it is said beside the emotion: effort, the voice's share of the emotion, where the eyes are. Each shows at once.
import { button, make } from '../dom';
import { looking } from '../performance';
import type { Session } from '../session';
import type { Stage } from '../stage';
import type { Trial } from '../trial';

const EFFORTS: readonly (readonly [string, number])[] = [['mumbled', 0.4], ['relaxed', 0.7], ['as it is', 1], ['clear', 1.4], ['overdone', 1.9]];
const PAD: readonly (readonly [string, string, string])[] = [
  ['upright', '↖', 'up to your left'], ['up', '↑', 'up'], ['upleft', '↗', 'up to your right'], ['right', '←', 'to your left'], ['camera', '●', 'at the camera'],
  ['left', '→', 'to your right'], ['downright', '↙', 'down to your left'], ['down', '↓', 'down'], ['downleft', '↘', 'down to your right'],
];
const LEADING = /^\s*<gaze target="(\w+)"\/>\s*/;

/** Where a text has the eyes from its beginning on; `''`: nowhere in particular. */
export const gazeOf = (text: string): string => LEADING.exec(text)?.[1] ?? '';
export const withGaze = (text: string, target: string): string => `${target === '' ? '' : `<gaze target="${target}"/> `}${text.replace(LEADING, '')}`;

export class Manner {
  readonly element = make('div', { class: 'manner' });
  private readonly effort = make('input', { type: 'range', min: 0, max: 2, step: 0.05, value: 1, id: 'field-effort', 'aria-describedby': 'fault-effort' });
  private readonly effortTold = make('output', { for: 'field-effort' });
  private readonly voice = make('input', { type: 'range', min: 0, max: 1, step: 0.05, value: 1, id: 'field-voice_emotion', 'aria-describedby': 'fault-voice_emotion' });
  private readonly voiceTold = make('output', { for: 'field-voice_emotion' });
  private readonly follows = make('p', { class: 'help', hidden: true });
  private readonly efforts: HTMLButtonElement[];
  private readonly eyes: HTMLButtonElement[];
  private was = 1; // the effort that is performed
  private asked: '' | 'auto' | 'hand' = ''; // who sets the effort: the emotion or else the voice, the voice whatever is felt, the slider

  /** @param changed performs the line as the controls have it; `hear`: one wants to hear it too */
  constructor(private readonly session: Session, private readonly stage: Stage, trial: Trial, private readonly back: () => void, private readonly gaze: (target: string) => void, private readonly changed: (hear: boolean) => Promise<boolean>) {
    this.efforts = [this.byItself('', 'by itself', 'Effort as the emotion has it, or else the recording'), this.byItself('auto', 'as the voice', 'Effort as it is heard in the recording, whatever is felt'), ...EFFORTS.map(([label, value]) => this.preset(label, value))];
    this.eyes = PAD.map(([target, sign, what]) => this.direction(target, sign, what));
    const own = button('Own glances', () => this.gaze(''), { class: 'small', 'data-gaze': '', title: 'The eyes move by themselves' });
    this.eyes.push(own);
    const fault = (name: string): HTMLElement => make('p', { class: 'fault', id: `fault-${name}`, role: 'alert', hidden: true });
    this.element.append(
      make('h3', { id: 'effort-title' }, 'Effort'), make('div', { class: 'presets', role: 'group', 'aria-labelledby': 'effort-title' }, ...this.efforts),
      make('div', { class: 'strength', 'data-field': 'effort' }, make('label', { for: 'field-effort' }, 'How hard'), this.effort, this.effortTold), fault('effort'),
      make('h3', { id: 'eyes-title' }, 'Eyes'), make('div', { class: 'eyes' }, make('div', { class: 'pad', role: 'group', 'aria-labelledby': 'eyes-title' }, ...this.eyes.slice(0, -1)), make('div', {}, own, make('p', { class: 'help' }, 'For the whole line. Inside it: the tag <gaze target="left"/>.'))),
      make('h3', {}, 'Emotion in the voice'),
      make('div', { class: 'strength', 'data-field': 'voice_emotion' }, make('label', { for: 'field-voice_emotion' }, 'How much'), this.voice, this.voiceTold), this.follows, fault('voice_emotion'));
    this.effort.addEventListener('input', () => { this.asked = 'hand'; this.tell(); session.showEffort(this.was, Number(this.effort.value)); });
    this.effort.addEventListener('change', () => void this.changed(false));
    const end = (): void => { this.follows.hidden = true; };
    this.voice.addEventListener('input', () => {
      this.tell();
      this.follows.hidden = session.take === undefined;
      this.follows.textContent = trial.promise;
      trial.ask({ voice_emotion: Number(this.voice.value) }, true);
    });
    this.voice.addEventListener('change', () => { end(); trial.end(this.changed(true), true); });
    trial.endsWith(this.voice, end);
    this.tell();
  }

  private byItself(asked: '' | 'auto', label: string, title: string): HTMLButtonElement {
    return button(label, () => { this.asked = asked; this.effort.value = '1'; this.tell(); void this.changed(false); }, { class: 'small', 'data-effort': asked, title });
  }

  private preset(label: string, value: number): HTMLButtonElement {
    const press = button(label, () => { this.asked = 'hand'; this.effort.value = String(value); this.tell(); this.session.showEffort(this.was, value); void this.changed(false); }, { class: 'small', 'data-effort': value, title: `Effort ${value}` });
    this.hover(press, () => this.session.showEffort(this.was, value));
    return press;
  }

  private direction(target: string, sign: string, what: string): HTMLButtonElement {
    const held = looking(this.session.about.gazes[target] ?? [0, 0], this.session.about.gaze_degrees);
    const press = button(`Eyes ${what}`, () => this.gaze(target), { class: 'small', 'data-gaze': target, title: what }, sign);
    this.hover(press, () => {
      if (this.session.take === undefined) this.stage.mask({ channels: Object.keys(held), values: Object.values(held) }, 1);
      else this.session.showHeld(held);
    });
    return press;
  }

  /** Shows something while the pointer is over a button. */
  private hover(press: HTMLButtonElement, show: () => void): void {
    press.addEventListener('pointerenter', (event) => { if (event.pointerType === 'mouse' && !this.session.working) show(); });
    press.addEventListener('pointerleave', (event) => { if (event.pointerType === 'mouse') this.back(); });
  }

  /** As it is sent. */
  get request(): { effort: string; voice_emotion: number } {
    return { effort: this.asked === 'hand' ? this.effort.value : this.asked, voice_emotion: Number(this.voice.value) };
  }

  /** Shows what a take was asked for, without performing it. */
  set(effort: string, voice: number, text: string): void {
    this.asked = /^[\d.]+$/.test(effort) ? 'hand' : effort === 'auto' ? 'auto' : '';
    this.was = this.asked === 'hand' ? Number(effort) : 1;
    this.effort.value = String(this.was);
    this.voice.value = String(voice);
    this.look(text);
    this.tell();
  }

  /** Marks where a text has the eyes. */
  look(text: string): void {
    const now = gazeOf(text);
    for (const press of this.eyes) press.setAttribute('aria-pressed', String(press.dataset['gaze'] === now));
  }

  /** A recording has its own voice. */
  withRecording(there: boolean): void {
    this.voice.disabled = there;
    if (!there && this.asked === 'auto') this.asked = '';
    for (const press of this.efforts) if (press.dataset['effort'] === 'auto') press.hidden = !there;
    this.tell();
  }

  private tell(): void {
    this.effortTold.textContent = this.asked === '' ? 'by itself' : this.asked === 'auto' ? 'voice' : Number(this.effort.value).toFixed(2);
    this.voiceTold.textContent = `${Math.round(Number(this.voice.value) * 100)} %`;
    for (const press of this.efforts) {
      const { effort } = press.dataset;
      press.setAttribute('aria-pressed', String(this.asked === 'hand' ? effort !== '' && Number(effort) === Number(this.effort.value) : effort === this.asked));
    }
  }
}
