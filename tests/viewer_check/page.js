// Loads /model.glb as any three.js viewer does and lets the driver look at it at chosen times.
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';

const WIDTH = 480, HEIGHT = 600;
const renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
renderer.setSize(WIDTH, HEIGHT);
renderer.setClearColor(0x8893a0);
document.body.append(renderer.domElement);

const scene = new THREE.Scene();
scene.add(new THREE.HemisphereLight(0xffffff, 0x665544, 1.6));
const key = new THREE.DirectionalLight(0xffffff, 2.2);
key.position.set(0.5, 0.6, 1);
scene.add(key);

const gltf = await new GLTFLoader().setMeshoptDecoder(MeshoptDecoder).loadAsync('/model.glb');
scene.add(gltf.scene);
const mixer = new THREE.AnimationMixer(gltf.scene);
const clip = gltf.animations[0];
const action = mixer.clipAction(clip);
action.setLoop(THREE.LoopOnce);
action.clampWhenFinished = true;
action.play();

const box = new THREE.Box3().setFromObject(gltf.scene);
const centre = box.getCenter(new THREE.Vector3());
const reach = box.getSize(new THREE.Vector3()).y;
const camera = new THREE.PerspectiveCamera(25, WIDTH / HEIGHT, 0.01, 10);
camera.position.set(centre.x, centre.y, box.max.z + reach * 2.6);
camera.lookAt(centre);

function morphed() {
  const meshes = [];
  gltf.scene.traverse((object) => { if (object.morphTargetInfluences) meshes.push(object); });
  return meshes;
}

window.facts = {
  duration: clip.duration,
  extras: gltf.asset.extras,
  size: box.getSize(new THREE.Vector3()).toArray(),
  meshes: morphed().map((mesh) => ({ name: mesh.name, dictionary: mesh.morphTargetDictionary })),
};

window.showAt = (seconds) => {
  action.reset();
  mixer.setTime(seconds);
  renderer.render(scene, camera);
  const turns = {};
  for (const name of ['head', 'eye_left', 'eye_right']) {
    turns[name] = gltf.scene.getObjectByName(name)?.quaternion.toArray() ?? null;
  }
  return { seconds, turns, influences: morphed().map((mesh) => [...mesh.morphTargetInfluences]) };
};
window.ready = true;
