// Things on a lane that can be dragged, with pointer or keys. One lane is one stop of the Tab key; Ctrl+arrows go from
// handle to handle.
import { make } from '../dom';
import type { TimeWindow } from './window';

export interface HandleFacts {
  key: string;
  at: number; // s
  value?: number; // 0..1 of the lane's height; without it the handle is a bar over the whole height
  label: string;
  text: string;
  range?: [number, number]; // s
  edited?: boolean;
  fixed?: boolean; // stays at its moment
  chosen?: boolean;
  shape?: string; // of a key: its tangent
}

export interface HandleEvents {
  drag: (handle: HandleFacts, at: number, value: number) => void;
  drop: (handle: HandleFacts, at: number, value: number) => void;
  remove?: (handle: HandleFacts) => void;
  reset?: (handle: HandleFacts) => void;
  /** Pressed with the pointer, maybe with Shift or Ctrl: what is chosen changes. */
  choose?: (handle: HandleFacts, further: boolean) => void;
  /** Moved by keys, in frames and in shares of the height. */
  nudge?: (handle: HandleFacts, frames: number, share: number) => void;
}

const NEAR = 3.5; // px between bars: of those nearer than that only one is there to take hold of
const VALUE_STEP = 0.05;

export class Handles {
  private shown = new Map<string, HTMLElement>();
  private facts: HandleFacts[] = [];
  private current = '';
  dragging: string | undefined;

  constructor(
    readonly layer: HTMLElement, private readonly window: TimeWindow, private readonly events: HandleEvents,
    private readonly frame: () => number,
  ) {
    layer.addEventListener('keydown', (event) => this.press(event));
  }

  set(facts: HandleFacts[]): void {
    this.facts = facts;
    this.place();
  }

  get keys(): string[] { return this.facts.map(({ key }) => key); }

  /** Puts the elements where they belong; makes those that are seen and takes away the others. */
  place(): void {
    const inside = this.facts.filter(({ at }) => this.window.holds(at, this.window.span * 0.01));
    if (!inside.some(({ key }) => key === this.current)) this.current = inside[0]?.key ?? '';
    const seen = this.apart(inside);
    const wanted = new Set(seen.map(({ key }) => key));
    for (const [key, element] of this.shown) {
      if (wanted.has(key) || key === this.dragging) continue;
      element.remove();
      this.shown.delete(key);
    }
    for (const facts of seen) {
      const element = this.shown.get(facts.key) ?? this.add(facts.key);
      const x = this.window.x(facts.at);
      describe(element, facts, x);
      element.tabIndex = facts.key === this.current ? 0 : -1;
    }
  }

  /** Without the bars that stand too near to the one before to be told apart; the one that has the focus stays. */
  private apart(facts: HandleFacts[]): HandleFacts[] {
    let before = -Infinity;
    return facts.filter(({ key, at, value }) => {
      const x = this.window.x(at);
      const kept = value !== undefined || x - before >= NEAR || key === this.current || key === this.dragging;
      if (kept) before = x;
      return kept;
    });
  }

  focus(key: string): void {
    this.current = key;
    this.place();
    this.shown.get(key)?.focus({ preventScroll: true });
  }

  private add(key: string): HTMLElement {
    const element = make('div', { class: 'handle', role: 'slider', tabindex: -1, 'data-key': key });
    element.addEventListener('pointerdown', (event) => this.grab(event, key, element));
    element.addEventListener('focus', () => {
      this.current = key;
      for (const [other, shown] of this.shown) shown.tabIndex = other === key ? 0 : -1;
    });
    element.addEventListener('dblclick', (event) => {
      event.stopPropagation();
      const facts = this.find(key);
      if (facts !== undefined) (this.events.remove ?? this.events.reset)?.(facts);
    });
    this.layer.append(element);
    this.shown.set(key, element);
    return element;
  }

  private find(key: string): HandleFacts | undefined { return this.facts.find((facts) => facts.key === key); }

  private grab(event: PointerEvent, key: string, element: HTMLElement): void {
    const facts = this.find(key);
    if (facts === undefined || event.button !== 0) return;
    event.preventDefault();
    event.stopPropagation();
    element.focus({ preventScroll: true });
    const further = event.shiftKey || event.ctrlKey || event.metaKey;
    this.events.choose?.(facts, further);
    if (further) return;
    element.setPointerCapture(event.pointerId);
    element.classList.add('dragged');
    this.dragging = key;
    const area = this.layer.getBoundingClientRect();
    const offset = event.clientX - area.left - this.window.x(facts.at);
    let [at, value, moved] = [facts.at, facts.value ?? 0, false];
    const move = (to: PointerEvent): void => {
      if (!moved && Math.hypot(to.clientX - event.clientX, to.clientY - event.clientY) < 3) return;
      moved = true;
      at = facts.fixed === true ? facts.at : inside(this.window.seconds(to.clientX - area.left - offset), facts.range);
      value = Math.min(Math.max(1 - (to.clientY - area.top) / area.height, 0), 1);
      describe(element, { ...facts, at, ...(facts.value === undefined ? {} : { value }) }, this.window.x(at));
      this.events.drag(facts, at, value);
    };
    const end = (): void => {
      element.removeEventListener('pointermove', move);
      element.classList.remove('dragged');
      this.dragging = undefined;
      if (moved) this.events.drop(facts, at, value);
      this.place();
    };
    element.addEventListener('pointermove', move);
    element.addEventListener('pointerup', end, { once: true });
    element.addEventListener('pointercancel', end, { once: true });
  }

  private press(event: KeyboardEvent): void {
    const key = (event.target as HTMLElement).dataset['key'];
    const facts = key === undefined ? undefined : this.find(key);
    if (facts === undefined || event.metaKey) return;
    if (event.ctrlKey) {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      const next = step === undefined ? undefined : this.facts[this.facts.indexOf(facts) + step];
      if (step !== undefined) done(event);
      if (next === undefined) return;
      if (!this.window.holds(next.at)) this.window.pan(next.at - facts.at);
      this.focus(next.key);
      return;
    }
    const time = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    const height = { ArrowUp: 1, ArrowDown: -1 }[event.key];
    if (this.events.nudge !== undefined && (time !== undefined || height !== undefined)) {
      done(event);
      this.events.nudge(facts, (time ?? 0) * (event.shiftKey ? 5 : 1), (height ?? 0) * VALUE_STEP * (event.shiftKey ? 4 : 1) * (event.altKey ? 0.2 : 1));
    } else if (time !== undefined && facts.fixed !== true) {
      done(event);
      this.events.drop(facts, inside(facts.at + time * this.frame() * (event.shiftKey ? 5 : 1), facts.range), facts.value ?? 0);
    } else if (height !== undefined && facts.value !== undefined) {
      done(event);
      const step = height * VALUE_STEP * (event.shiftKey ? 4 : 1);
      this.events.drop(facts, facts.at, Math.min(Math.max(facts.value + step, 0), 1));
    } else if (event.key === 'Delete' || event.key === 'Backspace') {
      done(event);
      (this.events.remove ?? this.events.reset)?.(facts);
    }
  }
}

function done(event: Event): void {
  event.preventDefault();
  event.stopPropagation();
}

const inside = (at: number, range?: [number, number]): number => (range === undefined ? at : Math.min(Math.max(at, range[0]), range[1]));

function describe(element: HTMLElement, { at, value, label, text, range, edited, chosen, shape }: HandleFacts, x: number): void {
  element.style.transform = `translateX(${x}px)`;
  element.classList.toggle('point', value !== undefined);
  element.classList.toggle('edited', edited === true);
  element.classList.toggle('chosen', chosen === true);
  if (shape !== undefined) element.dataset['tangent'] = shape;
  if (value !== undefined) element.style.top = `${(1 - value) * 100}%`;
  element.setAttribute('aria-label', label);
  element.setAttribute('aria-valuetext', chosen === true ? `${text}, chosen` : text);
  element.setAttribute('aria-valuenow', (value ?? at).toFixed(3));
  element.setAttribute('aria-valuemin', String(value === undefined ? range?.[0] ?? 0 : 0));
  element.setAttribute('aria-valuemax', String(value === undefined ? range?.[1] ?? at : 1));
  element.title = `${label}: ${text}`;
}
