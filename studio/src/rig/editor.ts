// The face under its parameter tree: weights as colours, a brush, the axis of the chosen parameter.
import {
  BufferAttribute, BufferGeometry, DoubleSide, Group, Line, LineBasicMaterial, Mesh, MeshBasicMaterial, MeshLambertMaterial, SphereGeometry, Vector3,
} from 'three';
import type { Stage } from '../stage';
import { deformed, matrices, painted, withWeights, type Influences, type ParameterData, type TreeData } from './tree';

const MM = 1000; // the GLB is in metres
const AXIS_MM = 70;

/** A part of the face at rest, mm. */
export interface PartShape { name: string; vertices: Float32Array; triangles: Uint32Array }
export interface BrushSettings { radius: number; strength: number; mirrored: boolean; erase: boolean }
interface Part { name: string; mesh: Mesh; rest: Float32Array }
interface Step { tree: TreeData; influences: Influences; painted: Set<string> }

export class RigEditor {
  chosen = '';
  readonly values = new Map<string, number>();
  brush: BrushSettings = { radius: 12, strength: 0.25, mirrored: true, erase: false };
  painting = false;
  private parts: Part[] = [];
  private step: Step;
  private done: Step[] = [];
  private marks = new Group();
  private readonly surface = new MeshLambertMaterial({ vertexColors: true, side: DoubleSide });

  constructor(private readonly stage: Stage, tree: TreeData, influences: Influences, private readonly shapes: readonly PartShape[], private readonly changed: () => void) {
    this.step = { tree, influences, painted: new Set() };
    this.chosen = tree.parameters.find(({ kind }) => kind !== 'fixed')?.name ?? '';
  }

  get tree(): TreeData { return this.step.tree; }
  get parameter(): ParameterData | undefined { return this.tree.parameters.find(({ name }) => name === this.chosen); }
  get canUndo(): boolean { return this.done.length > 0; }

  // ------------------------------------------------------------ on and off the stage

  open(): void {
    this.parts = this.shapes.map((shape) => partOf(shape, this.surface));
    const model = new Group();
    model.add(...this.parts.map(({ mesh }) => mesh), this.marks);
    this.show();
    this.stage.instead(model);
  }

  close(): void {
    this.stage.instead(undefined);
    for (const { mesh } of this.parts) mesh.geometry.dispose();
    this.parts = [];
  }

  // ------------------------------------------------------------ the picture

  /** Draws the tree at its values, with the weights of the chosen parameter as colours. */
  show(colours = true): void {
    const moved = matrices(this.tree, this.values);
    for (const part of this.parts) {
      const vertices = deformed(this.tree, this.step.influences, part.name, part.rest, moved);
      const position = part.mesh.geometry.getAttribute('position') as BufferAttribute;
      vertices.forEach((at, i) => { (position.array as Float32Array)[i] = at / MM; });
      position.needsUpdate = true;
      part.mesh.geometry.computeVertexNormals();
      part.mesh.geometry.boundingSphere = null;
      part.mesh.geometry.boundingBox = null;
      if (colours) this.colour(part);
    }
    this.mark();
    this.stage.touch();
  }

  /** Vertices of all parts as they are drawn, mm: for the test that holds them against the server's. */
  vertices(): Float32Array[] {
    const moved = matrices(this.tree, this.values);
    return this.parts.map(({ name, rest }) => deformed(this.tree, this.step.influences, name, rest, moved));
  }

  private colour(part: Part): void {
    const count = part.rest.length / 3;
    const values = new Float32Array(3 * count).fill(0.34);
    const influence = this.step.influences[this.chosen]?.[part.name];
    influence?.vertices.forEach((v, i) => values.set(heat(influence.weights[i] as number), 3 * v));
    part.mesh.geometry.setAttribute('color', new BufferAttribute(values, 3));
  }

  /** A line through the pivot along the axis, or along the translation. */
  private mark(): void {
    this.marks.clear();
    const { parameter } = this;
    if (parameter === undefined || parameter.kind === 'fixed') return;
    const turning = parameter.kind === 'rotation';
    const direction = new Vector3().fromArray((turning ? parameter.axis : parameter.translation) ?? [0, 0, 0]);
    const point = turning ? new Vector3().fromArray(parameter.pivot ?? [0, 0, 0]) : this.middle();
    const reach = turning ? direction.clone().normalize().multiplyScalar(AXIS_MM) : direction;
    const ends = (turning ? [point.clone().sub(reach), point.clone().add(reach)] : [point, point.clone().add(reach)]).map((end) => end.divideScalar(MM));
    const line = new Line(new BufferGeometry().setFromPoints(ends), new LineBasicMaterial({ color: 0xffd24a, depthTest: false, transparent: true }));
    const ball = new Mesh(new SphereGeometry(0.0022, 12, 8), new MeshBasicMaterial({ color: 0xffd24a, depthTest: false, transparent: true }));
    ball.position.copy(turning ? point.divideScalar(MM) : (ends[1] as Vector3));
    for (const one of [line, ball]) one.renderOrder = 10;
    this.marks.add(line, ball);
  }

  /** The middle of what the chosen parameter moves, by weight. */
  private middle(): Vector3 {
    const [sum, point] = [new Vector3(), new Vector3()];
    let total = 0;
    for (const { name, rest } of this.parts) {
      const influence = this.step.influences[this.chosen]?.[name];
      influence?.vertices.forEach((v, i) => {
        const weight = Math.abs(influence.weights[i] as number);
        sum.addScaledVector(point.fromArray(rest, 3 * v), weight);
        total += weight;
      });
    }
    return total > 0 ? sum.divideScalar(total) : sum;
  }

  // ------------------------------------------------------------ changes

  /** Changes fields of the chosen parameter; `keep` makes it a step of undo. */
  change(fields: Partial<ParameterData>, keep = true): void {
    if (keep) this.keep();
    const parameters = this.tree.parameters.map((one) => (one.name === this.chosen ? { ...one, ...fields } : one));
    this.step = { ...this.step, tree: { ...this.tree, parameters } };
    this.show(false);
    this.changed();
  }

  choose(name: string): void {
    this.values.clear();
    this.chosen = name;
    this.show();
    this.changed();
  }

  undo(): void {
    const before = this.done.pop();
    if (before === undefined) return;
    this.step = before;
    this.show();
    this.changed();
  }

  private keep(): void {
    this.done.push(this.step);
    if (this.done.length > 100) this.done.shift();
  }

  /** Begins a stroke at a point of the canvas; `false` if nothing lies there. */
  begin(x: number, y: number): boolean {
    const hit = this.under(x, y);
    if (hit === undefined) return false;
    this.keep();
    this.touch(hit);
    return true;
  }

  stroke(x: number, y: number): void {
    const hit = this.under(x, y);
    if (hit !== undefined) this.touch(hit);
  }

  end(): void { this.changed(); }

  private under(x: number, y: number): { part: Part; centre: [number, number, number] } | undefined {
    const hit = this.stage.under(x, y, this.parts.map(({ mesh }) => mesh));
    const part = this.parts.find(({ mesh }) => mesh === hit?.object);
    if (hit?.face === undefined || hit.face === null || part === undefined) return undefined;
    const at = 3 * hit.face.a; // where that corner stands at rest: the brush works on the face as it is at rest
    return { part, centre: [part.rest[at] as number, part.rest[at + 1] as number, part.rest[at + 2] as number] };
  }

  private touch({ part, centre }: { part: Part; centre: [number, number, number] }): void {
    const own = this.step.influences[this.chosen] ?? {};
    const weights = painted(own[part.name], part.rest, { centre, ...this.brush });
    this.step = {
      ...this.step, influences: { ...this.step.influences, [this.chosen]: { ...own, [part.name]: weights } },
      painted: new Set([...this.step.painted, this.chosen]),
    };
    this.show();
  }

  /** The configuration as it stands: painted parameters list their weights by vertex. */
  config(): TreeData {
    const parameters = this.tree.parameters.map((one) => (this.step.painted.has(one.name) ? withWeights(one, this.step.influences[one.name] ?? {}) : one));
    return { ...this.tree, parameters };
  }
}

function partOf({ name, vertices, triangles }: PartShape, surface: MeshLambertMaterial): Part {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(vertices.map((at) => at / MM), 3));
  geometry.setIndex(new BufferAttribute(triangles, 1));
  geometry.computeVertexNormals();
  const mesh = new Mesh(geometry, surface);
  mesh.name = name;
  mesh.frustumCulled = false;
  return { name, mesh, rest: vertices };
}

/** Grey without weight; blue, green, yellow, red as it rises; violet below zero. */
export function heat(weight: number): [number, number, number] {
  if (weight < 0) return [0.5, 0.1, 0.6];
  const stops: [number, number, number][] = [[0.3, 0.32, 0.38], [0.12, 0.3, 0.75], [0.1, 0.6, 0.3], [0.85, 0.65, 0.08], [0.8, 0.12, 0.06]];
  const at = Math.min(weight, 1) * (stops.length - 1);
  const place = Math.min(Math.floor(at), stops.length - 2);
  const [from, to] = [stops[place] as [number, number, number], stops[place + 1] as [number, number, number]];
  return from.map((one, i) => one + (at - place) * ((to[i] as number) - one)) as [number, number, number];
}
