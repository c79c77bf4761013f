// Words and phones relabelled, split, joined and inserted in place: the tiers as a person has them.
import { PAUSES } from '../anchors';
import type { Span, Times } from '../types';

const SHORTEST = 0.02; // s

/** The tier with one label changed. */
export const renamed = (tier: readonly Span[], place: number, label: string): Span[] =>
  tier.map((span, i) => (i === place ? [span[0], span[1], label] : span));

/** The tier with one span cut in two at a moment. */
export function split(tier: readonly Span[], place: number, at: number, labels: readonly [string, string]): Span[] {
  const [begin, end] = tier[place] as Span;
  const cut = Math.min(Math.max(at, begin + SHORTEST), end - SHORTEST);
  if (cut <= begin || cut >= end) return [...tier];
  return [...tier.slice(0, place), [begin, cut, labels[0]], [cut, end, labels[1]], ...tier.slice(place + 1)];
}

/** The tier with one span and the next as one, under one label. */
export function joined(tier: readonly Span[], place: number, label: string): Span[] {
  const [here, next] = [tier[place], tier[place + 1]];
  if (here === undefined || next === undefined) return [...tier];
  return [...tier.slice(0, place), [here[0], next[1], label], ...tier.slice(place + 2)];
}

/** The tier without one span; of phones a pause stays in its place. */
export const removed = (tier: readonly Span[], place: number, pauses: boolean): Span[] =>
  (pauses ? renamed(tier, place, 'SIL') : tier.filter((_, i) => i !== place));

/** The words with one more between two moments, as far as there is room. */
export function inserted(words: readonly Span[], at: number, label: string, most: number): Span[] {
  const after = words.findIndex(([begin]) => begin >= at);
  const place = after < 0 ? words.length : after;
  const from = Math.max(at, words[place - 1]?.[1] ?? 0);
  const to = Math.min(from + 0.3, words[place]?.[0] ?? most);
  return to - from < SHORTEST ? [...words] : [...words.slice(0, place), [from, to, label], ...words.slice(place)];
}

export const isPause = (label: string): boolean => PAUSES.has(label);
export const timesOf = (words: readonly Span[], phones: readonly Span[]): Times => ({ words: words.map((one): Span => [...one]), phones: phones.map((one): Span => [...one]) });
