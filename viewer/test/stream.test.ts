import { describe, expect, it, vi } from 'vitest';
import { MienFace, MienStream, readFrame, readGreeting, type StreamOptions } from '../src/index.js';
import { FakeSocket, frameMessages, golden, group, mesh, text, truth } from './helpers.js';

const COUNT = truth.channels.length;

describe('messages, against bytes that mien itself wrote', () => {
  it('reads the greeting', () => {
    const greeting = readGreeting(text('greeting.txt'));
    expect(greeting.channels).toEqual(truth.channels);
    expect(greeting.fps).toBe(25);
    expect(greeting.facts.text).toBe('Up "there" – ä');
  });
  it('reads every frame, and the gap shows in the numbers', () => {
    const frames = frameMessages().map((message) => readFrame(message, COUNT));
    expect(frames.map(({ number }) => number)).toEqual([0, 1, 2, 4, 5]);
    expect(frames[3]?.seconds).toBeCloseTo(4 / 25, 12);
    for (const { number, values } of frames) {
      expect(values).toEqual(Float32Array.from(truth.values[number] as number[]));
    }
  });
  it('refuses other versions, other kinds and cut messages in one line', () => {
    const [first] = frameMessages() as [ArrayBuffer];
    const changed = (at: number, value: number): ArrayBuffer => {
      const copy = first.slice(0);
      new Uint8Array(copy)[at] = value;
      return copy;
    };
    expect(() => readFrame(changed(1, 2), COUNT)).toThrow(/version 1, got message 1 of version 2/);
    expect(() => readFrame(changed(0, 9), COUNT)).toThrow(/got message 9/);
    expect(() => readFrame(first.slice(0, 7), COUNT)).toThrow(/at least 16 bytes, got 7/);
    expect(() => readFrame(first.slice(0, 40), COUNT)).toThrow(/frame 0: expected/);
    expect(() => readFrame(first, COUNT - 1)).toThrow(/expected \d+ channels/);
    const later = text('greeting.txt').replace('"version": 1', '"version": 2');
    expect(() => readGreeting(later)).toThrow('the stream is mien-live version 2; this player reads version 1');
    expect(() => readGreeting('<html>')).toThrow(/expected the greeting/);
    expect(() => readGreeting('null')).toThrow(/expected the greeting/);
  });
});

describe('a stream that goes round, with its sound', () => {
  it('has the sound again in every round, also for one who comes late, and never after its end', () => {
    vi.useFakeTimers();
    vi.setSystemTime(1_000_000);
    const socket = new FakeSocket();
    const begun: number[] = [];
    const audio = { currentTime: 0, duration: 1.5, paused: true, ended: false, playbackRate: 1, play: () => {
      begun.push(Number(audio.currentTime.toFixed(2)));
      audio.paused = false;
      setTimeout(() => { audio.paused = true; }, (1.5 - audio.currentTime) * 1000);
      return Promise.resolve();
    } };
    const face = new MienFace(group(mesh('face', ['jawOpen'])));
    const stream = face.listenWithSound('ws://127.0.0.1:1', audio as unknown as HTMLAudioElement, { socket: socket as unknown as WebSocket });
    const facts = { began: 1000 - 2.6, round: 2, sound: '/sound.wav' }; // it is in its second round for 0.6 s
    socket.say(JSON.stringify({ format: 'mien-live', version: 1, channels: ['jawOpen'], fps: 25, facts }));
    return Promise.resolve().then(() => {
      vi.advanceTimersByTime(1);
      expect(begun).toEqual([0.6]);
      vi.advanceTimersByTime(1200);
      expect(stream.clock()).toBeCloseTo(3.8, 2); // the sound is over, the face goes on
      vi.advanceTimersByTime(4000);
      expect(begun).toEqual([0.6, 0, 0]);
      stream.close();
      vi.advanceTimersByTime(9000);
      expect(begun.length).toBe(3);
      vi.useRealTimers();
    });
  });
});

function listening(options: StreamOptions = {}) {
  const socket = new FakeSocket();
  const time = { now: 100 };
  const problems: string[] = [];
  const stream = new MienStream('ws://127.0.0.1:1', {
    socket: socket as unknown as WebSocket, now: () => time.now, delay: 0.05,
    onError: ({ message }) => problems.push(message), ...options,
  });
  return { socket, time, stream, problems };
}

/** Gives the frames at the moments (seconds after the first frame of the stream) at which they come. */
function arrive(at: ReturnType<typeof listening>, moments: number[], messages = frameMessages()): void {
  at.socket.say(text('greeting.txt'));
  moments.forEach((moment, i) => {
    at.time.now = 100 + moment;
    at.socket.say(messages[i] as ArrayBuffer);
  });
}
const value = (frame: number, channel: string): number => (truth.values[frame] as number[])[truth.channels.indexOf(channel)] as number;

describe('a stream', () => {
  it('is shown one delay after the fastest frame, linear over a frame that never came', () => {
    const at = listening();
    arrive(at, [0, 0.07, 0.08, 0.16, 0.2]); // the second was held up by 30 ms
    expect(at.stream.stats).toEqual({ received: 5, skipped: 1, late: 0 });
    const jaw = truth.channels.indexOf('jawOpen');
    at.time.now = 100 + 3 / 25 + 0.05; // frame 3, which was passed over: between 2 and 4
    expect(at.stream.clock()).toBeCloseTo(0.12, 9);
    const between = (value(2, 'jawOpen') + value(4, 'jawOpen')) / 2;
    expect(at.stream.sample(at.stream.clock())[jaw]).toBeCloseTo(between, 5);
    at.time.now = 101; // nothing came any more: the last one is held
    expect(at.stream.sample(at.stream.clock())[jaw]).toBeCloseTo(value(5, 'jawOpen'), 6);
  });
  it('may be joined late', () => {
    const at = listening();
    arrive(at, [0.16, 0.2], frameMessages().slice(3));
    at.time.now = 100 + 0.16 + 0.05;
    expect(at.stream.clock()).toBeCloseTo(0.16, 9);
    expect(at.stream.sample(0.16)[0]).toBeCloseTo(value(4, 'eyeBlinkLeft'), 6);
    expect(at.stream.stats.skipped).toBe(0);
  });
  it('begins again with a loop', () => {
    const at = listening();
    const messages = frameMessages();
    arrive(at, [0, 0.04, 0.08, 5, 5.04], [...messages.slice(2), ...messages.slice(0, 2)]);
    at.time.now = 105.05;
    expect(at.stream.clock()).toBeCloseTo(0, 9);
    expect(at.stream.sample(at.stream.clock())[0]).toBeCloseTo(value(0, 'eyeBlinkLeft'), 6);
  });
  it('follows a clock of its listener', () => {
    const at = listening({ clock: () => 0.04 });
    arrive(at, [0, 0.04, 0.08, 0.16, 0.2]);
    expect(at.stream.sample(at.stream.clock())[0]).toBeCloseTo(value(1, 'eyeBlinkLeft'), 6);
  });
  it('never drifts: an hour of frames against a clock that is 200 ppm fast', () => {
    const at = listening();
    const message = frameMessages()[0] as ArrayBuffer;
    at.socket.say(text('greeting.txt'));
    let worst = 0;
    for (let frame = 0; frame < 3600 * 5; frame++) {
      const copy = message.slice(0);
      new DataView(copy).setUint32(4, frame, true);
      new DataView(copy).setFloat64(8, frame / 5, true);
      at.time.now = 100 + (frame / 5) * 1.0002;
      at.socket.say(copy);
      worst = Math.max(worst, Math.abs(at.stream.clock() - (frame / 5 - 0.05)));
    }
    expect(worst).toBeLessThan(0.002);
  });
  it('ends, and closing after that is no fault', () => {
    let ends = 0;
    const at = listening({ onEnd: () => ends++ });
    arrive(at, [0]);
    at.socket.say(text('end.txt'));
    at.socket.close();
    expect([ends, at.problems]).toEqual([1, []]);
  });
  it('tells when it breaks off, is refused, or speaks another version', () => {
    const broken = listening();
    arrive(broken, [0]);
    broken.socket.close();
    expect(broken.problems[0]).toMatch(/broke off/);
    const refused = listening();
    refused.socket.close();
    expect(refused.problems[0]).toMatch(/did not answer as a mien stream; does "mien serve" run/);
    const later = listening();
    later.socket.say(text('greeting.txt').replace('"version": 1', '"version": 7'));
    expect(later.problems).toEqual(['the stream is mien-live version 7; this player reads version 1']);
    expect(later.socket.closed).toBe(true);
    const garbled = listening();
    garbled.socket.say(text('greeting.txt'));
    garbled.socket.say(golden('end.txt'));
    expect(garbled.problems[0]).toMatch(/message 123/);
  });
});
