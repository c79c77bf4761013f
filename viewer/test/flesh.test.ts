import { BoxGeometry, Mesh, MeshStandardMaterial, PlaneGeometry } from 'three';
import { describe, expect, it } from 'vitest';
import { findDepth, findThin, pores, tilesOf } from '../src/flesh';
import { dressFace } from '../src/materials';

const MM = 0.001;

/** A box of skin in metres, with a vertex every two millimetres. */
const slab = (thick: number): Mesh => {
  const mesh = new Mesh(new BoxGeometry(40 * MM, 40 * MM, thick * MM, 20, 20, Math.max(Math.round(thick / 2), 1)), new MeshStandardMaterial({ name: 'skin' }));
  findThin(mesh, MM);
  return mesh;
};

describe('flesh', () => {
  it('is thin where skin lies behind skin, and nowhere in a thick block', () => {
    const thin = slab(4).geometry.getAttribute('mienThin').array as Float32Array;
    const thick = slab(40).geometry.getAttribute('mienThin').array as Float32Array;
    expect(Math.max(...thin)).toBeGreaterThan(0.6);
    expect(Math.max(...thick)).toBe(0);
  });

  it('lies the deeper in the mouth the farther it is from the front, whichever way the mesh is turned', () => {
    const mesh = new Mesh(new BoxGeometry(2, 2, 4));
    mesh.rotation.y = Math.PI / 2;
    findDepth(mesh);
    const [deep, place] = [mesh.geometry.getAttribute('mienDeep'), mesh.geometry.getAttribute('position')];
    for (let v = 0; v < place.count; v++) expect(deep.getX(v)).toBeCloseTo((place.getX(v) + 1) / 2);
  });

  it('has pores of the right size where its texture says how large it is', () => {
    expect(tilesOf(new Mesh(new PlaneGeometry(280 * MM, 280 * MM)), MM)).toBe(10);
    const { texture, steepest } = pores();
    const depths = (texture.image.data as Uint8Array).filter((_, place) => place % 4 === 2);
    expect(Math.max(...depths)).toBe(255);
    expect(steepest).toBeGreaterThan(0.1);
  });

  it('takes light by name, in a head with eyes of a known size', () => {
    const [skin, eye] = [new Mesh(new BoxGeometry(40 * MM, 40 * MM, 4 * MM, 20, 20, 2), new MeshStandardMaterial({ name: 'skin' })), new Mesh(new BoxGeometry(28 * MM, 28 * MM, 28 * MM), new MeshStandardMaterial({ name: 'eye' }))];
    const teeth = new Mesh(new BoxGeometry(1, 1, 1), new MeshStandardMaterial({ name: 'teeth' }));
    skin.add(eye, teeth);
    dressFace(skin);
    expect(skin.geometry.getAttribute('mienThin')).toBeDefined();
    expect(teeth.geometry.getAttribute('mienDeep')).toBeDefined();
    expect(eye.geometry.getAttribute('mienDeep')).toBeUndefined();
  });
});
