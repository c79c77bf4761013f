// node viewer.mjs PACKAGE VIEWER ADDRESS CHROMIUM FACE.glb LINE.json [OTHERS.glb ...]
// Runs the page of the viewer's README as it stands, once with the stream at ADDRESS and once with a file, and prints how
// the face moved as one JSON line; then with the file on other faces, maybe compressed ones. PACKAGE holds playwright-core
// and three. Pictures of the others lie beside them.
import { readFile } from 'node:fs/promises';
import { createServer } from 'node:http';
import { createRequire } from 'node:module';
import { extname, join, normalize } from 'node:path';

const [packageFolder, viewer, address, executablePath, face, line, ...others] = process.argv.slice(2);
const { chromium } = createRequire(join(packageFolder, 'package.json'))('playwright-core');
const readme = await readFile(join(viewer, 'README.md'), 'utf8');
const example = /```js\n([\s\S]*?)```/.exec(readme)[1];
// The stream of the test goes round and round, which a sound does not: it is listened to without one.
const stream = example.replace(/document\.querySelector\('button'\).*$/m, `face.listen('${address}');`);
const played = example.replace(/document\.querySelector\('button'\).*$/m, "await face.play('line.json');");
const decoding = (code, number) => `import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';
import { KTX2Loader } from 'three/addons/loaders/KTX2Loader.js';
${code.replace('new GLTFLoader()', "new GLTFLoader().setMeshoptDecoder(MeshoptDecoder).setKTX2Loader(new KTX2Loader().setTranscoderPath('/three/examples/jsm/libs/basis/').detectSupport(renderer))").replace("'face.glb'", `'/other/${number}.glb'`).replace("'line.json'", "'/line.json'")}`;
const page = (code) => `<!doctype html><meta charset="utf-8"><link rel="icon" href="data:,"><canvas width="200" height="200"></canvas><button>listen</button>
<script type="importmap">{"imports": {"three": "/three/build/three.module.js", "three/addons/": "/three/examples/jsm/", "mien-viewer": "/viewer/index.js"}}</script>
<script type="module">${code}\nwindow.face = face;</script>`;
const TYPES = { '.js': 'text/javascript', '.html': 'text/html', '.json': 'application/json' };
const roots = { three: join(packageFolder, 'node_modules', 'three'), viewer: join(viewer, 'dist') };
const server = createServer(async (request, response) => {
  const path = normalize(decodeURIComponent(new URL(request.url, 'http://localhost').pathname));
  const [, root, ...rest] = path.split('/');
  try {
    const body = path === '/stream.html' ? page(stream) : path === '/file.html' ? page(played)
      : root === 'page' ? page(decoding(played, Number.parseInt(rest[0], 10))) : root === 'other' ? await readFile(others[Number.parseInt(rest[0], 10)])
      : await readFile(path === '/face.glb' ? face : path === '/line.json' ? line : join(roots[root], ...rest));
    response.writeHead(200, { 'content-type': TYPES[extname(path)] ?? 'application/octet-stream' }).end(body);
  } catch {
    response.writeHead(404).end();
  }
});
await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));

const browser = await chromium.launch({ executablePath, args: ['--headless', '--no-sandbox', '--use-angle=swiftshader',
  '--enable-unsafe-swiftshader', '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync'] });
try {
  const seen = { lines: example.trim().split('\n').filter((text) => text.trim() !== '').length, complaints: [] };
  for (const name of ['stream', 'file', ...others.map((_, number) => `page/${number}`)]) {
    const tab = await browser.newPage();
    tab.on('pageerror', (error) => seen.complaints.push(String(error)));
    tab.on('console', (told) => { if (told.type() === 'error') seen.complaints.push(told.text()); });
    await tab.goto(`http://127.0.0.1:${server.address().port}/${name}.html`);
    await tab.waitForFunction(() => window.face !== undefined, null, { timeout: 60_000 }).catch((problem) => { throw new Error(`${name}: ${problem.message}; ${seen.complaints.join('; ')}`); });
    seen[name] = await tab.evaluate(async () => {
      const values = [];
      for (let look = 0; look < 12; look++) {
        window.face.update();
        let jaw = 0;
        window.face.rig.object.traverse((part) => {
          const place = part.morphTargetDictionary?.jawOpen;
          if (place !== undefined) jaw = part.morphTargetInfluences[place];
        });
        values.push(jaw);
        await new Promise((resolve) => setTimeout(resolve, 120));
      }
      return values;
    });
    if (name.startsWith('page/')) await tab.locator('canvas').screenshot({ path: `${others[Number(name.slice(5))]}.png` });
    await tab.close();
  }
  console.log(JSON.stringify(seen));
} finally {
  await browser.close();
  server.close();
}
