import { describe, expect, it } from 'vitest';
import { readAnimation, readGlb } from '../src/index.js';
import { golden, text, truth } from './helpers.js';

const native = () => JSON.parse(text('line.json')) as Record<string, unknown>;

describe('a native animation', () => {
  it('is read whole', () => {
    const clip = readAnimation(native());
    expect([clip.channels, clip.fps, clip.frames]).toEqual([truth.channels, 25, 6]);
    expect(clip.values).toEqual(Float32Array.from(truth.values.flat()));
    expect(clip.facts.words?.[0]?.[2]).toBe('up "there"');
    expect(clip.facts.phones?.map(([, , label]) => label)).toEqual(['SIL', 'AH', 'P']);
    expect(clip.seconds).toBeCloseTo(0.24, 6);
  });
  it('is linear between frames, held outside', () => {
    const clip = readAnimation(native());
    const [first, second] = truth.values as [number[], number[]];
    expect(clip.sample(0.02)[3]).toBeCloseTo(((first[3] as number) + (second[3] as number)) / 2, 5);
    expect(clip.sample(-5)[3]).toBeCloseTo(first[3] as number, 6);
    expect(clip.sample(50)[3]).toBeCloseTo((truth.values[5] as number[])[3] as number, 6);
  });
  it('is refused in one line where it is another thing', () => {
    expect(() => readAnimation({ ...native(), version: 2 }, 'a.json')).toThrow('a.json is mien-animation version 2; this player reads version 1');
    expect(() => readAnimation({}, 'a.json')).toThrow('a.json is not a mien-animation file');
    expect(() => readAnimation(null)).toThrow(/is not a/);
    const odd = native();
    (odd['channels'] as { values: number[][] }).values[2]?.pop();
    expect(() => readAnimation(odd, 'a.json')).toThrow(/one number for each/);
  });
});

describe('an animated GLB', () => {
  it('gives the channels back', () => {
    const clip = readGlb(golden('line.glb'));
    expect(clip.fps).toBeCloseTo(25, 4);
    expect(clip.channels).toEqual(expect.arrayContaining(truth.channels));
    for (const [column, name] of clip.channels.entries()) {
      const values = truth.values.map((row) => row[truth.channels.indexOf(name)] as number);
      values.forEach((value, frame) => expect(clip.values[frame * clip.channels.length + column], name).toBeCloseTo(value, 3));
    }
  });
  it('of another maker, whose head bone stands askew', () => {
    const clip = readGlb(golden('driven.glb'));
    expect(clip.channels).toEqual(['jawOpen', 'browDownLeft', 'unknown', 'headYaw', 'headPitch', 'headRoll']);
    for (const name of ['jawOpen', 'headYaw', 'headPitch', 'headRoll']) {
      const column = clip.channels.indexOf(name);
      const value = (truth.values[4] as number[])[truth.channels.indexOf(name)] as number;
      expect(clip.values[4 * clip.channels.length + column], name).toBeCloseTo(value, 3);
    }
  });
  it('is refused in one line where it is another thing', () => {
    expect(() => readGlb(golden('foreign.glb'), 'a.glb')).toThrow('a.glb is not animated');
    expect(() => readGlb(golden('line.glb').slice(0, 5000), 'a.glb')).toThrow(/a\.glb is cut off/);
    expect(() => readGlb(golden('frames.bin'), 'a.glb')).toThrow(/not a GLB/);
  });
});
