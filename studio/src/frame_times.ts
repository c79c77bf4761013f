// How long pictures take, kept for `window.mienStats` and for choosing how fine they are.
const KEPT = 1200;
const JUDGED = 12;

export interface FrameStats { pictures: number; intervals: { p50: number; p99: number }; work: { p50: number; p99: number } }

/** Milliseconds from picture to picture while the face moves, and of work for each on the page's thread. */
export class FrameTimes {
  readonly intervals: number[] = [];
  readonly work: number[] = [];
  private last: number | undefined;
  private pace: number[] = [];

  add(worked: number, busy: boolean): void {
    const now = performance.now();
    if (busy) {
      keep(this.work, worked);
      if (this.last !== undefined) {
        keep(this.intervals, now - this.last);
        this.pace.push(now - this.last);
      }
      this.last = now;
    } else this.last = undefined;
  }

  pause(): void { this.last = undefined; }
  forgetPace(): void { this.pace = []; this.last = undefined; }

  slowerThan(milliseconds: number): boolean {
    if (this.pace.length < JUDGED) return false;
    const middle = percentile(this.pace, 0.5);
    this.pace = [];
    return middle > milliseconds;
  }

  reset(): void {
    this.intervals.length = this.work.length = 0;
    this.last = undefined;
  }

  summary(): FrameStats {
    const both = (values: number[]): { p50: number; p99: number } => ({ p50: percentile(values, 0.5), p99: percentile(values, 0.99) });
    return { pictures: this.work.length, intervals: both(this.intervals), work: both(this.work) };
  }
}

function keep(values: number[], value: number): void {
  values.push(value);
  if (values.length > KEPT) values.shift();
}

export function percentile(values: readonly number[], share: number): number {
  if (values.length === 0) return NaN;
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.min(Math.floor(share * sorted.length), sorted.length - 1)] as number;
}
