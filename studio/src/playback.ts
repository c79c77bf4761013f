// Sound and time: play, seek, slow motion, a loop.
import { mediaClock, type Clock } from 'mien-viewer';
import { Events } from './events';

export const SPEEDS = [0.25, 0.5, 0.75, 1] as const;

export class Playback extends Events<{ state: void; time: number }> {
  readonly audio = new Audio();
  loop: [number, number] | null = null;
  seconds = 0;
  fps = 60;
  private clock: Clock = () => 0;
  private address = '';
  private asked = 0; // the moment that was asked for while paused: the element may round it

  constructor() {
    super();
    this.audio.preload = 'auto';
    for (const name of ['play', 'pause', 'ended', 'ratechange']) this.audio.addEventListener(name, () => this.emit('state', undefined));
  }

  get playing(): boolean {
    return !this.audio.paused && !this.audio.ended;
  }

  /** Seconds now. */
  get now(): number {
    if (!this.playing) return this.asked;
    return Math.min(Math.max(this.clock(), 0), this.seconds);
  }

  get speed(): number {
    return this.audio.playbackRate;
  }

  set speed(value: number) {
    this.audio.playbackRate = value;
    this.audio.defaultPlaybackRate = value;
    this.emit('state', undefined);
  }

  load(wav: ArrayBuffer, seconds: number, fps: number): void {
    this.audio.pause();
    if (this.address !== '') URL.revokeObjectURL(this.address);
    this.address = URL.createObjectURL(new Blob([wav], { type: 'audio/wav' }));
    const speed = this.speed;
    this.audio.src = this.address;
    this.audio.playbackRate = speed;
    this.seconds = seconds;
    this.fps = fps;
    this.loop = null;
    this.seek(0);
    this.emit('state', undefined);
  }

  /** Another sound of the same line in the place of this one, at a moment of its own; it plays on if this one plays. */
  swap(wav: ArrayBuffer, seconds: number, at: number, play = this.playing): void {
    const { loop } = this;
    this.load(wav, seconds, this.fps);
    this.loop = loop !== null && loop[1] <= seconds ? loop : null;
    this.seek(at);
    if (play) void this.play();
  }

  async play(): Promise<void> {
    if (this.address === '') return;
    const [first, last] = this.loop ?? [0, this.seconds];
    if (this.asked >= last - 1e-3 || this.asked < first) this.asked = first;
    this.audio.currentTime = this.asked;
    this.clock = mediaClock(this.audio);
    await this.audio.play().catch((problem: unknown) => { if ((problem as Error).name !== 'AbortError') throw problem; }); // paused again meanwhile
  }

  pause(): void {
    this.asked = this.now;
    this.audio.pause();
  }

  toggle(): void {
    if (this.playing) this.pause();
    else void this.play();
  }

  seek(to: number): void {
    this.asked = Math.min(Math.max(to, 0), this.seconds);
    if (this.address !== '') this.audio.currentTime = this.asked;
    this.emit('time', this.asked);
  }

  step(frames: number): void {
    if (this.playing) this.pause();
    const at = Math.round(this.asked * this.fps) + frames;
    this.seek(Math.min(Math.max(at / this.fps, 0), this.seconds));
  }

  setLoop(loop: [number, number] | null): void {
    this.loop = loop !== null && loop[1] - loop[0] > 0.02 ? loop : null;
    this.emit('state', undefined);
  }

  /** To be called before each picture: loops, stops at the end, tells the time. */
  tick(): void {
    if (this.audio.ended && this.loop === null) {
      if (this.asked !== this.seconds) {
        this.asked = this.seconds;
        this.emit('time', this.asked);
      }
      return;
    }
    if (this.loop !== null && (this.audio.ended || (this.playing && this.now >= this.loop[1]))) {
      this.audio.currentTime = this.loop[0];
      if (this.audio.ended || this.audio.paused) void this.play();
      this.clock = mediaClock(this.audio);
    }
    if (this.playing) this.emit('time', this.now);
  }
}
