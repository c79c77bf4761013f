// Between moments in seconds and moments tied to what is said.
import type { Anchor, LineWord, Place, Span } from './types';

export const PAUSES = new Set(['SIL', 'SP', '']);

/** One phone of the line and the name of its place. */
export interface Stretch { begin: number; end: number; place: Place }

/** Words and phones of a take, as places to tie things to. */
export class Speech {
  /** One for each phone, in order; one for the whole line where there are none. */
  readonly stretches: Stretch[];

  constructor(readonly words: readonly Span[], readonly phones: readonly Span[], readonly seconds: number, line = lineOf(words, phones)) {
    this.stretches = stretchesOf(phones, seconds, line);
  }

  anchor(at: number): Anchor {
    const { begin, end, place } = (this.stretches.find((stretch) => at < stretch.end) ?? this.stretches.at(-1)) as Stretch;
    const share = end > begin ? Math.min(Math.max((at - begin) / (end - begin), 0), 1) : 0;
    return { ...place, share: Math.round(share * 1e6) / 1e6 };
  }

  /** Seconds of an anchor; undefined if its word or phone is not in this line. */
  moment(anchor: Anchor): number | undefined {
    const found = this.stretches.find(({ place }) => same(place, anchor));
    return found === undefined ? undefined : found.begin + anchor.share * (found.end - found.begin);
  }
}

export const same = (a: Place, b: Place): boolean =>
  a.word === b.word && (a.occurrence ?? 1) === (b.occurrence ?? 1) && a.phone === b.phone && a.pause === b.pause;

function stretchesOf(phones: readonly Span[], seconds: number, line: readonly LineWord[]): Stretch[] {
  const heard = new Map<string, number>();
  const places = line.flatMap(({ word, phones: spoken, pauses }): Place[] => {
    if (word !== null) heard.set(word, (heard.get(word) ?? 0) + 1);
    const name: Place = word === null ? { word } : { word, occurrence: heard.get(word) as number };
    return [...spoken.map((_, phone) => ({ ...name, phone })), ...pauses.map((_, pause) => ({ ...name, pause }))];
  });
  if (phones.length === 0) return [{ begin: 0, end: seconds, place: { word: null, pause: 0 } }];
  return phones.flatMap(([begin, end], number): Stretch[] => {
    const place = places[number];
    return place === undefined ? [] : [{ begin, end, place }];
  });
}

/** The line as the times of its words and phones tell it, where nobody else does. */
export function lineOf(words: readonly Span[], phones: readonly Span[]): LineWord[] {
  const line: LineWord[] = [{ word: null, phones: [], pauses: [] }];
  let last = -1;
  for (const [begin, end, label] of phones) {
    const middle = (begin + end) / 2;
    const inside = words.findIndex(([from, to]) => middle >= from && middle < to);
    if (inside > last) line.push({ word: (words[last = inside] as Span)[2], phones: [], pauses: [] });
    (line.at(-1) as LineWord)[inside < 0 ? 'pauses' : 'phones'].push(label);
  }
  return line;
}
