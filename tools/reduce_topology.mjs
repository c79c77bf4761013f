// What tools/reduce_topology.py asks of meshoptimizer: FOLDER TRIANGLES, see there.
import { readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { pathToFileURL } from 'node:url';

const [folder, triangles] = process.argv.slice(2);
const library = createRequire(`${process.cwd()}/`).resolve('meshoptimizer');
const { MeshoptSimplifier } = await import(pathToFileURL(library));
await MeshoptSimplifier.ready;
const read = (name) => new Uint8Array(readFileSync(`${folder}/${name}`)).buffer;
const places = new Float32Array(read('places')), further = new Float32Array(read('further'));
const wide = further.length / (places.length / 3);
const [kept, error] = MeshoptSimplifier.simplifyWithAttributes(
  new Uint32Array(read('triangles')), places, 3, further, wide, Array(wide).fill(1), null, 3 * Number(triangles), 1);
writeFileSync(`${folder}/kept`, new Uint8Array(kept.buffer, kept.byteOffset, kept.byteLength));
console.log(`${kept.length / 3} triangles, error ${error}`);
