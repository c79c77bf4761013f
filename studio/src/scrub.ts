// A little of the sound at each moment that the playhead is dragged over.
const GRAIN = 0.07; // s

export class Scrubber {
  private context: AudioContext | undefined;
  private buffer: AudioBuffer | undefined;
  private last = -1;

  set(buffer: AudioBuffer): void { this.buffer = buffer; }

  play(at: number): void {
    if (this.buffer === undefined || Math.abs(at - this.last) < 0.01) return;
    this.last = at;
    this.context ??= new AudioContext();
    const [source, gain, now] = [this.context.createBufferSource(), this.context.createGain(), this.context.currentTime];
    source.buffer = this.buffer;
    gain.gain.setValueAtTime(0, now);
    gain.gain.linearRampToValueAtTime(0.8, now + 0.01);
    gain.gain.linearRampToValueAtTime(0, now + GRAIN);
    source.connect(gain).connect(this.context.destination);
    source.start(now, Math.max(at, 0), GRAIN);
  }
}
