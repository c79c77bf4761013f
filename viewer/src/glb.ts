// The motion inside an animated GLB: weights by the names of their targets, and the turn of the head as angles.
import { Quaternion } from 'three';
import { MienError } from './errors.js';
import { MotionClip, type Facts, type Span } from './motion.js';
import { channelOf, turningNode } from './names.js';
import { HEAD } from './tables.js';
import { anglesOf } from './turns.js';

const JSON_CHUNK = 0x4e4f534a;
const BINARY_CHUNK = 0x004e4942;
const FLOAT = 5126;
const NUMBERS: Readonly<Record<string, number>> = { SCALAR: 1, VEC3: 3, VEC4: 4 };

interface Document {
  asset?: { extras?: { mien?: { text?: string; audioDurationSeconds?: number; words?: Word[] } } };
  nodes?: GlbNode[];
  meshes?: { primitives: { targets?: unknown[] }[]; extras?: { targetNames?: string[] } }[];
  accessors?: { bufferView?: number; byteOffset?: number; componentType: number; count: number; type: string }[];
  bufferViews?: { byteOffset?: number; byteStride?: number }[];
  animations?: GlbAnimation[];
}
interface Word { start: number; end: number; label: string }
interface GlbNode { name?: string; mesh?: number; children?: number[]; rotation?: [number, number, number, number] }
interface GlbAnimation {
  name?: string;
  samplers: { input: number; output: number }[];
  channels: { sampler: number; target: { node?: number; path: string } }[];
}

/** Reads the motion of a GLB that mien wrote (`-o line.glb`, with or without `--face`). */
export function readGlb(bytes: ArrayBuffer, name = 'the file'): MotionClip {
  const { document, binary } = chunks(bytes, name);
  const animation = chosen(document.animations ?? []);
  if (animation === undefined) throw new MienError(`${name} is not animated: it holds a face, no performance`);
  const read = (accessor: number): Float32Array => floats(document, binary, accessor, name);
  const first = animation.channels.find(({ target }) => target.path === 'weights');
  if (first === undefined) throw new MienError(`${name}: its animation moves no morph targets`);
  const times = read((animation.samplers[first.sampler] as { input: number }).input);
  const columns = new Map<string, (frame: number) => number>();
  for (const { sampler, target } of animation.channels) {
    const output = read((animation.samplers[sampler] as { output: number }).output);
    if (target.path === 'weights') addWeights(columns, document, target.node as number, output, times.length);
    if (target.path === 'rotation') addHead(columns, document, target.node as number, output);
  }
  const channels = [...columns.keys()];
  const values = new Float32Array(times.length * channels.length);
  [...columns.values()].forEach((value, column) => {
    for (let frame = 0; frame < times.length; frame++) values[frame * channels.length + column] = value(frame);
  });
  const last = times[times.length - 1] as number;
  const fps = times.length > 1 && last > 0 ? (times.length - 1) / last : 30;
  return new MotionClip(channels, fps, values, factsOf(document));
}

/** mien's own animation where a file holds several: it is named so, or else the last that has any. */
function chosen(animations: readonly GlbAnimation[]): GlbAnimation | undefined {
  return animations.find(({ name }) => name === 'mien') ?? animations.find(({ name }) => name === 'performance')
    ?? animations[animations.length - 1];
}

function addWeights(
  columns: Map<string, (frame: number) => number>, document: Document, node: number, output: Float32Array, frames: number,
): void {
  const mesh = document.meshes?.[document.nodes?.[node]?.mesh ?? -1];
  const names = mesh?.extras?.targetNames ?? [];
  const count = output.length / frames;
  for (let target = 0; target < count; target++) {
    const name = names[target] ?? '';
    const channel = channelOf(name) ?? name; // a target that is no channel is played on targets of its own name
    if (channel !== '' && !columns.has(channel)) columns.set(channel, (frame) => output[frame * count + target] as number);
  }
}

function addHead(
  columns: Map<string, (frame: number) => number>, document: Document, node: number, output: Float32Array,
): void {
  const nodes = document.nodes ?? [];
  if (turningNode('head', nodes.map(({ name }) => name ?? '')) !== node) return;
  const above = turnAbove(nodes, node);
  const rest = quaternion(nodes[node]?.rotation);
  const undo = rest.clone().invert().multiply(above.clone().invert());
  const angles = Array.from({ length: output.length / 4 }, (_, frame) =>
    anglesOf(above.clone().multiply(new Quaternion().fromArray(output, 4 * frame)).multiply(undo)));
  HEAD.forEach((name, axis) => columns.set(name, (frame) => angles[frame]?.[axis] ?? 0));
}

function turnAbove(nodes: readonly GlbNode[], node: number): Quaternion {
  const turn = new Quaternion();
  let at = nodes.findIndex(({ children }) => children?.includes(node));
  for (let steps = 0; at >= 0 && steps < nodes.length; steps++) {
    turn.premultiply(quaternion(nodes[at]?.rotation));
    const below = at;
    at = nodes.findIndex(({ children }) => children?.includes(below));
  }
  return turn;
}

const quaternion = (given?: readonly number[]): Quaternion => new Quaternion().fromArray((given ?? [0, 0, 0, 1]) as number[]);

function factsOf(document: Document): Facts {
  const told = document.asset?.extras?.mien;
  if (told === undefined) return {};
  const facts: Facts = { text: told.text ?? '', words: (told.words ?? []).map((w): Span => [w.start, w.end, w.label]) };
  if (told.audioDurationSeconds !== undefined) facts.seconds = told.audioDurationSeconds;
  return facts;
}

function chunks(bytes: ArrayBuffer, name: string): { document: Document; binary: DataView } {
  const view = new DataView(bytes);
  if (bytes.byteLength < 20 || view.getUint32(0, true) !== 0x46546c67) {
    throw new MienError(`${name} is not a GLB file: it does not begin with 'glTF'`);
  }
  if (view.getUint32(4, true) !== 2) throw new MienError(`${name} is glTF version ${view.getUint32(4, true)}, not 2`);
  let document: Document | undefined;
  let binary = new DataView(new ArrayBuffer(0));
  for (let at = 12; at + 8 <= bytes.byteLength;) {
    const size = view.getUint32(at, true);
    const kind = view.getUint32(at + 4, true);
    if (at + 8 + size > bytes.byteLength) throw new MienError(`${name} is cut off: the chunk at byte ${at} is not whole`);
    if (kind === JSON_CHUNK) document ??= JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, at + 8, size))) as Document;
    if (kind === BINARY_CHUNK) binary = new DataView(bytes, at + 8, size);
    at += 8 + size;
  }
  if (document === undefined) throw new MienError(`${name} holds no glTF document`);
  return { document, binary };
}

function floats(document: Document, binary: DataView, number: number, name: string): Float32Array {
  const accessor = document.accessors?.[number];
  const view = document.bufferViews?.[accessor?.bufferView ?? -1];
  const width = NUMBERS[accessor?.type ?? ''];
  if (accessor === undefined || view === undefined || width === undefined || accessor.componentType !== FLOAT) {
    throw new MienError(`${name}: accessor ${number} does not hold floats in the file itself; mien writes them so`);
  }
  const start = (view.byteOffset ?? 0) + (accessor.byteOffset ?? 0);
  const stride = view.byteStride ?? 4 * width;
  const values = new Float32Array(accessor.count * width);
  for (let i = 0; i < accessor.count; i++) {
    for (let c = 0; c < width; c++) values[i * width + c] = binary.getFloat32(start + i * stride + 4 * c, true);
  }
  return values;
}
