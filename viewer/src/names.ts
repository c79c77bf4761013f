// Which channels drive a morph target, by its name: mien's own tables of ARKit, Oculus, VRM and VRoid (docs/faces.md).
import { CONVENTIONS, NODES, WEIGHTS, type Convention } from './tables.js';

/** Weight of a target = sum of gain x channel, kept within 0..1. */
export type Recipe = Readonly<Record<string, number>>;

/** So many of ARKit's shapes on one mesh, and it is driven by those alone. */
const ENOUGH_SHAPES = 10;
const NOTHING: Recipe = {};
const WORD = /[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+|[^\p{L}\p{N}_\W]+|[^\x00-\x7F]+/gu;
const SIDES: Readonly<Record<string, string>> = { l: 'left', lt: 'left', left: 'left', r: 'right', rt: 'right', right: 'right' };
const [SHAPES, ...OTHERS] = CONVENTIONS as [Convention, ...Convention[]];

/** A name as it is compared: its words run together in lower case, the side at the end if there is one. */
export function spelling(name: string): string {
  const words = (name.match(WORD) ?? []).map((word) => word.toLowerCase()).map((word) => SIDES[word] ?? (/^\d+$/.test(word) ? String(Number(word)) : word));
  const sides = words.filter((word) => word === 'left' || word === 'right');
  if (sides.length !== 1) return words.join('');
  return words.filter((word) => word !== sides[0]).join('') + (sides[0] as string);
}

const spelt = new Map(WEIGHTS.map((name) => [spelling(name), name]));
const last = (name: string): string => name.split(/\.|\||:|__/).pop() as string;
const ways = (name: string): string[] => [...new Set([spelling(name), spelling(last(name)), name.toLowerCase()])];

/** The channel whose own name this is, in whatever spelling; `undefined` if there is none. */
export function channelOf(name: string): string | undefined {
  if (WEIGHTS.includes(name)) return name;
  for (const way of ways(name)) {
    const channel = spelt.get(way) ?? WEIGHTS.find((weight) => weight.toLowerCase() === way);
    if (channel !== undefined) return channel;
  }
  return undefined;
}

/** What drives each target of one mesh, known by its own names or by enough names of one convention. */
export function recipesOf(names: readonly string[]): Recipe[] {
  const channels = names.map(channelOf);
  const shaped = channels.filter((channel) => channel !== undefined).length >= ENOUGH_SHAPES;
  const others = shaped ? [] : OTHERS.filter(({ needs, targets }) => names.filter((name) => found(targets, name)).length >= needs);
  return names.map((name, place) => {
    const channel = channels[place];
    const whole = channel === undefined ? undefined : channel.replace(/(Left|Right)$/, '');
    // One shape of ARKit in two halves ("browInnerUp_L"), where the whole one is not there.
    const split = whole !== undefined && whole !== channel && WEIGHTS.includes(whole) && !channels.includes(whole);
    if (channel !== undefined) return (split ? found(SHAPES.targets, channel) : undefined) ?? { [channel]: 1 };
    for (const { targets } of shaped ? [SHAPES] : [SHAPES, ...others]) {
      const recipe = found(targets, name);
      if (recipe !== undefined && !taken(recipe, channels)) return recipe;
    }
    return NOTHING;
  });
}

/** Whether channels have targets of their own on the mesh already. */
const taken = (recipe: Recipe, channels: readonly (string | undefined)[]): boolean =>
  Object.keys(recipe).every((channel) => channels.includes(channel));

function found(targets: Convention['targets'], name: string): Recipe | undefined {
  for (const way of ways(name)) if (Object.hasOwn(targets, way)) return targets[way];
  return undefined;
}

/** Which of `names` is the best for the head, the left or the right eye; -1 if none is. */
export function turningNode(part: string, names: readonly string[]): number {
  const plain = names.map((name) => name.toLowerCase().replace(/[^\p{L}\p{N}]/gu, ''));
  for (const known of NODES[part] ?? []) {
    const place = plain.indexOf(known);
    if (place >= 0) return place;
  }
  return -1;
}
