// Which channels drive a morph target, by its name: the same rules as mien's own (docs/faces.md).
import { NODES, SPELLINGS, VISEMES, WEIGHTS } from './tables.js';

/** Weight of a target = sum of gain x channel, kept within 0..1. */
export type Recipe = Readonly<Record<string, number>>;

/** So many of ARKit's shapes on one mesh, and it is driven by those alone. */
const ENOUGH_ARKIT = 10;
const NOTHING: Recipe = {};

const plain = (name: string): string => name.toLowerCase().replace(/[^a-z0-9]/g, '');
const spelt = new Map(WEIGHTS.map((name) => [plain(name), name]));
const last = (name: string): string => name.slice(name.lastIndexOf('.') + 1);

/** The channel whose own name this is, in whatever spelling; `undefined` if there is none. */
export function channelOf(name: string): string | undefined {
  if (WEIGHTS.includes(name)) return name;
  const short = last(name).replace(/_(L|R)$/, (_, side: string) => (side === 'L' ? 'Left' : 'Right'));
  return spelt.get(plain(short));
}

/** What drives a target of this name; empty if the name is not known. */
export function recipeOf(name: string): Recipe {
  const channel = channelOf(name);
  if (channel !== undefined) return { [channel]: 1 };
  const short = plain(last(name));
  const viseme = short.replace(/^(viseme|vrcv|fclmth|fcleye|v)(?=.)/, '');
  return own(SPELLINGS, short) ?? own(VISEMES, viseme) ?? NOTHING;
}

/** What drives each target of one mesh; visemes rest on a mesh that has ARKit's shapes. */
export function recipesOf(names: readonly string[]): Recipe[] {
  const channels = names.map(channelOf);
  const onlyArkit = channels.filter((channel) => channel !== undefined).length >= ENOUGH_ARKIT;
  const parted = !channels.includes('browInnerUp'); // ARKit's one shape, in two halves
  return names.map((name, place) => {
    const channel = channels[place];
    if (parted && channel?.startsWith('browInnerUp')) return { browInnerUp: 1, [channel]: 1 };
    return onlyArkit && channel === undefined ? NOTHING : recipeOf(name);
  });
}

/** Which of `names` is the best for the head, the left or the right eye; -1 if none is. */
export function turningNode(part: string, names: readonly string[]): number {
  const short = names.map(plain);
  for (const known of NODES[part] ?? []) {
    const place = short.indexOf(known);
    if (place >= 0) return place;
  }
  return -1;
}

function own<T>(table: Readonly<Record<string, T>>, name: string): T | undefined {
  return Object.hasOwn(table, name) ? table[name] : undefined;
}
