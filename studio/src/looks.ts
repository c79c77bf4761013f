// Lights, cameras and skin. Hand-made by eye.
import {
  DirectionalLight, Group, HemisphereLight, MeshLambertMaterial, MeshStandardMaterial, Vector3, type Material,
} from 'three';

/** `full`: skin, reflections, shadows. `plain`: what a graphics card made of software can draw in time. */
export type Quality = 'full' | 'plain';

/** Light from a direction (x to the speaker's left, y up, z to the viewer), with a colour and a strength. */
interface Lamp { from: [number, number, number]; colour: number; strength: number; shadow?: boolean }
interface Lighting { lamps: Lamp[]; sky: number; ground: number; dome: number; around: number; back: [string, string] }

export const LIGHTINGS: Readonly<Record<string, Lighting>> = {
  portrait: {
    lamps: [
      { from: [0.55, 0.5, 0.8], colour: 0xfff0e2, strength: 2.15, shadow: true },
      { from: [-0.8, 0.05, 0.6], colour: 0xcfe0ff, strength: 0.5 },
      { from: [-0.85, 0.42, -0.52], colour: 0xe8f0ff, strength: 2.4 },
    ],
    sky: 0xdfe8f5, ground: 0x4a3a33, dome: 0.3, around: 0.3, back: ['#3b3e44', '#17181b'],
  },
  soft: {
    lamps: [
      { from: [-0.3, 0.6, 1], colour: 0xfff6ec, strength: 1.3, shadow: true },
      { from: [0.8, 0.3, 0.8], colour: 0xffffff, strength: 0.8 },
      { from: [0, 0.8, -1], colour: 0xffffff, strength: 1 },
    ],
    sky: 0xffffff, ground: 0x8a7a70, dome: 0.55, around: 0.6, back: ['#55585e', '#2a2c30'],
  },
  dramatic: {
    lamps: [
      { from: [-1, 0.5, 0.35], colour: 0xffdfc0, strength: 3.2, shadow: true },
      { from: [0.9, 0.4, -0.8], colour: 0x8fb2ff, strength: 3.2 },
    ],
    sky: 0x8fa5c8, ground: 0x181414, dome: 0.14, around: 0.14, back: ['#1e2025', '#0a0a0c'],
  },
  even: {
    lamps: [
      { from: [-0.6, 0.3, 1], colour: 0xffffff, strength: 1.15 },
      { from: [0.6, 0.3, 1], colour: 0xffffff, strength: 1.15 },
    ],
    sky: 0xffffff, ground: 0xbbbbbb, dome: 0.9, around: 0.4, back: ['#7b7e83', '#5c5f64'],
  },
};

/** From where a face is seen: degrees around it and above it; the picture's height and its middle in heights of what moves. */
export interface View { around: number; above: number; fill: number; height: number }
export const VIEWS: Readonly<Record<string, View>> = {
  portrait: { around: 0, above: 1, fill: 2.5, height: 0.66 },
  'three-quarter': { around: 32, above: 3, fill: 2.5, height: 0.66 },
  profile: { around: 82, above: 1, fill: 2.5, height: 0.66 },
  mouth: { around: 0, above: -2, fill: 0.75, height: 0.3 },
};

/** The lamps of a lighting, for a face of this size about its centre. */
export function lampsOf({ lamps, sky, ground, dome }: Lighting, centre: Vector3, size: number, shadows: boolean, quality: Quality): Group {
  const group = new Group();
  group.add(new HemisphereLight(sky, ground, quality === 'full' ? dome : dome * 2.2));
  for (const { from, colour, strength, shadow } of lamps) {
    const lamp = new DirectionalLight(colour, strength);
    lamp.position.copy(centre).addScaledVector(new Vector3(...from).normalize(), size * 2);
    lamp.target.position.copy(centre);
    if (shadow === true && shadows) castShadow(lamp, size);
    group.add(lamp, lamp.target);
  }
  return group;
}

function castShadow(lamp: DirectionalLight, size: number): void {
  lamp.castShadow = true;
  lamp.shadow.mapSize.set(1024, 1024);
  const { camera } = lamp.shadow;
  camera.left = camera.bottom = -size * 0.75;
  camera.right = camera.top = size * 0.75;
  camera.near = size * 0.5;
  camera.far = size * 4;
  lamp.shadow.bias = -0.0006;
  lamp.shadow.normalBias = size * 0.006;
  lamp.shadow.radius = 5;
}

/** A surface as software can draw it in time. */
export function matt(material: Material): Material {
  if (!(material instanceof MeshStandardMaterial)) return material;
  const { name, color, map, vertexColors, side, transparent, opacity, alphaTest, alphaMap } = material;
  const plain = new MeshLambertMaterial({ color, map, vertexColors, side, transparent, opacity, alphaTest, alphaMap });
  plain.name = name;
  return plain;
}
