// Keys that are chosen, over all lanes, and what can be done with many at once. Pure, but for the set itself.
import { Events } from '../events';
import type { Point } from '../curves';
import type { Tangent } from '../types';

/** A key, and whether it is chosen. */
export interface Marked { at: number; value: number; tangent?: Tangent | undefined; chosen: boolean }
/** Keys as they are copied: seconds from the first of them. */
export type Copied = ReadonlyMap<string, readonly Point[]>;

const PLACED = 1e-3; // s: two keys of a curve never stand nearer

export class Selection extends Events<{ change: void }> {
  private chosen = new Map<string, Set<number>>();

  has(lane: string, place: number): boolean { return this.chosen.get(lane)?.has(place) === true; }
  get lanes(): string[] { return [...this.chosen.keys()]; }
  get size(): number { return [...this.chosen.values()].reduce((sum, set) => sum + set.size, 0); }

  set(chosen: ReadonlyMap<string, ReadonlySet<number>>): void {
    this.chosen = new Map([...chosen].filter(([, set]) => set.size > 0).map(([lane, set]) => [lane, new Set(set)]));
    this.emit('change', undefined);
  }

  only(lane: string, place: number): void { this.set(new Map([[lane, new Set([place])]])); }

  toggle(lane: string, place: number): void {
    const set = new Set(this.chosen.get(lane));
    if (!set.delete(place)) set.add(place);
    this.set(new Map(this.chosen).set(lane, set));
  }

  clear(): void { if (this.chosen.size > 0) this.set(new Map()); }
}

/** Keys in order and within bounds; where two meet, the chosen one stays. */
export function tidy(keys: readonly Marked[], seconds: number, [low, high]: readonly [number, number]): Marked[] {
  const bounded = keys.map((key) => ({ ...key, at: Math.min(Math.max(key.at, 0), seconds), value: Math.min(Math.max(key.value, low), high) }));
  bounded.sort((a, b) => a.at - b.at || Number(a.chosen) - Number(b.chosen));
  const kept: Marked[] = [];
  for (const key of bounded) {
    const before = kept.at(-1);
    if (before !== undefined && key.at - before.at < PLACED / 2) {
      if (key.chosen || !before.chosen) kept[kept.length - 1] = key;
    } else kept.push(key);
  }
  return kept;
}

export const offset = (keys: readonly Marked[], seconds: number, value: number): Marked[] =>
  keys.map((key) => (key.chosen ? { ...key, at: key.at + seconds, value: key.value + value } : key));

/** Times farther from or nearer to a moment, values larger or smaller about another. */
export const scaled = (keys: readonly Marked[], time: number, about: number, value: number, level = 0): Marked[] =>
  keys.map((key) => (key.chosen ? { ...key, at: about + (key.at - about) * time, value: level + (key.value - level) * value } : key));

/** How the curve passes the chosen keys; undefined: as the whole curve has it. */
export const withTangent = (keys: readonly Marked[], tangent: Tangent | undefined): Marked[] =>
  keys.map((key) => (key.chosen ? { ...key, tangent } : key));

export const pointOf = ({ at, value, tangent }: Marked): Point => (tangent === undefined ? [at, value] : [at, value, tangent]);

export const without = (keys: readonly Marked[]): Marked[] => keys.filter(({ chosen }) => !chosen);

/** Copied keys laid at a moment; what stood under them gives way. */
export function pasted(keys: readonly Marked[], copied: readonly Point[], at: number): Marked[] {
  const [first, last] = [copied[0]?.[0] ?? 0, copied.at(-1)?.[0] ?? 0];
  const around = keys.filter((key) => key.at < at + first - PLACED || key.at > at + last + PLACED).map((key) => ({ ...key, chosen: false }));
  return [...around, ...copied.map(([time, value, tangent]) => ({ at: at + time, value, tangent, chosen: true }))];
}

/** The same channel on the other side of the face. */
export function mirrored(channel: string): string | undefined {
  if (/Left/.test(channel)) return channel.replace('Left', 'Right');
  return /Right/.test(channel) ? channel.replace('Right', 'Left') : undefined;
}
