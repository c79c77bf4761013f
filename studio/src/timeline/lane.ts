// One row of the timeline: a head with its name, a canvas, and a layer for handles.
import { make, type Child } from '../dom';
import type { TimeWindow } from './window';

export interface Brush { context: CanvasRenderingContext2D; width: number; height: number; window: TimeWindow; colour: (name: string) => string }

export class Lane {
  readonly element: HTMLElement;
  readonly body: HTMLElement;
  readonly layer: HTMLElement;
  readonly head: HTMLElement;
  private readonly canvas = make('canvas', { 'aria-hidden': 'true' });

  constructor(
    readonly name: string, readonly kind: string, private readonly window: TimeWindow, private readonly paint: (brush: Brush) => void,
    label: string, ...controls: Child[]
  ) {
    this.head = make('div', { class: 'head' }, make('span', { class: 'name', title: name }, label), ...controls);
    this.layer = make('div', { class: 'handles' });
    this.body = make('div', { class: 'body' }, this.canvas, this.layer);
    this.element = make('div', { class: `lane ${kind}`, role: 'group', 'aria-label': name, 'data-lane': name }, this.head, this.body);
  }

  draw(): void {
    const { clientWidth: width, clientHeight: height } = this.body;
    if (width === 0 || height === 0) return;
    const fine = Math.min(globalThis.devicePixelRatio, 2);
    if (this.canvas.width !== Math.round(width * fine) || this.canvas.height !== Math.round(height * fine)) {
      this.canvas.width = Math.round(width * fine);
      this.canvas.height = Math.round(height * fine);
    }
    const context = this.canvas.getContext('2d') as CanvasRenderingContext2D;
    context.setTransform(fine, 0, 0, fine, 0, 0);
    context.clearRect(0, 0, width, height);
    const style = getComputedStyle(this.element);
    this.paint({ context, width, height, window: this.window, colour: (name) => style.getPropertyValue(`--${name}`).trim() });
  }
}
