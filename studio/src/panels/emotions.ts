// All emotions as pictures of the present face: pointing at one shows it, choosing one performs the line so.
import { make } from '../dom';
import type { Session } from '../session';
import type { Stage } from '../stage';
import type { Trial } from '../trial';
import type { Layer, TakeRequest } from '../types';

const SIZE = 144; // px: drawn twice as large as it is shown, so that edges are smooth

export class Emotions {
  readonly element = make('div', { class: 'feelings' });
  private readonly grid = make('div', { class: 'faces', role: 'group', 'aria-label': 'Emotion' });
  private readonly strength = make('input', { type: 'range', min: 0, max: 1, step: 0.05, value: 0.7, id: 'strength', 'aria-label': 'Strength of the emotion' });
  private readonly told = make('output', { for: 'strength' }, '70 %');
  private readonly follows = make('p', { class: 'help', hidden: true });
  private readonly buttons = new Map<string, HTMLButtonElement>();
  private drawn = '';
  chosen = '';

  /** @param feel performs the line in an emotion (`''`: none) of a strength; `felt` is what it asks the server for */
  constructor(private readonly session: Session, private readonly stage: Stage, private readonly trial: Trial, private readonly back: () => void,
    private readonly feel: (name: string, strength: number) => Promise<boolean>, private readonly felt: (name: string, strength: number) => TakeRequest & { layer?: Layer }) {
    const row = make('div', { class: 'strength' }, make('span', {}, 'Strength'), this.strength, this.told);
    this.element.append(this.grid, row, this.follows);
    this.add('', 'neutral');
    for (const name of session.about.emotions) if (name !== 'neutral') this.add(name, name);
    this.strength.addEventListener('input', () => {
      this.tell();
      this.follows.hidden = session.take === undefined || session.take.from_sound === true;
      this.follows.textContent = trial.promise;
      if (this.chosen === '' || this.chosen === 'auto') return;
      if (!trial.heard) session.showFeeling(this.chosen, this.amount);
      trial.ask(felt(this.chosen, this.amount), true);
    });
    const end = (): void => { this.follows.hidden = true; };
    this.strength.addEventListener('change', () => {
      end();
      if (this.chosen !== '' && this.chosen !== 'auto') trial.end(this.feel(this.chosen, this.amount));
    });
    trial.endsWith(this.strength, end);
    this.set('', 0.7);
  }

  get amount(): number { return Number(this.strength.value); }

  /** "As the voice sounds" is there while a recording is. */
  offerHeard(offered: boolean): void {
    const there = this.buttons.get('auto');
    if (offered && there === undefined) this.add('auto', 'as heard');
    if (!offered && there !== undefined) {
      there.remove();
      this.buttons.delete('auto');
    }
  }

  private add(name: string, label: string): void {
    const { trial } = this;
    const press = make('button', { type: 'button', class: 'feeling', 'data-emotion': name, 'aria-pressed': 'false', title: label },
      name === 'auto' ? make('span', { class: 'heard', 'aria-hidden': 'true' }, '♪') : make('canvas', { width: SIZE, height: SIZE, 'aria-hidden': 'true' }), make('span', {}, label));
    press.addEventListener('pointerenter', (event) => { if (event.pointerType === 'mouse') this.point(name); });
    press.addEventListener('pointerleave', (event) => {
      if (event.pointerType !== 'mouse') return;
      this.back();
      trial.end();
    });
    press.addEventListener('click', () => {
      this.set(name, this.amount || 0.7);
      if (name !== 'auto') this.session.showFeeling(name, this.amount);
      trial.end(this.feel(name, this.amount));
    });
    this.buttons.set(name, press);
    this.grid.append(press);
  }

  /** Shows one while the pointer is over it. */
  private point(name: string): void {
    if (this.session.working || name === 'auto') return;
    if (this.session.take === undefined) this.stage.mask(this.session.mask(name), this.amount || 0.7);
    else {
      this.session.showFeeling(name, this.amount || 0.7);
      this.trial.ask(this.felt(name, this.amount || 0.7), false);
    }
  }

  /** What is chosen, without performing it. */
  set(name: string, strength: number): void {
    this.chosen = name;
    this.strength.value = String(strength);
    this.strength.disabled = name === '' || name === 'auto';
    for (const [other, press] of this.buttons) press.setAttribute('aria-pressed', String(other === name));
    this.tell();
  }

  private tell(): void { this.told.textContent = `${Math.round(this.amount * 100)} %`; }

  /** Draws the pictures on the face that is shown, one a moment so that nothing waits for them. */
  async draw(face: string): Promise<void> {
    if (this.session.expressions === undefined || this.drawn === face) return;
    this.drawn = face;
    for (const [name, press] of this.buttons) {
      const canvas = press.querySelector('canvas');
      if (canvas === null) continue;
      await new Promise((resolve) => setTimeout(resolve, 30));
      if (this.drawn !== face) return;
      this.stage.portrait(canvas, this.session.mask(name));
    }
  }
}
