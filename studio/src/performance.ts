// The frames that are shown: what the server performed, with the keys of channels laid over it, and a first guess of what
// a border or an intensity that is being dragged will do.
import { MotionClip } from 'mien-viewer';
import type { Speech } from './anchors';
import { counts, held, intensityAt, type Point } from './curves';
import { pointsOf } from './layer';
import type { Blend, ChannelFacts, Layer } from './types';

/** Lays the channel edits of a layer over frames (frames x channels), in place: what replaces first, then what is added. */
export function layOver(
  values: Float32Array, channels: readonly string[], fps: number, layer: Layer, speech: Speech, facts: ReadonlyMap<string, ChannelFacts>,
): void {
  const edits = layer.edits.flatMap((edit) => (edit.kind === 'channel' ? [edit] : []));
  edits.sort((a, b) => Number(a.mode === 'add') - Number(b.mode === 'add'));
  for (const { channel, mode, interpolation, fade, keys } of edits) {
    const column = channels.indexOf(channel);
    const points = pointsOf(keys, speech);
    if (column < 0 || points.length === 0) continue;
    const { minimum, maximum } = facts.get(channel) ?? { minimum: 0, maximum: 1 };
    for (let frame = 0, at = column; at < values.length; frame++, at += channels.length) {
      const share = counts(points, frame / fps, fade);
      if (share === 0) continue;
      const value = held(points, frame / fps, interpolation) * share;
      const moved = mode === 'replace' ? (values[at] as number) * (1 - share) + value : (values[at] as number) + value;
      values[at] = Math.min(Math.max(moved, minimum), maximum);
    }
  }
}

/** Frames as they would be if moments `from` were moved to `to` (both rising, the same number of them). */
export function warped(values: Float32Array, width: number, fps: number, from: readonly number[], to: readonly number[]): Float32Array {
  const clip = new MotionClip(Array.from({ length: width }, (_, i) => String(i)), fps, values);
  const back = to.map((at, i): Point => [at, from[i] as number]);
  const result = values.slice();
  for (let frame = 0; frame * width < values.length; frame++) {
    const source = held(back, frame / fps, 'linear');
    if (Math.abs(source - frame / fps) > 1e-9) result.set(clip.sample(source), frame * width);
  }
  return result;
}

export interface Intensity { points: readonly Point[]; blend: Blend }
const LEAST = 0.05;

/** A first guess of another intensity: what the emotion adds to a neutral performance, made more or less. */
export function reweighed(
  values: Float32Array, neutral: Float32Array, width: number, fps: number, before: Intensity, after: Intensity,
): Float32Array {
  const result = values.slice();
  for (let frame = 0; frame * width < values.length; frame++) {
    const was = before.points.length === 0 ? 0 : intensityAt(before.points, frame / fps, before.blend);
    const is = after.points.length === 0 ? 0 : intensityAt(after.points, frame / fps, after.blend);
    if (was < LEAST || was === is) continue;
    for (let i = frame * width; i < (frame + 1) * width; i++) {
      const rest = neutral[i] as number;
      result[i] = rest + ((values[i] as number) - rest) * (is / was);
    }
  }
  return result;
}

/** A guess of a line in an emotion: what that does to a face at rest, added to every frame without emotion. */
export function felt(
  neutral: Float32Array, channels: readonly string[], mask: { channels: readonly string[]; values: readonly number[] }, strength: number,
  facts: ReadonlyMap<string, ChannelFacts>,
): Float32Array {
  const result = neutral.slice();
  mask.channels.forEach((name, place) => {
    const [column, added] = [channels.indexOf(name), (mask.values[place] as number) * strength];
    if (column < 0 || added === 0) return;
    const { minimum, maximum } = facts.get(name) ?? { minimum: 0, maximum: 1 };
    for (let at = column; at < result.length; at += channels.length) result[at] = Math.min(Math.max((result[at] as number) + added, minimum), maximum);
  });
  return result;
}

/** A guess of a line articulated with another effort: the jaw opens farther or less, the lips go farther from where they are on average. */
export function articulated(values: Float32Array, channels: readonly string[], jaw: number, lips: number): Float32Array {
  const [result, width] = [values.slice(), channels.length];
  channels.forEach((name, column) => {
    const opens = name === 'jawOpen' || name === 'mouthClose';
    if (!opens && !/^(mouth|jaw)/.test(name)) return;
    const factor = opens ? jaw : lips;
    let mean = 0;
    if (!opens) for (let at = column; at < values.length; at += width) mean += ((values[at] as number) * width) / values.length;
    for (let at = column; at < result.length; at += width) result[at] = Math.min(Math.max(mean + ((values[at] as number) - mean) * factor, 0), 1);
  });
  return result;
}

/** Eyes held at a direction, degrees to the speaker's left and up, as channels of both eyes. */
export function looking([side, height]: readonly [number, number], full: { in: number; out: number; up: number; down: number }): Record<string, number> {
  const share = (degrees: number, most: number): number => Math.min(Math.max(degrees / most, 0), 1);
  return {
    eyeLookOutLeft: share(side, full.out), eyeLookInRight: share(side, full.in), eyeLookInLeft: share(-side, full.in), eyeLookOutRight: share(-side, full.out),
    eyeLookUpLeft: share(height, full.up), eyeLookUpRight: share(height, full.up), eyeLookDownLeft: share(-height, full.down), eyeLookDownRight: share(-height, full.down),
  };
}

/** Channels held at values in every frame. */
export function holding(values: Float32Array, channels: readonly string[], held: Readonly<Record<string, number>>): Float32Array {
  const result = values.slice();
  for (const [name, value] of Object.entries(held)) {
    const column = channels.indexOf(name);
    if (column >= 0) for (let at = column; at < result.length; at += channels.length) result[at] = value;
  }
  return result;
}
