// Between moments in seconds and moments tied to what is said.
import type { Anchor, Place, Span } from './types';

export const PAUSES = new Set(['SIL', 'SP', '']);

/** One phone of the line and the name of its place. */
export interface Stretch { begin: number; end: number; place: Place }

/** Words and phones of a take, as places to tie things to. */
export class Speech {
  /** One for each phone, in order; one for the whole line where there are none. */
  readonly stretches: Stretch[];

  constructor(readonly words: readonly Span[], readonly phones: readonly Span[], readonly seconds: number) {
    this.stretches = stretchesOf(words, phones, seconds);
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

function stretchesOf(words: readonly Span[], phones: readonly Span[], seconds: number): Stretch[] {
  const heard = new Map<string, number>();
  const occurrences = words.map(([, , word]) => {
    heard.set(word, (heard.get(word) ?? 0) + 1);
    return heard.get(word) as number;
  });
  const nameOf = (place: number): Place =>
    place < 0 ? { word: null } : { word: (words[place] as Span)[2], occurrence: occurrences[place] as number };
  let [word, phone, pause] = [-1, 0, 0]; // the word last begun, and how many phones and pauses came since
  const result = phones.map(([begin, end]): Stretch => {
    const middle = (begin + end) / 2;
    const inside = words.findIndex(([from, to]) => middle >= from && middle < to);
    if (inside < 0) return { begin, end, place: { ...nameOf(word), pause: pause++ } };
    if (inside !== word) [word, phone, pause] = [inside, 0, 0];
    return { begin, end, place: { ...nameOf(word), phone: phone++ } };
  });
  return result.length > 0 ? result : [{ begin: 0, end: seconds, place: { word: null, pause: 0 } }];
}
