import { describe, expect, it } from 'vitest';
import { contextClock, mediaClock, wallClock } from '../src/index.js';

describe('clocks', () => {
  it('of the wall', () => {
    let ms = 5000;
    const clock = wallClock(2, () => ms);
    ms += 250;
    expect(clock()).toBeCloseTo(2.25, 9);
  });
  it('of a media element run smoothly where it tells its time in steps of 40 ms', () => {
    let ms = 0;
    const media = { currentTime: 0, paused: false, playbackRate: 0.5 };
    const clock = mediaClock(media, () => ms);
    let before = clock();
    for (let step = 1; step < 200; step++) {
      ms = step * 10;
      media.currentTime = Math.floor(ms / 40) * 0.02;
      const seconds = clock();
      const ran = seconds - before;
      if (step > 60) expect(ran).toBeGreaterThan(0.001);
      expect(Math.abs(seconds - ms * 0.0005)).toBeLessThan(0.03);
      before = seconds;
    }
    media.currentTime = 0.2; // someone jumped
    ms += 10;
    expect(clock()).toBeCloseTo(0.2, 6);
    media.paused = true;
    ms += 500;
    expect(clock()).toBeCloseTo(0.2, 6);
  });
  it('of an audio context, heard a little later', () => {
    expect(contextClock({ currentTime: 10, outputLatency: 0.1 }, 8)()).toBeCloseTo(1.9, 9);
  });
});
