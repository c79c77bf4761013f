// A mien stream over WebSocket: docs/live.md, version 1.
import { wallClock, type Clock } from './clocks.js';
import { MienError } from './errors.js';
import { mix, type Facts, type Motion } from './motion.js';

export const STREAM_VERSION = 1;
const FORMAT = 'mien-live';
const FRAME = 1;
const HEAD_BYTES = 16;
const KEPT_SECONDS = 4;
const WINDOW_SECONDS = 5;

/** What a stream begins with. */
export interface Greeting { channels: string[]; fps: number; facts: Facts }
/** One instant of a stream. */
export interface Frame { number: number; seconds: number; values: Float32Array }

/** Reads the first message. */
export function readGreeting(message: string): Greeting {
  let content: Record<string, unknown> | null = null;
  try {
    content = JSON.parse(message) as Record<string, unknown> | null;
  } catch {
    // told below
  }
  if (content === null || typeof content !== 'object' || content['format'] !== FORMAT) {
    throw new MienError(`expected the greeting of a mien stream, got ${JSON.stringify(message.slice(0, 40))}`);
  }
  if (content['version'] !== STREAM_VERSION) {
    throw new MienError(`the stream is ${FORMAT} version ${String(content['version'])}; this player reads version ${STREAM_VERSION}`);
  }
  const channels = content['channels'];
  const fps = Number(content['fps']);
  if (!Array.isArray(channels) || !channels.every((name) => typeof name === 'string') || !(fps > 0)) {
    throw new MienError('the greeting of the stream lacks its channels or its frame rate');
  }
  return { channels: channels as string[], fps, facts: (content['facts'] ?? {}) as Facts };
}

/** Reads the binary message of a frame of `channels` numbers. */
export function readFrame(message: ArrayBuffer, channels: number): Frame {
  if (message.byteLength < HEAD_BYTES) {
    throw new MienError(`expected a frame of at least ${HEAD_BYTES} bytes, got ${message.byteLength}`);
  }
  const view = new DataView(message);
  const [kind, version] = [view.getUint8(0), view.getUint8(1)];
  if (kind !== FRAME || version !== STREAM_VERSION) {
    throw new MienError(`expected message ${FRAME} of version ${STREAM_VERSION}, got message ${kind} of version ${version}`);
  }
  const count = view.getUint16(2, true);
  const number = view.getUint32(4, true);
  if (message.byteLength !== HEAD_BYTES + 4 * count || count !== channels) {
    throw new MienError(`frame ${number}: expected ${channels} channels, got ${count} in ${message.byteLength} bytes`);
  }
  const values = new Float32Array(count);
  for (let i = 0; i < count; i++) values[i] = view.getFloat32(HEAD_BYTES + 4 * i, true);
  return { number, seconds: view.getFloat64(8, true), values };
}

export interface StreamOptions {
  /** Seconds by which the face lags the fastest frames, so that late ones still count. */
  delay?: number;
  /** A clock of your own in seconds of the stream (a sound that plays beside it); else the frames' own arrival is it. */
  clock?: Clock;
  onGreeting?: (greeting: Greeting) => void;
  /** The moment at which frame 0 stands, seconds since 1970 by the sender's clock: maybe past, maybe a little ahead. */
  onBegin?: (at: number) => void;
  onEnd?: () => void;
  onError?: (problem: MienError) => void;
  /** Replaces the browser's WebSocket, in tests. */
  socket?: WebSocket;
  /** Seconds that only grow; replaced in tests. */
  now?: Clock;
}

/** What became of a stream's frames. */
export interface StreamStats { received: number; skipped: number; late: number }

/**
 * Frames as they come. The face is shown a little after the fastest frame could have come (`delay`), so that one that
 * takes longer is not missed; between frames, and over frames that never came, values are linear.
 */
export class MienStream implements Motion {
  channels: readonly string[] = [];
  greeting: Greeting | undefined;
  ended = false;
  began: number | undefined;
  readonly stats: StreamStats = { received: 0, skipped: 0, late: 0 };
  private readonly frames: Frame[] = [];
  private readonly offsets: { at: number; offset: number }[] = [];
  private readonly now: Clock;
  private readonly delay: number;
  private readonly socket: WebSocket;
  private row = new Float32Array(0);
  private last = -1;

  constructor(address: string, private readonly options: StreamOptions = {}) {
    this.now = options.now ?? wallClock();
    this.delay = options.delay ?? 0.05;
    this.socket = options.socket ?? new WebSocket(address);
    this.socket.binaryType = 'arraybuffer';
    this.socket.addEventListener('message', ({ data }) => this.take(data as string | ArrayBuffer));
    this.socket.addEventListener('close', () => this.finish(address));
  }

  /** Seconds of the stream to show now. */
  readonly clock: Clock = () => {
    if (this.options.clock !== undefined) return this.options.clock();
    if (this.offsets.length === 0) return 0;
    return this.now() - Math.min(...this.offsets.map(({ offset }) => offset)) - this.delay;
  };

  sample(seconds: number): Float32Array {
    const { frames, row } = this;
    let after = frames.length - 1;
    if (after < 0) return row;
    while (after > 0 && (frames[after - 1] as Frame).seconds > seconds) after--;
    const to = frames[after] as Frame;
    const from = frames[Math.max(after - 1, 0)] as Frame;
    const gap = to.seconds - from.seconds;
    const share = gap > 0 ? Math.min(Math.max((seconds - from.seconds) / gap, 0), 1) : 1;
    mix(from.values, 0, to.values, 0, share, row);
    return row;
  }

  close(): void {
    this.ended = true;
    this.socket.close();
  }

  private take(message: string | ArrayBuffer): void {
    if (this.ended) return;
    try {
      if (typeof message !== 'string') this.keep(readFrame(message, this.channels.length));
      else if (this.greeting === undefined) this.greet(readGreeting(message));
      else this.hear(JSON.parse(message) as { event?: string; at?: number });
    } catch (problem) {
      this.ended = true;
      this.socket.close();
      this.options.onError?.(problem instanceof MienError ? problem : new MienError(String(problem)));
    }
  }

  private hear({ event, at }: { event?: string; at?: number }): void {
    if (event === 'end') this.end();
    else if (event === 'began' && at !== undefined) this.begin(at);
  }

  /** The moment of frame 0 is known: a sound can be started with it. */
  private begin(at: number): void {
    this.began = at;
    this.options.onBegin?.(at);
  }

  private greet(greeting: Greeting): void {
    const { began } = greeting.facts;
    if (typeof began === 'number') queueMicrotask(() => this.begin(began));
    this.greeting = greeting;
    this.channels = greeting.channels;
    this.row = new Float32Array(greeting.channels.length);
    this.options.onGreeting?.(greeting);
  }

  private keep(frame: Frame): void {
    const newest = this.frames[this.frames.length - 1];
    if (newest !== undefined && frame.seconds < newest.seconds) { // it began again (`--loop`)
      this.frames.length = 0;
      this.offsets.length = 0;
      this.last = -1;
    }
    const at = this.now();
    this.stats.received++;
    if (this.last >= 0) this.stats.skipped += Math.max(frame.number - this.last - 1, 0);
    this.last = frame.number;
    if (this.offsets.length > 0 && frame.seconds < this.clock()) this.stats.late++;
    this.frames.push(frame);
    this.offsets.push({ at, offset: at - frame.seconds });
    while ((this.frames[0] as Frame).seconds < frame.seconds - KEPT_SECONDS) this.frames.shift();
    while ((this.offsets[0] as { at: number }).at < at - WINDOW_SECONDS) this.offsets.shift();
  }

  private end(): void {
    this.ended = true;
    this.options.onEnd?.();
  }

  private finish(address: string): void {
    if (this.ended) return;
    this.ended = true;
    const why = this.greeting === undefined ? 'did not answer as a mien stream' : 'broke off';
    this.options.onError?.(new MienError(`${address} ${why}; does "mien serve" run, and may this page listen?`));
  }
}
