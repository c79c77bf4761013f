// Morph targets on the processor: each moves few vertices, and few of them are at work at once. Faster than the shader
// where the GPU is small or made of software, and it needs a tenth of the memory.
import { BufferAttribute, type BufferGeometry, type Mesh } from 'three';

interface Sparse { vertices: Uint32Array; offsets: Float32Array }

/** The morph targets of one mesh, taken out of its geometry. */
export class SparseMorphs {
  readonly rest: Float32Array;
  readonly positions: Float32Array;
  private readonly restNormals: Float32Array | undefined;
  private readonly places: Sparse[];
  private readonly normals: Sparse[];
  private readonly before: Float32Array;

  constructor(readonly mesh: Mesh) {
    const { geometry } = mesh;
    const { position = [], normal = [] } = geometry.morphAttributes;
    const relative = geometry.morphTargetsRelative;
    this.rest = dense(geometry.getAttribute('position') as BufferAttribute);
    this.places = position.map((target) => sparse(target as BufferAttribute, relative ? undefined : this.rest));
    const rest = geometry.getAttribute('normal') as BufferAttribute | undefined;
    this.restNormals = rest === undefined ? undefined : dense(rest);
    this.normals = this.restNormals === undefined ? [] : normal.map((target) =>
      sparse(target as BufferAttribute, relative ? undefined : this.restNormals));
    this.positions = this.rest.slice();
    geometry.setAttribute('position', new BufferAttribute(this.positions, 3));
    if (this.restNormals !== undefined) geometry.setAttribute('normal', new BufferAttribute(this.restNormals.slice(), 3));
    geometry.morphAttributes = {};
    this.before = new Float32Array(position.length).fill(-1);
  }

  /** Moves the vertices to the mesh's influences; `true` if anything moved. */
  update(force = false): boolean {
    const weights = this.mesh.morphTargetInfluences as number[];
    if (!force && this.before.every((weight, i) => weight === Math.fround(weights[i] as number))) return false;
    this.before.set(weights);
    const { geometry } = this.mesh;
    lay(this.rest, this.places, weights, this.positions);
    (geometry.getAttribute('position') as BufferAttribute).needsUpdate = true;
    if (this.restNormals !== undefined) {
      const normal = geometry.getAttribute('normal') as BufferAttribute;
      lay(this.restNormals, this.normals, weights, normal.array as Float32Array);
      normal.needsUpdate = true;
    }
    return true;
  }
}

function lay(rest: Float32Array, targets: readonly Sparse[], weights: readonly number[], into: Float32Array): void {
  into.set(rest);
  targets.forEach(({ vertices, offsets }, number) => {
    const weight = weights[number] as number;
    if (weight === 0) return;
    for (let i = 0, at = 0; i < vertices.length; i++, at += 3) {
      const v = (vertices[i] as number) * 3;
      into[v] = (into[v] as number) + weight * (offsets[at] as number);
      into[v + 1] = (into[v + 1] as number) + weight * (offsets[at + 1] as number);
      into[v + 2] = (into[v + 2] as number) + weight * (offsets[at + 2] as number);
    }
  });
}

function dense(attribute: BufferAttribute): Float32Array {
  const values = new Float32Array(attribute.count * 3);
  for (let i = 0; i < attribute.count; i++) {
    values[3 * i] = attribute.getX(i);
    values[3 * i + 1] = attribute.getY(i);
    values[3 * i + 2] = attribute.getZ(i);
  }
  return values;
}

function sparse(target: BufferAttribute, rest: Float32Array | undefined): Sparse {
  const all = dense(target);
  if (rest !== undefined) for (let i = 0; i < all.length; i++) all[i] = (all[i] as number) - (rest[i] as number);
  const moved: number[] = [];
  for (let v = 0; v < all.length / 3; v++) if (all[3 * v] !== 0 || all[3 * v + 1] !== 0 || all[3 * v + 2] !== 0) moved.push(v);
  const offsets = new Float32Array(moved.length * 3);
  moved.forEach((v, i) => offsets.set(all.subarray(3 * v, 3 * v + 3), 3 * i));
  return { vertices: Uint32Array.from(moved), offsets };
}

/** All morphed meshes below an object, moved on the processor from now on. */
export function takeOver(meshes: Iterable<Mesh>): SparseMorphs[] {
  const shared = new Set<BufferGeometry>();
  return [...meshes].flatMap((mesh) => {
    const position = mesh.geometry.morphAttributes.position;
    if (position === undefined || position.length === 0) return [];
    if (shared.has(mesh.geometry)) mesh.geometry = mesh.geometry.clone();
    shared.add(mesh.geometry);
    return [new SparseMorphs(mesh)];
  });
}
