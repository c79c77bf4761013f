// Reading any GLB: meshopt, Draco and KTX2 are unpacked on the page; their decoders are fetched only where a file needs them.
import { REVISION, type WebGLRenderer } from 'three';
import { DRACO_GLTF_CONFIG, DRACOLoader } from 'three/addons/loaders/DRACOLoader.js';
import { GLTFLoader, type GLTF } from 'three/addons/loaders/GLTFLoader.js';
import { KTX2Loader } from 'three/addons/loaders/KTX2Loader.js';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';
/** KTX2 by the worker that lies beside the page (vite.config.ts). */
class Ktx2 extends KTX2Loader {
  override init(): Promise<void> {
    const me = this as unknown as { transcoderPending: Promise<void>; workerSourceURL: string; worker: boolean };
    const pending = (KTX2Loader.prototype as unknown as { init: () => Promise<void> }).init.call(this);
    if (me.worker) return pending;
    me.worker = true;
    me.transcoderPending = pending.then(() => { me.workerSourceURL = `assets/basis_worker-${REVISION}.js`; });
    return me.transcoderPending;
  }
}

let loader: GLTFLoader | undefined;

/** The scene of a GLB; what of it cannot be read is one sentence. */
export async function readFace(glb: ArrayBuffer, renderer: WebGLRenderer): Promise<GLTF> {
  loader ??= made(renderer);
  try {
    return await loader.parseAsync(glb, '');
  } catch (problem) {
    throw new Error(sentence(problem instanceof Error ? problem.message : String(problem)));
  }
}

function made(renderer: WebGLRenderer): GLTFLoader {
  const draco = new DRACOLoader().setDecoderPath(DRACO_GLTF_CONFIG);
  const ktx2 = new Ktx2().detectSupport(renderer);
  return new GLTFLoader().setMeshoptDecoder(MeshoptDecoder).setDRACOLoader(draco).setKTX2Loader(ktx2);
}

function sentence(problem: string): string {
  const extension = /extension[^A-Z]*([A-Z]{2,}_\w+)/i.exec(problem)?.[1];
  if (extension !== undefined) return `This face needs the glTF extension ${extension}, which the page cannot read: export it without.`;
  if (/json|unexpected|token/i.test(problem)) return 'This file is no GLB, or it is damaged: export it again.';
  if (/texture|image/i.test(problem)) return `A texture of this face cannot be read (${problem.slice(0, 80)}): the face is shown without it, if you export it so.`;
  return `This face cannot be shown (${problem.replace(/^THREE\.\w+:\s*/, '').slice(0, 120)}).`;
}
