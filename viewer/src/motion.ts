import { MienError } from './errors.js';

/** Something that stands between two moments: `[begin, end, label]`, in seconds. */
export type Span = readonly [number, number, string];

/** What a sender tells about a line besides its motion. */
export interface Facts {
  text?: string;
  seconds?: number;
  /** Seconds after which a stream that goes round and round begins again. */
  round?: number;
  words?: readonly Span[];
  phones?: readonly Span[];
  performer?: string;
  [other: string]: unknown;
}

/** A source of channel values over time. */
export interface Motion {
  /** Names of the channels, in the order of `sample`'s values. */
  readonly channels: readonly string[];
  /** Values at a moment; the same array each time. Linear between frames, held before the first and after the last. */
  sample(seconds: number): Float32Array;
}

/** A whole performance: frames at `i / fps` seconds. */
export class MotionClip implements Motion {
  readonly frames: number;
  private readonly row: Float32Array;

  /** @param values frame after frame, `channels.length` numbers each: weights 0..1, head angles in degrees */
  constructor(
    readonly channels: readonly string[],
    readonly fps: number,
    readonly values: Float32Array,
    readonly facts: Facts = {},
  ) {
    if (!(fps > 0)) throw new MienError(`a frame rate is above 0, not ${fps}`);
    if (channels.length === 0 || values.length % channels.length !== 0) {
      throw new MienError(`${values.length} numbers do not make frames of ${channels.length} channels`);
    }
    this.frames = values.length / channels.length;
    if (this.frames === 0) throw new MienError('the motion has no frames');
    this.row = new Float32Array(channels.length);
  }

  /** Length of the motion in seconds. */
  get seconds(): number {
    return this.facts.seconds ?? this.frames / this.fps;
  }

  sample(seconds: number): Float32Array {
    const at = Math.min(Math.max(seconds * this.fps, 0), this.frames - 1);
    const before = Math.floor(at);
    const first = before * this.channels.length;
    const second = Math.min(before + 1, this.frames - 1) * this.channels.length;
    mix(this.values, first, this.values, second, at - before, this.row);
    return this.row;
  }
}

/** `into` = a + share x (b - a), from the given places on. */
export function mix(
  a: Float32Array, first: number, b: Float32Array, second: number, share: number, into: Float32Array,
): void {
  for (let i = 0; i < into.length; i++) {
    const from = a[first + i] as number;
    into[i] = from + share * ((b[second + i] as number) - from);
  }
}
