// How strong each pitch is at each moment, up to 8 kHz: drawn once for a sound, stretched when it is shown.
import type { Brush } from './lane';

const SIZE = 512;
const TOP = 8000; // Hz
const RANGE = 70; // dB below the loudest
const MOST = 4000; // columns

export class Spectrogram {
  private readonly picture: HTMLCanvasElement | undefined;

  constructor(samples: Float32Array, rate: number) {
    const columns = Math.min(Math.max(Math.floor(samples.length / (SIZE / 4)), 1), MOST);
    const rows = Math.min(Math.round((TOP / rate) * SIZE), SIZE / 2);
    const levels = new Float32Array(columns * rows);
    const [real, imaginary] = [new Float32Array(SIZE), new Float32Array(SIZE)];
    let loudest = -Infinity;
    for (let column = 0; column < columns; column++) {
      const first = Math.round((column / columns) * samples.length) - SIZE / 2;
      for (let i = 0; i < SIZE; i++) {
        real[i] = (samples[first + i] ?? 0) * (0.5 - 0.5 * Math.cos((2 * Math.PI * i) / SIZE));
        imaginary[i] = 0;
      }
      transform(real, imaginary);
      for (let row = 0; row < rows; row++) {
        const level = 10 * Math.log10((real[row] as number) ** 2 + (imaginary[row] as number) ** 2 + 1e-12);
        levels[column * rows + row] = level;
        loudest = Math.max(loudest, level);
      }
    }
    this.picture = Object.assign(document.createElement('canvas'), { width: columns, height: rows });
    const context = this.picture.getContext('2d') as CanvasRenderingContext2D;
    const pixels = context.createImageData(columns, rows);
    for (let column = 0; column < columns; column++) {
      for (let row = 0; row < rows; row++) {
        const share = Math.min(Math.max(1 + ((levels[column * rows + row] as number) - loudest) / RANGE, 0), 1);
        const at = ((rows - 1 - row) * columns + column) * 4;
        pixels.data.set([40 + 200 * share, 44 + 150 * share ** 1.5, 60 + 90 * share ** 3, 255 * Math.min(share * 1.4, 1)], at);
      }
    }
    context.putImageData(pixels, 0, 0);
  }

  paint({ context, height, window }: Brush, seconds: number): void {
    if (this.picture === undefined) return;
    const left = window.x(0);
    context.drawImage(this.picture, left, 0, window.x(seconds) - left, height);
  }
}

/** The fast Fourier transform (Cooley and Tukey 1965), in place; the length is a power of two. */
function transform(real: Float32Array, imaginary: Float32Array): void {
  const n = real.length;
  for (let i = 1, j = 0; i < n; i++) {
    let bit = n >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) for (const values of [real, imaginary]) [values[i], values[j]] = [values[j] as number, values[i] as number];
  }
  for (let length = 2; length <= n; length <<= 1) {
    const angle = (-2 * Math.PI) / length;
    for (let i = 0; i < n; i += length) {
      for (let k = 0; k < length / 2; k++) {
        const [cos, sin, a, b] = [Math.cos(angle * k), Math.sin(angle * k), i + k, i + k + length / 2];
        const [re, im] = [(real[b] as number) * cos - (imaginary[b] as number) * sin, (real[b] as number) * sin + (imaginary[b] as number) * cos];
        [real[b], imaginary[b]] = [(real[a] as number) - re, (imaginary[a] as number) - im];
        [real[a], imaginary[a]] = [(real[a] as number) + re, (imaginary[a] as number) + im];
      }
    }
  }
}
