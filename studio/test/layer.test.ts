import { describe, expect, it } from 'vitest';
import { lineOf, Speech } from '../src/anchors';
import { counts, held, intensityAt, type Point } from '../src/curves';
import {
  bordersOf, borderEdit, borderRoom, channelEdit, describe as tell, intensityOf, moveBorder, performed, pointsOf, setChannel, setIntensity,
  withBorder, without,
} from '../src/layer';
import { layOver, reweighed, warped } from '../src/performance';
import { emptyLayer, type Span, type Tangent } from '../src/types';

const words: Span[] = [[0.2, 0.5, 'no'], [0.5, 0.7, 'i'], [1.0, 1.4, 'no']];
const phones: Span[] = [
  [0, 0.2, 'SIL'], [0.2, 0.3, 'N'], [0.3, 0.5, 'OW'], [0.5, 0.7, 'AY'], [0.7, 1.0, 'SIL'], [1.0, 1.1, 'N'], [1.1, 1.4, 'OW'], [1.4, 1.5, 'SIL'],
];
const speech = new Speech(words, phones, 1.5);

describe('moments tied to what is said', () => {
  it.each([
    [0.1, { word: null, pause: 0, share: 0.5 }], [0.4, { word: 'no', occurrence: 1, phone: 1, share: 0.5 }],
    [0.85, { word: 'i', occurrence: 1, pause: 0, share: 0.5 }], [1.05, { word: 'no', occurrence: 2, phone: 0, share: 0.5 }],
    [9, { word: 'no', occurrence: 2, pause: 0, share: 1 }],
  ])('%s s', (at, anchor) => {
    expect(speech.anchor(at)).toEqual(anchor);
    if (at < 2) expect(speech.moment(anchor)).toBeCloseTo(at, 9);
  });
  it('move with their phone', () => {
    const anchor = speech.anchor(0.4);
    const moved = withBorder(words, phones, 1, 0.4);
    expect(new Speech(moved.words, moved.phones, 1.5).moment(anchor)).toBeCloseTo(0.45, 9);
  });
  it('are nowhere in a line without their word', () => {
    expect(speech.moment({ word: 'yes', occurrence: 1, phone: 0, share: 0 })).toBeUndefined();
    expect(new Speech([], [], 2).moment(new Speech([], [], 2).anchor(1))).toBeCloseTo(1, 9);
  });
  it('read the line from the tiers as the server tells it', () => {
    expect(lineOf(words, phones)).toEqual([
      { word: null, phones: [], pauses: ['SIL'] }, { word: 'no', phones: ['N', 'OW'], pauses: [] },
      { word: 'i', phones: ['AY'], pauses: ['SIL'] }, { word: 'no', phones: ['N', 'OW'], pauses: ['SIL'] }]);
  });
});

describe('curves, against values of mien.text', () => {
  const points: Point[] = [[0, 0], [1, 1], [3, 0.5]];
  it('held between keys', () => {
    expect([-1, 0.25, 2, 9].map((at) => held(points, at, 'linear'))).toEqual([0, 0.25, 0.75, 0.5]);
    expect(held(points, 0.25, 'smooth')).toBeCloseTo((1 - Math.SQRT1_2) / 2, 9);
    expect(held(points, 0.99, 'hold')).toBe(0);
  });
  it('monotone cubic (scipy.interpolate.PchipInterpolator)', () => {
    const found = [0.5, 1.5, 2.5].map((at) => intensityAt([[0, 0], [1, 1], [3, 0.5]], at, 'smooth'));
    [0.67708333, 0.9921875, 0.7890625].forEach((value, i) => expect(found[i]).toBeCloseTo(value, 6));
  });
  it('each key with its own tangent (mien.text.key_tangents)', () => {
    const keys = (tangents: Tangent[]): Point[] => [[0, 0], [1, 1], [3, 0.5], [4, 0.9]].map(([at, value], i) => [at, value, tangents[i]] as Point);
    const at = [0.5, 1.5, 2.5, 3.5];
    const expected: [Tangent[], number[]][] = [
      [['auto', 'flat', 'linear', 'step'], [0.67708333, 0.9453125, 0.6484375, 0.7]],
      [['linear', 'auto', 'auto', 'flat'], [0.625, 0.921875, 0.578125, 0.7]], [['step', 'linear', 'flat', 'auto'], [0, 0.8515625, 0.5546875, 0.62291667]]];
    for (const [tangents, values] of expected) values.forEach((value, i) => expect(held(keys(tangents), at[i] as number, 'smooth')).toBeCloseTo(value, 6));
    expect(held([[0, 0], [1, 1, 'step'], [2, 0]], 0.5, 'linear')).toBeCloseTo(0.5, 9);
  });
  it('fade out of and into nothing', () => {
    expect([-0.1, -0.05, 0, 1, 3.05, 4].map((at) => Math.round(counts(points, at, 0.1) * 100) / 100)).toEqual([0, 0.5, 1, 1, 0.5, 0]);
    expect([-0.01, 0].map((at) => counts(points, at, 0))).toEqual([0, 1]);
  });
});

describe('the layer', () => {
  const borders = bordersOf(speech);
  it('knows every border, by the phone of a word', () => {
    expect(borders).toHaveLength(phones.length - 1);
    expect(borders[0]).toMatchObject({ at: 0.2, edge: 'start', phone: { word: 'no', occurrence: 1, phone: 0 } });
    expect(borders[1]).toMatchObject({ at: 0.3, edge: 'end', phone: { word: 'no', occurrence: 1, phone: 0 } });
  });
  it('adds up shifts of one border, and forgets it where it is back', () => {
    const border = borders[1] as (typeof borders)[0];
    const once = moveBorder(emptyLayer(), border, 0.03);
    const twice = moveBorder(once, border, 0.02);
    expect(twice.edits).toHaveLength(1);
    expect(borderEdit(twice, border)?.shift).toBeCloseTo(0.05, 9);
    expect(moveBorder(twice, border, -0.05).edits).toEqual([]);
    expect(tell(twice.edits[0] as never)).toBe('end of phone 1 in “no”: +50 ms');
    expect(borderRoom(phones, 1)).toEqual([expect.closeTo(0.21, 9), 0.49]);
  });
  it('keeps one edit for each channel and emotion, and what else a file held', () => {
    let layer = setChannel({ ...emptyLayer(), line: ['x'] }, 'jawOpen', [[0.4, 0.5], [0.2, 1]], speech, 'replace');
    layer = setChannel(layer, 'jawOpen', [[0.4, 0.7]], speech, 'replace');
    layer = setIntensity(layer, 'happy', [[0.1, 0.2]], speech);
    expect(layer.edits.map(({ kind }) => kind)).toEqual(['channel', 'intensity']);
    expect(layer['line']).toEqual(['x']);
    expect(pointsOf(channelEdit(layer, 'jawOpen')?.keys ?? [], speech)).toEqual([[expect.closeTo(0.4), 0.7]]);
    expect(intensityOf(layer, undefined, 'happy', speech)).toEqual({ points: [[expect.closeTo(0.1), 0.2]], blend: 'linear' });
    expect(performed(layer)).toBe(performed(without(layer, 0)));
    expect(performed(layer)).not.toBe(performed(without(layer, 1)));
  });
});

describe('frames', () => {
  const facts = new Map([['a', { name: 'a', unit: '', minimum: 0, maximum: 1, group: '' }]]);
  it('are laid over as mien.text.parameter_curves.lay_over does', () => {
    const values = new Float32Array(15 * 2).fill(0.5); // 10 fps, channels a and b
    const layer = setChannel(emptyLayer(), 'a', [[0.4, 1], [0.8, 0]], speech, 'replace');
    layOver(values, ['a', 'b'], 10, layer, speech, facts);
    expect([...values].filter((_, i) => i % 2 === 1).every((value) => value === 0.5)).toBe(true);
    const a = [...values].filter((_, i) => i % 2 === 0);
    [0.5, 0.5, 0.5, 0.5, 1, expect.closeTo((1 + Math.SQRT1_2) / 2, 5), 0.5].forEach((value, i) => expect(a[i]).toEqual(typeof value === 'number' ? expect.closeTo(value, 5) : value));
    expect(a[8]).toBeCloseTo(0, 6);
  });
  it('stretch with phones', () => {
    const values = Float32Array.from([0, 1, 2, 3, 4]); // one channel, 1 fps
    expect([...warped(values, 1, 1, [0, 2, 4], [0, 1, 4])]).toEqual([0, 2, expect.closeTo(2.667, 3), expect.closeTo(3.333, 3), 4]);
  });
  it('take more or less of an emotion', () => {
    const [full, neutral] = [Float32Array.from([1, 1]), Float32Array.from([0.5, 0.5])];
    const level = (value: number) => ({ points: [[0, value]] as Point[], blend: 'linear' as const });
    expect([...reweighed(full, neutral, 1, 1, level(0.5), level(0.25))]).toEqual([0.75, 0.75]);
    expect([...reweighed(full, neutral, 1, 1, level(0), level(0.25))]).toEqual([1, 1]);
  });
});
