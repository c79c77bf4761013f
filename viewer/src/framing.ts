// Where of an object the face is, found by what its morph targets move: a head fills the picture on a full body too.
import { Box3, MathUtils, Vector3, type BufferAttribute, type Mesh, type Object3D, type PerspectiveCamera, type SkinnedMesh } from 'three';

const MOVES = 0.2; // of the farthest that any vertex moves

/** The box around what moves, in the world; the whole object where nothing does. */
export function movingBox(object: Object3D): Box3 {
  object.updateWorldMatrix(true, true);
  const meshes: { mesh: Mesh; reach: Float32Array }[] = [];
  object.traverse((part) => {
    const mesh = part as Mesh;
    if (mesh.isMesh === true && (mesh.geometry.morphAttributes['position']?.length ?? 0) > 0) meshes.push({ mesh, reach: reachOf(mesh) });
  });
  const least = MOVES * meshes.reduce((most, { reach }) => reach.reduce((a, b) => Math.max(a, b), most), 0);
  const [box, point] = [new Box3(), new Vector3()];
  for (const { mesh, reach } of meshes) {
    const position = mesh.geometry.getAttribute('position') as BufferAttribute;
    reach.forEach((far, v) => {
      if (far <= least) return;
      point.fromBufferAttribute(position, v);
      if ((mesh as SkinnedMesh).isSkinnedMesh === true) (mesh as SkinnedMesh).applyBoneTransform(v, point);
      box.expandByPoint(point.applyMatrix4(mesh.matrixWorld));
    });
  }
  return box.isEmpty() ? new Box3().setFromObject(object) : box;
}

/** How far any target moves each vertex. */
function reachOf(mesh: Mesh): Float32Array {
  const { morphAttributes, morphTargetsRelative } = mesh.geometry;
  const rest = mesh.geometry.getAttribute('position');
  const far = new Float32Array(rest.count);
  for (const target of morphAttributes['position'] ?? []) {
    for (let v = 0; v < far.length; v++) {
      const [x, y, z] = morphTargetsRelative ? [0, 0, 0] : [rest.getX(v), rest.getY(v), rest.getZ(v)];
      const length = Math.hypot(target.getX(v) - x, target.getY(v) - y, target.getZ(v) - z);
      if (length > (far[v] as number)) far[v] = length;
    }
  }
  return far;
}

export interface FrameOptions {
  /** Heights of what moves that the picture is high: 2.5 shows head and shoulders, 0.9 the face alone. */
  fill?: number;
  /** Degrees around the face (to its left) and above it. */
  around?: number;
  above?: number;
  /** The middle of the picture, from the lower (0) to the upper (1) end of what moves. */
  height?: number;
}

/** Points a camera at the face of an object, from the front unless another side is asked for; gives the point looked at. */
export function frameFace(object: Object3D, camera: PerspectiveCamera, options: FrameOptions = {}): Vector3 {
  return frameBox(movingBox(object), camera, options);
}

/** The same for a box that is known. */
export function frameBox(box: Box3, camera: PerspectiveCamera, { fill = 2.5, around = 0, above = 1, height = 0.66 }: FrameOptions = {}): Vector3 {
  const size = box.max.y - box.min.y || 1;
  const target = box.getCenter(new Vector3()).setY(box.min.y + size * height);
  const far = (size * fill * Math.max(1, 0.78 / camera.aspect)) / (2 * Math.tan(MathUtils.degToRad(camera.fov) / 2));
  const [turn, rise] = [MathUtils.degToRad(around), MathUtils.degToRad(above)];
  camera.position.set(Math.sin(turn) * Math.cos(rise), Math.sin(rise), Math.cos(turn) * Math.cos(rise)).multiplyScalar(far).add(target);
  camera.near = size / 50;
  camera.far = size * 40;
  camera.lookAt(target);
  camera.updateProjectionMatrix();
  return target;
}
