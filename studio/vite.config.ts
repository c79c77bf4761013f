// The page: `npm run build` writes it into the Python package. `npm run dev` serves it beside a running `mien studio`,
// whose address stands in MIEN_STUDIO.
import { readFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { defineConfig } from 'vitest/config';

const at = (path: string): string => fileURLToPath(new URL(path, import.meta.url));
const server = process.env['MIEN_STUDIO'] ?? 'http://127.0.0.1:8766';

/** three.js brings decoders of Draco for other files than glTF: they stay out of the package. */
const withoutOtherDecoders = {
  name: 'without-other-decoders',
  generateBundle(_: unknown, bundle: Record<string, { type: string; originalFileNames?: string[] }>): void {
    for (const [name, { originalFileNames = [] }] of Object.entries(bundle)) {
      if (originalFileNames.some((file) => /libs\/draco\/draco_/.test(file))) delete bundle[name];
    }
  },
};

/**
 * The worker that unpacks KTX2, as a file of its own: its library makes functions out of text, which only an answer with a
 * policy of its own may allow (src/mien/serve/studio/routes.py), not a worker that the page makes out of text.
 */
const basisWorker = {
  name: 'basis-worker',
  async generateBundle(this: { emitFile: (file: { type: 'asset'; fileName: string; source: string }) => void }): Promise<void> {
    const { KTX2Loader } = await import('three/examples/jsm/loaders/KTX2Loader.js') as unknown as { KTX2Loader: Record<string, unknown> & { BasisWorker: () => void } };
    const { REVISION } = await import('three');
    const names = ['EngineFormat', 'EngineType', 'TranscoderFormat', 'BasisFormat'];
    const body = KTX2Loader.BasisWorker.toString();
    const source = [
      ...names.map((name) => `let _${name} = ${JSON.stringify(KTX2Loader[name])};`),
      readFileSync(at('./node_modules/three/examples/jsm/libs/basis/basis_transcoder.js'), 'utf8'),
      body.slice(body.indexOf('{') + 1, body.lastIndexOf('}')),
    ].join('\n');
    this.emitFile({ type: 'asset', fileName: `assets/basis_worker-${REVISION}.js`, source });
  },
};

export default defineConfig({
  plugins: [withoutOtherDecoders, basisWorker],
  base: './',
  publicDir: false,
  resolve: {
    alias: [
      { find: 'mien-viewer', replacement: at('../viewer/src/index.ts') },
      { find: /^three$/, replacement: at('./node_modules/three/build/three.module.js') },
      { find: /^three\/addons\//, replacement: at('./node_modules/three/examples/jsm/') },
    ],
  },
  server: { host: '127.0.0.1', proxy: { '/api': { target: server, changeOrigin: true, headers: { origin: server } } } },
  build: {
    outDir: at(process.env['MIEN_PAGE'] ?? '../src/mien/assets/studio'),
    emptyOutDir: true,
    sourcemap: false,
    target: 'es2022',
    chunkSizeWarningLimit: 1200,
    rollupOptions: { output: { postBanner: '/*! Holds three.js: MIT, Copyright (c) 2010-2026 three.js authors; see NOTICE of mien. */' } },
    modulePreload: { polyfill: false },
  },
  test: { include: ['test/**/*.test.ts'] },
});
