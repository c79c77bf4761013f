// The parameter tree, posed on the page: the equations of docs/rig.md (Frydrych et al. 2003), row vectors, mm.
import { Matrix4, Vector3 } from 'three';

export type Kind = 'rotation' | 'translation' | 'fixed';
export interface RegionData { shape: string; part: string | null; weights?: [number, number, number][]; [other: string]: unknown }
export interface ParameterData {
  name: string; kind: Kind; axis?: number[]; pivot?: number[]; translation?: number[]; parent: string | null; group: string | null;
  drives: Record<string, number>; limits: [number, number] | null; regions: RegionData[]; remarks: string[];
}
export interface TreeData { format: string; version: number; remarks: string[]; parameters: ParameterData[] }
export interface Influence { vertices: number[]; weights: number[] }
export type Influences = Record<string, Record<string, Influence>>;

/** Whether a parameter belongs to group 1. */
export function isSkeletal(tree: TreeData, { name, group }: ParameterData): boolean {
  return group === null ? tree.parameters.some(({ parent }) => parent === name) : group === 'skeletal';
}

/** What a parameter does at a value, as three.js writes matrices (for column vectors: the transpose of ours). */
export function ownMatrix({ kind, axis = [0, 0, 0], pivot = [0, 0, 0], translation = [0, 0, 0] }: ParameterData, value: number): Matrix4 {
  const matrix = new Matrix4();
  if (kind === 'translation') return matrix.makeTranslation(...(translation.map((one) => one * value) as [number, number, number]));
  const direction = new Vector3().fromArray(axis);
  if (kind === 'fixed' || direction.lengthSq() === 0) return matrix;
  const point = new Vector3().fromArray(pivot);
  const back = point.clone().negate();
  matrix.makeRotationAxis(direction.normalize(), (value * Math.PI) / 180);
  return new Matrix4().makeTranslation(point).multiply(matrix).multiply(new Matrix4().makeTranslation(back));
}

/** The matrix of each parameter as its stage applies it; parameters whose matrix is none are left out. */
export function matrices(tree: TreeData, values: ReadonlyMap<string, number>): Map<string, Matrix4> {
  const byName = new Map(tree.parameters.map((parameter) => [parameter.name, parameter]));
  const totals = new Map<string, Matrix4>();
  const total = (name: string | null, depth = 0): Matrix4 => {
    const parameter = name === null ? undefined : byName.get(name);
    if (parameter === undefined || depth > byName.size) return new Matrix4();
    const known = totals.get(parameter.name);
    if (known !== undefined) return known;
    const made = total(parameter.parent, depth + 1).clone().multiply(ownMatrix(parameter, values.get(parameter.name) ?? 0));
    totals.set(parameter.name, made);
    return made;
  };
  const none = new Matrix4();
  const found = new Map<string, Matrix4>();
  for (const parameter of tree.parameters) {
    let matrix = total(parameter.name);
    if (!isSkeletal(tree, parameter)) {
      const above = total(parameter.parent);
      matrix = above.clone().multiply(ownMatrix(parameter, values.get(parameter.name) ?? 0)).multiply(above.clone().invert());
    }
    if (matrix.elements.some((element, i) => Math.abs(element - (none.elements[i] as number)) > 1e-12)) found.set(parameter.name, matrix);
  }
  return found;
}

/** The vertices of one part (x, y, z, mm) under a tree. */
export function deformed(tree: TreeData, influences: Influences, part: string, rest: Float32Array, moved: ReadonlyMap<string, Matrix4>): Float32Array {
  const skeletal = tree.parameters.filter((parameter) => isSkeletal(tree, parameter));
  const claimed = new Float64Array(rest.length / 3);
  for (const { name } of skeletal) {
    const influence = influences[name]?.[part];
    influence?.vertices.forEach((v, i) => { claimed[v] = (claimed[v] as number) + (influence.weights[i] as number); });
  }
  const first = rest.slice();
  for (const { name } of skeletal) lay(rest, first, influences[name]?.[part], moved.get(name), claimed);
  const second = first.slice();
  for (const parameter of tree.parameters) {
    if (!isSkeletal(tree, parameter)) lay(first, second, influences[parameter.name]?.[part], moved.get(parameter.name));
  }
  return second;
}

/** Adds to `into` what a matrix does to `from`, by weights; shared out over what is claimed. */
function lay(from: Float32Array, into: Float32Array, influence: Influence | undefined, matrix: Matrix4 | undefined, claimed?: Float64Array): void {
  if (influence === undefined || matrix === undefined) return;
  const m = matrix.elements as unknown as Float64Array;
  const at = (i: number): number => m[i] as number;
  influence.vertices.forEach((v, i) => {
    const whole = claimed?.[v] ?? 1;
    const weight = whole > 0 ? (influence.weights[i] as number) / whole : 0;
    const [x, y, z] = [from[3 * v] as number, from[3 * v + 1] as number, from[3 * v + 2] as number];
    into[3 * v] = (into[3 * v] as number) + weight * (at(0) * x + at(4) * y + at(8) * z + at(12) - x);
    into[3 * v + 1] = (into[3 * v + 1] as number) + weight * (at(1) * x + at(5) * y + at(9) * z + at(13) - y);
    into[3 * v + 2] = (into[3 * v + 2] as number) + weight * (at(2) * x + at(6) * y + at(10) * z + at(14) - z);
  });
}

const STEP = 1e4; // weights are kept to four decimals

/** Weights of one part as the runs of a configuration. */
export function runsOf({ vertices, weights }: Influence): [number, number, number][] {
  const order = vertices.map((_, i) => i).sort((a, b) => (vertices[a] as number) - (vertices[b] as number));
  const runs: [number, number, number][] = [];
  for (const i of order) {
    const [v, weight] = [vertices[i] as number, Math.round((weights[i] as number) * STEP) / STEP];
    if (weight === 0) continue;
    const last = runs.at(-1);
    if (last !== undefined && last[1] === v - 1 && last[2] === weight) last[1] = v;
    else runs.push([v, v, weight]);
  }
  return runs;
}

/** A parameter whose regions are its weights, vertex by vertex. */
export function withWeights(parameter: ParameterData, influence: Record<string, Influence>): ParameterData {
  const regions = Object.entries(influence).map(([part, weights]): RegionData => ({ shape: 'weights', part, weights: runsOf(weights) }));
  return { ...parameter, regions: regions.filter(({ weights }) => weights !== undefined && weights.length > 0) };
}

export interface Brush { centre: [number, number, number]; radius: number; strength: number; mirrored: boolean; erase: boolean }

/** Weights of a part (vertices at rest, mm) after one touch of a brush. */
export function painted(influence: Influence | undefined, rest: Float32Array, { centre, radius, strength, mirrored, erase }: Brush): Influence {
  const dense = new Float64Array(rest.length / 3);
  influence?.vertices.forEach((v, i) => { dense[v] = influence.weights[i] as number; });
  const centres = mirrored && Math.abs(centre[0]) > 1e-3 ? [centre, [-centre[0], centre[1], centre[2]] as const] : [centre];
  for (let v = 0; v < dense.length; v++) {
    const nearest = Math.min(...centres.map(([x, y, z]) => Math.hypot((rest[3 * v] as number) - x, (rest[3 * v + 1] as number) - y, (rest[3 * v + 2] as number) - z)));
    if (nearest >= radius) continue;
    const share = strength * (1 - (nearest / radius) ** 2) ** 2;
    const now = dense[v] as number;
    dense[v] = erase ? Math.max(now - share, 0) : Math.max(now, Math.min(now + share, 1));
  }
  const vertices = [...dense.keys()].filter((v) => (dense[v] as number) > 0.5 / STEP || (dense[v] as number) < -0.5 / STEP);
  return { vertices, weights: vertices.map((v) => dense[v] as number) };
}
