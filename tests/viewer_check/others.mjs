// node others.mjs FILE... : each GLB read by Babylon.js (without a window) and by glTF-Transform; one JSON line each.
import { readFile } from 'node:fs/promises';
import { FreeCamera, NullEngine, Scene, SceneLoader, Vector3 } from '@babylonjs/core';
import '@babylonjs/loaders/glTF/index.js';
import { NodeIO } from '@gltf-transform/core';
import { ALL_EXTENSIONS } from '@gltf-transform/extensions';
import { MeshoptDecoder } from 'meshoptimizer/decoder';

console.debug = console.info = console.warn = () => {};
const print = console.log;
console.log = () => {};

async function babylon(bytes) {
  const scene = new Scene(new NullEngine());
  new FreeCamera('camera', Vector3.Zero(), scene);
  const url = `data:model/gltf-binary;base64,${bytes.toString('base64')}`;
  const read = await SceneLoader.ImportMeshAsync('', '', url, scene, undefined, '.glb');
  const clip = read.animationGroups[0];
  clip.start(false);
  clip.goToFrame(clip.to);
  const face = read.meshes.find((mesh) => mesh.name.startsWith('face') && mesh.morphTargetManager).morphTargetManager;
  const weights = {};
  for (let i = 0; i < face.numTargets; i += 1) weights[face.getTarget(i).name] = face.getTarget(i).influence;
  return { clips: read.animationGroups.map((group) => group.name), weights };
}

async function transform(bytes) {
  await MeshoptDecoder.ready;
  const io = new NodeIO().registerExtensions(ALL_EXTENSIONS).registerDependencies({ 'meshopt.decoder': MeshoptDecoder });
  const document = await io.readBinary(new Uint8Array(bytes));
  const root = document.getRoot();
  const face = root.listMeshes().find((mesh) => mesh.getName() === 'face');
  const clip = root.listAnimations()[0];
  const channel = clip.listChannels().find(
    (one) => one.getTargetPath() === 'weights' && one.getTargetNode().getMesh() === face,
  );
  const names = face.getExtras().targetNames;
  const output = channel.getSampler().getOutput();
  const last = output.getCount() - names.length;
  const weights = {};
  names.forEach((name, i) => { weights[name] = output.getElement(last + i, [])[0]; });
  const moved = {};
  names.forEach((name, i) => {
    const accessor = face.listPrimitives()[0].listTargets()[i].getAttribute('POSITION');
    let most = 0;
    for (let k = 0; k < accessor.getCount(); k += 1) most = Math.max(most, Math.hypot(...accessor.getElement(k, [])));
    moved[name] = most;
  });
  return { clips: root.listAnimations().map((one) => one.getName()), weights, moved };
}

for (const file of process.argv.slice(2)) {
  const bytes = await readFile(file);
  const packed = bytes.includes('EXT_meshopt_compression'); // Babylon fetches its decoder from the network
  print(JSON.stringify({ file, babylon: packed ? null : await babylon(bytes), transform: await transform(bytes) }));
}
process.exit(0);
