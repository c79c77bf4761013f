import { readFileSync } from 'node:fs';
import { BufferGeometry, Group, Mesh, Object3D } from 'three';

export const golden = (name: string): ArrayBuffer => {
  const bytes = readFileSync(new URL(`./golden/${name}`, import.meta.url));
  return bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength) as ArrayBuffer;
};
export const text = (name: string): string => new TextDecoder().decode(golden(name));
export const truth = JSON.parse(text('values.json')) as { channels: string[]; values: number[][] };

/** The messages of frames.bin, one by one. */
export function frameMessages(): ArrayBuffer[] {
  const all = golden('frames.bin');
  const size = 16 + 4 * truth.channels.length;
  return Array.from({ length: all.byteLength / size }, (_, i) => all.slice(i * size, (i + 1) * size));
}

export function mesh(name: string, targets: string[]): Mesh {
  const made = new Mesh(new BufferGeometry());
  made.name = name;
  made.morphTargetDictionary = Object.fromEntries(targets.map((target, i) => [target, i]));
  made.morphTargetInfluences = targets.map(() => 0);
  return made;
}

export function group(...children: Object3D[]): Group {
  const made = new Group();
  made.add(...children);
  return made;
}

/** A WebSocket that says what it is told to. */
export class FakeSocket extends EventTarget {
  binaryType = '';
  closed = false;
  say(data: string | ArrayBuffer): void { this.dispatchEvent(new MessageEvent('message', { data })); }
  close(): void {
    if (this.closed) return;
    this.closed = true;
    this.dispatchEvent(new Event('close'));
  }
}
