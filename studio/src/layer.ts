// The layer of edits, changed by pure functions.
import { same, type Speech } from './anchors';
import type { Point } from './curves';
import type { Blend, BorderEdit, ChannelEdit, Edit, Emotion, IntensityEdit, Key, Layer, Place, Span } from './types';

export const FADE = 0.1; // s
export const SHORTEST = 0.01; // s: no phone is pulled shorter
const SHIFT_STEP = 1e-4;

const withEdits = (layer: Layer, edits: Edit[]): Layer => ({ ...layer, edits });
const round = (value: number): number => Math.round(value * 1e6) / 1e6;

export function channelEdit(layer: Layer, channel: string): ChannelEdit | undefined {
  return layer.edits.find((edit): edit is ChannelEdit => edit.kind === 'channel' && edit.channel === channel);
}

export function intensityEdit(layer: Layer, emotion: string): IntensityEdit | undefined {
  return layer.edits.find((edit): edit is IntensityEdit => edit.kind === 'intensity' && edit.emotion === emotion);
}

/** Keys as points in seconds, in order; those that are tied to nothing in this line are left out. */
export function pointsOf(keys: readonly Key[], speech: Speech): Point[] {
  return keys
    .flatMap(({ anchor, value, tangent }): Point[] => {
      const at = speech.moment(anchor);
      return at === undefined ? [] : [[at, value, ...(tangent === undefined ? [] : [tangent] as const)] as Point];
    })
    .sort((a, b) => a[0] - b[0]);
}

const keysOf = (points: readonly Point[], speech: Speech): Key[] =>
  [...points].sort((a, b) => a[0] - b[0]).map(([at, value, tangent]) => ({ anchor: speech.anchor(at), value: round(value), ...(tangent === undefined ? {} : { tangent }) }));

/** The keys of a channel set to these points; none takes the edit away. */
export function setChannel(
  layer: Layer, channel: string, points: readonly Point[], speech: Speech, mode: 'add' | 'replace',
): Layer {
  const others = layer.edits.filter((edit) => edit.kind !== 'channel' || edit.channel !== channel);
  if (points.length === 0) return withEdits(layer, others);
  const before = channelEdit(layer, channel);
  return withEdits(layer, [...others, {
    kind: 'channel', channel, mode, interpolation: before?.interpolation ?? 'smooth', fade: before?.fade ?? FADE,
    keys: keysOf(points, speech),
  }]);
}

/** The intensity of an emotion set to these points; none takes the edit away. */
export function setIntensity(
  layer: Layer, emotion: string, points: readonly Point[], speech: Speech, interpolation: Blend = 'linear',
): Layer {
  const others = layer.edits.filter((edit) => edit.kind !== 'intensity' || edit.emotion !== emotion);
  if (points.length === 0) return withEdits(layer, others);
  return withEdits(layer, [...others, { kind: 'intensity', emotion, interpolation, points: keysOf(points, speech) }]);
}

/** What an emotion is now: the edit, or else what the take was asked for. */
export function intensityOf(layer: Layer, emotion: Emotion | undefined, name: string, speech: Speech): { points: Point[]; blend: Blend } {
  const edit = intensityEdit(layer, name);
  if (edit !== undefined) return { points: pointsOf(edit.points, speech), blend: edit.interpolation };
  return { points: emotion?.points ?? [], blend: emotion?.interpolation ?? 'linear' };
}

/** A border between two phones: `place` is the phone that ends there. */
export interface Border { place: number; at: number; phone: Place; edge: 'start' | 'end' }

export function bordersOf(speech: Speech): Border[] {
  return speech.phones.slice(0, -1).flatMap(([, end], place): Border[] => {
    const [before, after] = [speech.stretches[place]?.place, speech.stretches[place + 1]?.place];
    if (before?.phone !== undefined) return [{ place, at: end, phone: before, edge: 'end' }];
    return after?.phone === undefined ? [] : [{ place, at: end, phone: after, edge: 'start' }];
  });
}

export function borderEdit(layer: Layer, { phone, edge }: Pick<Border, 'phone' | 'edge'>): BorderEdit | undefined {
  return layer.edits.find((edit): edit is BorderEdit => edit.kind === 'border' && edit.edge === edge && same(edit.phone, phone));
}

/** A border moved `by` seconds from where it is now. */
export function moveBorder(layer: Layer, border: Border, by: number): Layer {
  const before = borderEdit(layer, border);
  const shift = round((before?.shift ?? 0) + by);
  const others = layer.edits.filter((edit) => edit !== before);
  if (Math.abs(shift) < SHIFT_STEP) return withEdits(layer, others);
  return withEdits(layer, [...others, { kind: 'border', phone: border.phone, edge: border.edge, shift }]);
}

/** How far the border after phone `place` may be moved to. */
export function borderRoom(phones: readonly Span[], place: number): [number, number] {
  const [before, after] = [phones[place] as Span, phones[place + 1] as Span];
  return [before[0] + SHORTEST, after[1] - SHORTEST];
}

/** Phones and words with the border after phone `place` at another moment. */
export function withBorder(words: readonly Span[], phones: readonly Span[], place: number, at: number): { words: Span[]; phones: Span[] } {
  const old = (phones[place] as Span)[1];
  const moved = ([begin, end, label]: Span): Span => [begin === old ? at : begin, end === old ? at : end, label];
  return { words: words.map(moved), phones: phones.map(moved) };
}

export function without(layer: Layer, place: number): Layer {
  return withEdits(layer, layer.edits.filter((_, i) => i !== place));
}

/** What asks for a new performance, as opposed to channel keys, which are laid over it. */
export function performed(layer: Layer): string {
  return JSON.stringify(layer.edits.filter(({ kind }) => kind !== 'channel').map((edit) => JSON.stringify(edit)).sort());
}

/** One line for a person. */
export function describe(edit: Edit): string {
  if (edit.kind === 'border') {
    const { word, occurrence, phone } = edit.phone;
    const which = (occurrence ?? 1) > 1 ? ` (${occurrence}.)` : '';
    return `${edit.edge} of ${phone === undefined ? 'the pause after' : `phone ${phone + 1} in`} “${word ?? 'start'}”${which}: ${edit.shift > 0 ? '+' : ''}${Math.round(edit.shift * 1000)} ms`;
  }
  const keys = edit.kind === 'intensity' ? edit.points : edit.keys;
  const words = [...new Set(keys.map(({ anchor }) => anchor.word ?? 'start'))];
  const where = words.length > 2 ? `${words[0]} … ${words[words.length - 1]}` : words.join(', ');
  const name = edit.kind === 'intensity' ? edit.emotion : edit.channel;
  return `${name}: ${keys.length} ${keys.length === 1 ? 'point' : 'points'} (${where})`;
}
