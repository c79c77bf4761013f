import { describe, expect, it } from 'vitest';
import { withTags } from '../src/panels/line_text';
import { mirrored, offset, pasted, scaled, tidy, without, type Marked } from '../src/timeline/selection';
import { inserted, joined, removed, renamed, split } from '../src/timeline/speech_editing';
import type { Span } from '../src/types';

const keys: Marked[] = [{ at: 0.1, value: 0.2, chosen: false }, { at: 0.2, value: 0.4, chosen: true }, { at: 0.3, value: 0.6, chosen: true }];
const plain = (marked: readonly Marked[]): number[][] => marked.map(({ at, value }) => [Math.round(at * 1e6) / 1e6, Math.round(value * 1e6) / 1e6]);

describe('many keys at once', () => {
  it('are moved, and stay within time and values', () => {
    expect(plain(tidy(offset(keys, 0.1, 0.1), 1, [0, 1]))).toEqual([[0.1, 0.2], [0.3, 0.5], [0.4, 0.7]]);
    expect(plain(tidy(offset(keys, 5, 5), 1, [0, 1]))).toEqual([[0.1, 0.2], [1, 1]]);
  });
  it('give way to chosen ones where they meet', () => {
    expect(plain(tidy(offset(keys, -0.1, 0), 1, [0, 1]))).toEqual([[0.1, 0.4], [0.2, 0.6]]);
  });
  it('are scaled about a moment and a value', () => {
    expect(plain(scaled(keys, 2, 0.2, 0.5))).toEqual([[0.1, 0.2], [0.2, 0.2], [0.4, 0.3]]);
  });
  it('are pasted over what stood there', () => {
    expect(plain(tidy(pasted(keys, [[0, 1], [0.1, 0.9]], 0.15), 1, [0, 1]))).toEqual([[0.1, 0.2], [0.15, 1], [0.25, 0.9], [0.3, 0.6]]);
  });
  it('are deleted', () => expect(plain(without(keys))).toEqual([[0.1, 0.2]]));
  it.each([['mouthSmileLeft', 'mouthSmileRight'], ['browDownRight', 'browDownLeft'], ['jawOpen', undefined]])('%s on the other side', (name, other) =>
    expect(mirrored(name)).toBe(other));
});

describe('words and phones', () => {
  const words: Span[] = [[0.1, 0.4, 'no'], [0.8, 1, 'yes']];
  it('are renamed, split, joined, removed and inserted', () => {
    expect(renamed(words, 0, 'so')[0]).toEqual([0.1, 0.4, 'so']);
    expect(split(words, 0, 0.2, ['n', 'o']).slice(0, 2)).toEqual([[0.1, 0.2, 'n'], [0.2, 0.4, 'o']]);
    expect(joined(words, 0, 'noyes')).toEqual([[0.1, 1, 'noyes']]);
    expect(removed(words, 1, true)[1]).toEqual([0.8, 1, 'SIL']);
    expect(inserted(words, 0.5, 'well', 2)[1]).toEqual([0.5, 0.8, 'well']);
    expect(inserted(words, 0.79, 'well', 2)).toHaveLength(2); // no room
  });
});

describe('tags in square brackets', () => {
  const emotions = ['happy', 'sad', 'surprised', 'neutral'];
  it('become tags', () => expect(withTags('[happy] Yes. [sad 0.4] No. [pause] So.', emotions)).toEqual({ text: '<happy> Yes. <sad 0.4> No. <pause seconds="0.4"/> So.', unknown: [] }));
  it('are questioned where nobody knows them', () => expect(withTags('[hungry] Yes.', emotions)).toEqual({ text: '[hungry] Yes.', unknown: ['hungry'] }));
});
