// Any three.js face, moved by channels.
import { Quaternion, type Mesh, type Object3D } from 'three';
import { recipesOf, turningNode, type Recipe } from './names.js';
import { EYE_DEGREES } from './tables.js';
import { turnOf } from './turns.js';

interface Driven { readonly mesh: Mesh; readonly target: number; readonly parts: readonly (readonly [string, number])[] }
interface Turning { readonly node: Object3D; readonly rest: Quaternion; readonly above: Quaternion; readonly part: string }
interface Plan { readonly weights: { mesh: Mesh; target: number; columns: Int32Array; gains: Float32Array }[]; readonly column: Map<string, number> }

export interface RigOptions {
  /** Degrees that an eye turns at weight 1 of its eyeLook channels. */
  eyeDegrees?: { up: number; down: number; in: number; out: number };
  /** What drives targets by their names, in place of what their names say: as `mien face inspect` tells it. */
  recipes?: Readonly<Record<string, Recipe>>;
}

/**
 * What of an object channels can move: morph targets with known names on all its meshes, and the nodes of head and eyes.
 * The pose in which the object is given is its rest.
 */
export class FaceRig {
  /** Channels that move something. */
  readonly channels: ReadonlySet<string>;
  /** Morph targets whose name is not known, as `mesh: target`; they are moved by a motion that has their very name. */
  readonly unknown: readonly string[];
  private readonly driven: Driven[] = [];
  private readonly byName: { mesh: Mesh; target: number; name: string }[] = [];
  private readonly turning: Turning[];
  private readonly degrees: Readonly<Record<string, number>>;
  private readonly plans = new WeakMap<readonly string[], Plan>();
  private readonly turn = new Quaternion();

  constructor(readonly object: Object3D, options: RigOptions = {}) {
    this.degrees = options.eyeDegrees ?? EYE_DEGREES;
    object.traverse((part) => this.addMesh(part as Mesh, options.recipes));
    this.turning = turningNodes(object);
    const known = this.driven.flatMap(({ parts }) => parts.map(([name]) => name));
    this.channels = new Set([...known, ...this.turning.flatMap(({ part }) => channelsOfTurn(part))]);
    this.unknown = this.byName.map(({ mesh, name }) => `${mesh.name}: ${name}`);
  }

  private addMesh(mesh: Mesh, given?: Readonly<Record<string, Recipe>>): void {
    const dictionary = mesh.morphTargetDictionary;
    if (dictionary === undefined || mesh.morphTargetInfluences === undefined) return;
    const names = Object.keys(dictionary);
    recipesOf(names).forEach((known, place) => {
      const name = names[place] as string;
      const recipe = given === undefined ? known : given[name] ?? {};
      const target = dictionary[name] as number;
      const parts = Object.entries(recipe);
      if (parts.length > 0) this.driven.push({ mesh, target, parts });
      else if (given === undefined) this.byName.push({ mesh, target, name });
    });
  }

  /** Moves the face to one row of values, in the order of `channels`; channels that are not among them are at 0. */
  apply(channels: readonly string[], values: ArrayLike<number>): void {
    const plan = this.plan(channels);
    for (const { mesh, target, columns, gains } of plan.weights) {
      let weight = 0;
      for (let i = 0; i < columns.length; i++) weight += (gains[i] as number) * (values[columns[i] as number] as number);
      (mesh.morphTargetInfluences as number[])[target] = Math.min(Math.max(weight, 0), 1);
    }
    const value = (name: string): number => {
      const column = plan.column.get(name);
      return column === undefined ? 0 : (values[column] as number);
    };
    for (const { node, rest, above, part } of this.turning) {
      const [yaw, pitch, roll] = part === 'head' ? headAngles(value) : this.eyeAngles(part, value);
      turnOf(yaw, pitch, roll, this.turn);
      node.quaternion.copy(above).invert().multiply(this.turn).multiply(above).multiply(rest);
    }
  }

  private eyeAngles(part: string, value: (name: string) => number): [number, number, number] {
    const side = part === 'eyeLeft' ? 'Left' : 'Right';
    const look = (way: string): number => value(`eyeLook${way}${side}`) * (this.degrees[way.toLowerCase()] ?? 0);
    const outward = look('Out') - look('In');
    return [side === 'Left' ? outward : -outward, look('Up') - look('Down'), 0];
  }

  private plan(channels: readonly string[]): Plan {
    const made = this.plans.get(channels);
    if (made !== undefined) return made;
    const column = new Map(channels.map((name, place) => [name, place]));
    const entry = (mesh: Mesh, target: number, parts: readonly (readonly [string, number])[]) => ({
      mesh, target,
      columns: Int32Array.from(parts, ([name]) => column.get(name) as number),
      gains: Float32Array.from(parts, ([, gain]) => gain),
    });
    const weights = this.driven.map(({ mesh, target, parts }) =>
      entry(mesh, target, partsAmong(parts, column)));
    for (const { mesh, target, name } of this.byName) {
      if (column.has(name)) weights.push(entry(mesh, target, [[name, 1]]));
    }
    const plan = { weights, column };
    this.plans.set(channels, plan);
    return plan;
  }
}

function partsAmong(parts: readonly (readonly [string, number])[], column: Map<string, number>): (readonly [string, number])[] {
  return parts.filter(([name]) => column.has(name));
}

const headAngles = (value: (name: string) => number): [number, number, number] =>
  [value('headYaw'), value('headPitch'), value('headRoll')];

function channelsOfTurn(part: string): string[] {
  if (part === 'head') return ['headYaw', 'headPitch', 'headRoll'];
  return ['Up', 'Down', 'In', 'Out'].map((way) => `eyeLook${way}${part === 'eyeLeft' ? 'Left' : 'Right'}`);
}

/** The nodes that turn, each with the turn of all above it at rest. */
function turningNodes(object: Object3D): Turning[] {
  object.updateWorldMatrix(true, true);
  const nodes: Object3D[] = [];
  object.traverse((node) => { if (turnsByItself(node)) nodes.push(node); });
  const names = nodes.map(({ name }) => name);
  const base = object.parent?.getWorldQuaternion(new Quaternion()) ?? new Quaternion();
  return ['head', 'eyeLeft', 'eyeRight'].flatMap((part) => {
    const node = nodes[turningNode(part, names)];
    if (node === undefined) return [];
    const above = base.clone().invert().multiply(node.parent?.getWorldQuaternion(new Quaternion()) ?? base);
    return [{ node, part, rest: node.quaternion.clone(), above }];
  });
}

/** Whether turning a node turns what it is named for about its own place: a bone, or a mesh that stands there. */
function turnsByItself(node: Object3D & { isSkinnedMesh?: boolean; isMesh?: boolean }): boolean {
  if (node.isSkinnedMesh === true || node.children.some((child) => (child as typeof node).isSkinnedMesh === true)) return false;
  return node.isMesh !== true || node.position.lengthSq() > 0;
}
