import { describe, expect, it } from 'vitest';
import { BufferGeometry, Float32BufferAttribute, Group, Mesh, PerspectiveCamera, Vector3 } from 'three';
import { frameFace, movingBox } from '../src/framing.js';

/** A body of 1.8 m whose face, at 1.6 to 1.7 m, is moved by one target. */
function body(): Group {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new Float32BufferAttribute([0, 0, 0, 0.3, 1.8, 0, -0.05, 1.6, 0.1, 0.05, 1.7, 0.1], 3));
  geometry.morphAttributes['position'] = [new Float32BufferAttribute([0, 0, 0, 0, 1e-4, 0, 0, 0.02, 0, 0, 0.01, 0], 3)];
  geometry.morphTargetsRelative = true;
  return new Group().add(new Mesh(geometry));
}

describe('the face of a full body', () => {
  it('is what its targets move', () => {
    const box = movingBox(body());
    expect([box.min.y, box.max.y]).toEqual([expect.closeTo(1.6, 5), expect.closeTo(1.7, 5)]);
  });
  it('fills the picture', () => {
    const camera = new PerspectiveCamera(25, 1, 0.01, 10);
    const target = frameFace(body(), camera, { fill: 1.25 });
    camera.updateMatrixWorld();
    expect(target.y).toBeCloseTo(1.666, 2);
    const [low, high] = [1.6, 1.7].map((y) => new Vector3(0, y, 0.1).project(camera).y);
    expect((high as number) - (low as number)).toBeGreaterThan(1.3);
  });
});
