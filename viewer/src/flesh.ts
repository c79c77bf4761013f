// What light does in flesh and in a mouth, worked out once for each face: skin so thin that light comes through (ears,
// nostrils), how deep in the mouth teeth and tongue lie, and pores. As in mien's own pictures (docs/pictures.md), hand-made.
import { BufferAttribute, DataTexture, LinearFilter, LinearMipmapLinearFilter, Matrix3, RepeatWrapping, Vector3, type BufferGeometry, type Mesh } from 'three';

const THIN_MM = [2, 4, 6, 8]; // depths at which the other side is looked for
const NEAR_MM = 2;
const TURNED = -0.3;
const CELL_MM = 4;
const TILE_MM = 28;
const TEXELS = 256;

const array = (geometry: BufferGeometry, name: string): Float32Array | undefined => {
  const attribute = geometry.getAttribute(name) as BufferAttribute | undefined;
  if (attribute === undefined) return undefined;
  const values = new Float32Array(attribute.count * 3);
  for (let v = 0; v < attribute.count; v++) values.set([attribute.getX(v), attribute.getY(v), attribute.getZ(v)], 3 * v);
  return values;
};

/**
 * Gives a mesh of skin the attribute `mienThin`, 0 to 1: how much light comes through from the other side.
 *
 * @param unit what a millimetre is in the mesh's own units
 */
export function findThin(mesh: Mesh, unit: number): void {
  const { geometry } = mesh;
  const [places, normals] = [array(geometry, 'position'), array(geometry, 'normal')];
  if (places === undefined || normals === undefined || geometry.getAttribute('mienThin') !== undefined) return;
  const count = places.length / 3;
  const cell = CELL_MM * unit;
  const cells = new Map<number, number[]>();
  const key = (x: number, y: number, z: number): number => ((x + 4096) * 8192 + (y + 4096)) * 8192 + z + 4096;
  const at = (v: number, axis: number): number => places[3 * v + axis] as number;
  const face = (v: number, axis: number): number => normals[3 * v + axis] as number;
  for (let v = 0; v < count; v++) {
    const name = key(Math.floor(at(v, 0) / cell), Math.floor(at(v, 1) / cell), Math.floor(at(v, 2) / cell));
    const there = cells.get(name);
    if (there === undefined) cells.set(name, [v]); else there.push(v);
  }
  const near = NEAR_MM * unit;
  /** Whether the skin nearest to a place, if there is some near it, is turned away from vertex `v`. */
  const away = (v: number, x: number, y: number, z: number): boolean => {
    let [nearest, least] = [-1, near * near];
    const range = (value: number): [number, number] => [Math.floor((value - near) / cell), Math.floor((value + near) / cell)];
    const [[x0, x1], [y0, y1], [z0, z1]] = [range(x), range(y), range(z)];
    for (let i = x0; i <= x1; i++) for (let j = y0; j <= y1; j++) for (let k = z0; k <= z1; k++) for (const other of cells.get(key(i, j, k)) ?? []) {
      const far = (at(other, 0) - x) ** 2 + (at(other, 1) - y) ** 2 + (at(other, 2) - z) ** 2;
      if (far < least) [nearest, least] = [other, far];
    }
    return nearest >= 0 && face(v, 0) * face(nearest, 0) + face(v, 1) * face(nearest, 1) + face(v, 2) * face(nearest, 2) < TURNED;
  };
  let thin = new Float32Array(count);
  for (let v = 0; v < count; v++) {
    const depth = THIN_MM.find((mm) => away(v, at(v, 0) - mm * unit * face(v, 0), at(v, 1) - mm * unit * face(v, 1), at(v, 2) - mm * unit * face(v, 2)));
    if (depth !== undefined) thin[v] = 1 - (0.5 * depth) / 8;
  }
  for (let round = 0; round < 4; round++) thin = smoothed(geometry, thin); // no step where it ends
  geometry.setAttribute('mienThin', new BufferAttribute(thin, 1));
}

/** The mean over each vertex's neighbours. */
function smoothed({ index }: BufferGeometry, values: Float32Array<ArrayBuffer>): Float32Array<ArrayBuffer> {
  if (index === null) return values;
  const [sum, count] = [values.slice(), new Float32Array(values.length).fill(1)];
  for (let i = 0; i < index.count; i++) {
    const [a, b] = [index.getX(i), index.getX(i % 3 === 2 ? i - 2 : i + 1)];
    sum[a] = (sum[a] as number) + (values[b] as number);
    sum[b] = (sum[b] as number) + (values[a] as number);
    count[a] = (count[a] as number) + 1;
    count[b] = (count[b] as number) + 1;
  }
  return sum.map((total, v) => total / (count[v] as number));
}

/** Gives teeth, gums and a tongue the attribute `mienDeep`: 0 at the front of the mouth, 1 where they lie deepest in it. */
export function findDepth(mesh: Mesh): void {
  const { geometry } = mesh;
  const places = array(geometry, 'position');
  if (places === undefined || geometry.getAttribute('mienDeep') !== undefined) return;
  mesh.updateWorldMatrix(true, false);
  const front = new Vector3(0, 0, 1).applyMatrix3(new Matrix3().setFromMatrix4(mesh.matrixWorld).transpose());
  const along = Float32Array.from({ length: places.length / 3 }, (_, v) => front.x * (places[3 * v] as number) + front.y * (places[3 * v + 1] as number) + front.z * (places[3 * v + 2] as number));
  const [least, most] = along.reduce(([a, b], value) => [Math.min(a, value), Math.max(b, value)] as [number, number], [Infinity, -Infinity]);
  geometry.setAttribute('mienDeep', new BufferAttribute(along.map((value) => (most - value) / Math.max(most - least, 1e-9)), 1));
}

/** How many tiles of pores a unit of texture coordinates holds; 0 where that is not known. */
export function tilesOf({ geometry }: Mesh, unit: number): number {
  const { index } = geometry;
  const [places, uv] = [array(geometry, 'position'), geometry.getAttribute('uv') as BufferAttribute | undefined];
  if (places === undefined || uv === undefined || index === null) return 0;
  const ratios: number[] = [];
  for (let i = 0; i < index.count; i += 3) {
    const [a, b] = [index.getX(i), index.getX(i + 1)];
    const spread = Math.hypot(uv.getX(a) - uv.getX(b), uv.getY(a) - uv.getY(b));
    const long = Math.hypot(...[0, 1, 2].map((axis) => (places[3 * a + axis] as number) - (places[3 * b + axis] as number))) / unit;
    if (spread > 1e-5 && long > 1e-3) ratios.push(long / spread);
  }
  ratios.sort((a, b) => a - b);
  return Math.round((ratios[ratios.length >> 1] ?? 0) / TILE_MM);
}

let made: { texture: DataTexture; steepest: number } | undefined;

/** A tile of skin: slopes across and down (a half is level), how deep in a pore; and how steep the steepest slope is. */
export function pores(): { texture: DataTexture; steepest: number } {
  if (made !== undefined) return made;
  let state = 5;
  const random = (): number => { state = (Math.imul(state, 1664525) + 1013904223) >>> 0; return state / 2 ** 32; };
  const [step, side] = [TILE_MM / TEXELS, 30];
  const pits = new Float32Array(TEXELS * TEXELS);
  for (let place = 0; place < side * side; place++) {
    const [x, y] = [place % side, Math.floor(place / side)].map((cell) => Math.floor(((cell + 0.1 + 0.8 * random()) * TEXELS) / side) % TEXELS) as [number, number];
    pits[y * TEXELS + x] = 0.2 + 0.8 * random();
  }
  const [soft, lines] = [blurred(pits, 0.2 / step), blurred(Float32Array.from(pits, () => random() + random() + random() - 1.5), 0.34 / step)];
  const [deepest, spread] = [soft.reduce((a, b) => Math.max(a, b)), Math.sqrt(lines.reduce((sum, one) => sum + one * one, 0) / lines.length)];
  const height = soft.map((pit, place) => (0.03 * (lines[place] as number)) / spread - (0.1 * pit) / deepest);
  const slope = (place: number, across: boolean): number => {
    const [x, y] = [place % TEXELS, Math.floor(place / TEXELS)];
    const there = (by: number): number => height[across ? y * TEXELS + ((x + by + TEXELS) % TEXELS) : ((y + by + TEXELS) % TEXELS) * TEXELS + x] as number;
    return (there(1) - there(-1)) / (2 * step);
  };
  const slopes = [true, false].map((across) => height.map((_, place) => slope(place, across))) as [Float32Array, Float32Array];
  const steepest = Math.max(...slopes.map((some) => some.reduce((most, one) => Math.max(most, Math.abs(one)), 0)));
  const data = new Uint8Array(4 * height.length);
  height.forEach((_, place) => data.set([...slopes.map((some) => 127.5 * (1 + (some[place] as number) / steepest)), (255 * (soft[place] as number)) / deepest, 255], 4 * place));
  const texture = new DataTexture(data, TEXELS, TEXELS);
  texture.wrapS = texture.wrapT = RepeatWrapping;
  texture.magFilter = LinearFilter;
  texture.minFilter = LinearMipmapLinearFilter;
  texture.generateMipmaps = texture.needsUpdate = true;
  made = { texture, steepest };
  return made;
}

/** A square tile blurred by a Gaussian, around its edges. */
function blurred(tile: Float32Array, sigma: number): Float32Array {
  const reach = Math.ceil(3 * sigma);
  const weights = Float32Array.from({ length: 2 * reach + 1 }, (_, i) => Math.exp(-((i - reach) ** 2) / (2 * sigma * sigma)));
  const total = weights.reduce((sum, one) => sum + one, 0);
  /** Along the rows, which become the columns. */
  const along = (from: Float32Array): Float32Array => {
    const into = new Float32Array(from.length);
    for (let y = 0; y < TEXELS; y++) for (let x = 0; x < TEXELS; x++) {
      let sum = 0;
      for (let i = 0; i < weights.length; i++) sum += (weights[i] as number) * (from[y * TEXELS + ((x + i - reach + TEXELS) % TEXELS)] as number);
      into[x * TEXELS + y] = sum / total;
    }
    return into;
  };
  return along(along(tile));
}
