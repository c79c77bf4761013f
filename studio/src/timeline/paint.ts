// What lanes show.
import type { MotionClip } from 'mien-viewer';
import { PAUSES } from '../anchors';
import { intensityAt, type Point } from '../curves';
import type { Blend, Span } from '../types';
import type { Brush } from './lane';

const STEPS = [0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 30];

export function paintRuler({ context, width, height, window, colour }: Brush, loop: readonly [number, number] | null): void {
  if (loop !== null) {
    context.fillStyle = colour('loop');
    context.fillRect(window.x(loop[0]), 0, window.x(loop[1]) - window.x(loop[0]), height);
  }
  const step = STEPS.find((seconds) => (seconds / window.span) * width > 64) ?? 60;
  context.fillStyle = context.strokeStyle = colour('quiet');
  context.font = '11px system-ui, sans-serif';
  context.textBaseline = 'middle';
  for (let tick = Math.ceil(window.first / step); tick * step <= window.last; tick++) {
    const x = Math.round(window.x(tick * step)) + 0.5;
    context.globalAlpha = 0.5;
    context.beginPath();
    context.moveTo(x, height - 5);
    context.lineTo(x, height);
    context.stroke();
    context.globalAlpha = 1;
    context.fillText((tick * step).toFixed(step < 0.1 ? 2 : step < 1 ? 1 : 0), x + 4, height / 2);
  }
}

/** Lowest and highest sample of stretches of a sound, so that drawing does not read all of it. */
export class Waveform {
  private readonly low: Float32Array;
  private readonly high: Float32Array;
  private readonly rate: number;
  private readonly loudest: number;

  constructor(samples: Float32Array, rate: number, private readonly block = 64) {
    const count = Math.ceil(samples.length / block);
    this.low = new Float32Array(count);
    this.high = new Float32Array(count);
    this.rate = rate;
    let loudest = 0.05;
    for (let i = 0; i < samples.length; i++) {
      const place = Math.floor(i / block);
      const value = samples[i] as number;
      if (value < (this.low[place] as number)) this.low[place] = value;
      if (value > (this.high[place] as number)) this.high[place] = value;
      loudest = Math.max(loudest, Math.abs(value));
    }
    this.loudest = loudest;
  }

  paint({ context, width, height, window, colour }: Brush): void {
    const middle = height / 2;
    const scale = (middle - 2) / this.loudest;
    context.fillStyle = colour('wave');
    for (let x = 0; x < width; x++) {
      const first = Math.floor((window.seconds(x) * this.rate) / this.block);
      const last = Math.max(first + 1, Math.ceil((window.seconds(x + 1) * this.rate) / this.block));
      let [low, high] = [0, 0];
      for (let i = Math.max(first, 0); i < Math.min(last, this.low.length); i++) {
        low = Math.min(low, this.low[i] as number);
        high = Math.max(high, this.high[i] as number);
      }
      context.fillRect(x, middle - high * scale - 0.5, 1, (high - low) * scale + 1);
    }
  }
}

/** As much of a name as there is room for; an ellipsis says that there is more of it. */
function fitting(context: CanvasRenderingContext2D, name: string, room: number): string {
  if (context.measureText(name).width <= room) return name;
  for (let length = name.length - 1; length >= 0; length--) {
    const shown = `${name.slice(0, length)}…`;
    if (context.measureText(shown).width <= room) return shown;
  }
  return '';
}

export function paintSpans({ context, height, window, colour }: Brush, spans: readonly Span[], kind: 'word' | 'phone'): void {
  context.font = kind === 'word' ? '600 12px system-ui, sans-serif' : '11px ui-monospace, monospace';
  context.textAlign = 'center';
  context.textBaseline = 'middle';
  for (const [begin, end, label] of spans) {
    if (end < window.first || begin > window.last) continue;
    const [left, right] = [window.x(begin), window.x(end)];
    if (PAUSES.has(label)) continue;
    context.fillStyle = colour(kind);
    context.beginPath();
    context.roundRect(left + 0.5, 1.5, Math.max(right - left - 1, 1), height - 3, 3);
    context.fill();
    context.fillStyle = colour('ink');
    context.fillText(fitting(context, label, right - left - 2), (left + right) / 2, height / 2 + 0.5);
  }
  context.textAlign = 'start';
}

export function paintIntensity(brush: Brush, points: readonly Point[], blend: Blend, [low, high]: readonly [number, number]): void {
  const { context, width, height, window, colour } = brush;
  const level = (value: number, tall: number): number => levelOf((value - low) / (high - low), tall);
  paintScale(brush, [low, high], (value) => `${Math.round(value * 100)} %`);
  if (points.length === 0) return;
  context.beginPath();
  context.moveTo(0, height);
  for (let x = 0; x <= width; x += 2) context.lineTo(x, level(intensityAt(points, window.seconds(x), blend), height));
  context.lineTo(width, height);
  context.closePath();
  context.fillStyle = colour('emotion-fill');
  context.fill();
  context.beginPath();
  for (let x = 0; x <= width; x += 2) context.lineTo(x, level(intensityAt(points, window.seconds(x), blend), height));
  context.strokeStyle = colour('emotion');
  context.lineWidth = 1.5;
  context.stroke();
}

const INSET = 9; // px: as the handles' layer in style.css
const levelOf = (share: number, height: number): number => height - INSET - share * (height - 2 * INSET);
const TALL = 90; // px: from here on there is room for a scale

/** Lines and values at the left of a tall lane. */
function paintScale({ context, width, height, colour }: Brush, [low, high]: readonly [number, number], text: (value: number) => string): void {
  if (height < TALL) return;
  context.font = '10px system-ui, sans-serif';
  context.textBaseline = 'middle';
  for (const share of [0, 0.25, 0.5, 0.75, 1]) {
    const y = Math.round(levelOf(share, height)) + 0.5;
    context.strokeStyle = colour('line');
    context.globalAlpha = 0.6;
    context.lineWidth = 1;
    context.beginPath();
    context.moveTo(0, y);
    context.lineTo(width, y);
    context.stroke();
    context.globalAlpha = 1;
    context.fillStyle = colour('quiet');
    context.fillText(text(low + share * (high - low)), 2, y - 6);
  }
}

/** A channel over time, from its lowest to its highest value. */
export function paintChannel(brush: Brush, clip: MotionClip, channel: string, range: readonly [number, number], other = false): void {
  const { context, width, height, window, colour } = brush;
  const column = clip.channels.indexOf(channel);
  if (column < 0) return;
  const share = (value: number): number => levelOf((value - range[0]) / (range[1] - range[0]), height);
  if (!other) paintScale(brush, range, (value) => value.toFixed(range[1] - range[0] > 2 ? 0 : 2));
  if (range[0] < 0 && !other) {
    context.strokeStyle = colour('line');
    context.beginPath();
    context.moveTo(0, share(0));
    context.lineTo(width, share(0));
    context.stroke();
  }
  context.beginPath();
  for (let x = 0; x <= width; x += 1) {
    const frame = Math.min(Math.max(window.seconds(x) * clip.fps, 0), clip.frames - 1);
    const before = Math.floor(frame);
    const from = clip.values[before * clip.channels.length + column] as number;
    const to = clip.values[Math.min(before + 1, clip.frames - 1) * clip.channels.length + column] as number;
    context.lineTo(x, share(from + (frame - before) * (to - from)));
  }
  context.strokeStyle = colour(other ? 'quiet' : 'channel');
  context.setLineDash(other ? [4, 3] : []);
  context.lineWidth = 1.5;
  context.stroke();
  context.setLineDash([]);
}
