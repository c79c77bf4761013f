// Which part of the line is seen, and where seconds lie on the screen.
import { Events } from '../events';

const CLOSEST = 0.15; // s over the whole width
const MARGIN = 12; // px on both sides, so that what stands at the ends can be taken hold of

export class TimeWindow extends Events<{ change: void }> {
  first = 0;
  last = 1;
  width = 1000;
  private total = 1;

  /** The length of the line; `stay` keeps what is seen, unless that was all. */
  setTotal(seconds: number, stay = false): void {
    const all = this.span >= this.total - 1e-6;
    this.total = Math.max(seconds, CLOSEST);
    if (stay && !all) this.show(this.first, this.last);
    else this.show(0, this.total);
  }

  setWidth(pixels: number): void {
    if (pixels === this.width || pixels <= 2 * MARGIN) return;
    this.width = pixels;
    this.emit('change', undefined);
  }

  get span(): number { return this.last - this.first; }
  x(seconds: number): number { return MARGIN + ((seconds - this.first) / this.span) * (this.width - 2 * MARGIN); }
  seconds(x: number): number { return this.first + ((x - MARGIN) / (this.width - 2 * MARGIN)) * this.span; }
  holds(seconds: number, margin = 0): boolean { return seconds >= this.first - margin && seconds <= this.last + margin; }

  show(first: number, last: number): void {
    const span = Math.min(Math.max(last - first, CLOSEST), this.total);
    this.first = Math.min(Math.max(first, 0), this.total - span);
    this.last = this.first + span;
    this.emit('change', undefined);
  }

  fit(): void { this.show(0, this.total); }

  zoom(factor: number, about: number): void {
    const span = this.span * factor;
    const share = (about - this.first) / this.span;
    this.show(about - share * span, about + (1 - share) * span);
  }

  pan(seconds: number): void { this.show(this.first + seconds, this.last + seconds); }

  /** Turns the page when the playhead leaves it. */
  follow(seconds: number): void {
    if (this.span >= this.total - 1e-6 || this.holds(seconds)) return;
    this.show(seconds - 0.1 * this.span, seconds + 0.9 * this.span);
  }
}
