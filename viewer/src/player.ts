import type { Object3D } from 'three';
import { mediaClock, wallClock, type Clock } from './clocks.js';
import { MienError } from './errors.js';
import { readGlb } from './glb.js';
import type { Motion, MotionClip } from './motion.js';
import { readAnimation } from './native.js';
import { FaceRig, type RigOptions } from './rig.js';
import { MienStream, type StreamOptions } from './stream.js';

export interface PlayOptions {
  /** A sound to keep time with; it is started. */
  audio?: HTMLMediaElement;
  /** Or any clock in seconds of the motion, such as `contextClock(context, startedAt)`. */
  clock?: Clock;
}

/** Fetches a native animation (`.json`) or an animated `.glb`. */
export async function loadMotion(address: string): Promise<MotionClip> {
  const answer = await fetch(address);
  if (!answer.ok) throw new MienError(`cannot read ${address}: ${answer.status} ${answer.statusText}`);
  const bytes = await answer.arrayBuffer();
  const begins = new TextDecoder().decode(new Uint8Array(bytes, 0, Math.min(4, bytes.byteLength)));
  if (begins === 'glTF') return readGlb(bytes, address);
  let content: unknown;
  try {
    content = JSON.parse(new TextDecoder().decode(bytes));
  } catch {
    throw new MienError(`${address} is neither a GLB nor a native animation (.json)`);
  }
  return readAnimation(content, address);
}

/** A three.js face that performs. Call `update()` before each picture. */
export class MienFace {
  readonly rig: FaceRig;
  private motion: Motion | undefined;
  private clock: Clock | undefined;

  /** @param object the face: a loaded scene, a group or a mesh, in its rest pose */
  constructor(object: Object3D, options: RigOptions = {}) {
    this.rig = new FaceRig(object, options);
    if (this.rig.channels.size === 0 && this.rig.unknown.length === 0) {
      throw new MienError(`${object.name || 'the object'} has neither morph targets nor nodes of head or eyes: nothing could move`);
    }
  }

  /** Performs a motion from its start: one that was loaded, or the address of a `.json` or `.glb`. */
  async play(motion: MotionClip | string, options: PlayOptions = {}): Promise<MotionClip> {
    const clip = typeof motion === 'string' ? await loadMotion(motion) : motion;
    this.stop();
    if (options.audio !== undefined) await options.audio.play();
    this.motion = clip;
    this.clock = options.clock ?? (options.audio === undefined ? wallClock() : mediaClock(options.audio));
    return clip;
  }

  /** Performs a stream of `mien serve`, such as `ws://127.0.0.1:8765`. */
  listen(address: string, options: StreamOptions = {}): MienStream {
    this.stop();
    const stream = new MienStream(address, options);
    this.motion = stream;
    this.clock = stream.clock;
    return stream;
  }

  /**
   * Performs a stream of `mien serve` with its sound: that is fetched from the same port and plays so that it is at 0 when
   * frame 0 stands; the face then keeps time with the sound. Of a stream that goes round and round (`--loop`) the sound
   * begins again with it.
   */
  listenWithSound(address: string, audio: HTMLAudioElement, options: StreamOptions = {}): MienStream {
    const sound = new URL(address.replace(/^ws/, 'http'));
    sound.pathname = '/sound.wav';
    audio.crossOrigin = 'anonymous';
    audio.preload = 'auto';
    audio.src = sound.href;
    const keep = mediaClock(audio);
    let [began, round] = [Infinity, 0]; // the moment of frame 0, and the rounds before this one
    const passed = (): number => Date.now() / 1000 - began;
    const length = (): number => stream.greeting?.facts.round ?? Infinity;
    const clock: Clock = () => (audio.paused || audio.ended ? Math.max(passed(), 0) : (round === 0 ? 0 : round * length()) + keep());
    const start = (): void => {
      if (stream.ended) return;
      round = Number.isFinite(length()) ? Math.max(Math.floor(passed() / length() + 1e-3), 0) : 0;
      const at = Math.max(passed() - (round === 0 ? 0 : round * length()), 0);
      if (!(at >= audio.duration)) { // it is not over before the face has gone round
        audio.currentTime = at;
        void audio.play();
      }
      if (Number.isFinite(length())) setTimeout(start, Math.max((round + 1) * length() - passed(), 0.01) * 1000);
    };
    const stream: MienStream = this.listen(address, { clock, ...options, onBegin: (at) => {
      began = at;
      setTimeout(start, Math.max(-passed() * 1000, 0));
      options.onBegin?.(at);
    } });
    return stream;
  }

  /** Stays as it is now. */
  stop(): void {
    if (this.motion instanceof MienStream) this.motion.close();
    this.motion = undefined;
  }

  /** Moves the face to where it should be now. */
  update(): void {
    if (this.motion === undefined || this.clock === undefined || this.motion.channels.length === 0) return;
    this.rig.apply(this.motion.channels, this.motion.sample(this.clock()));
  }
}
