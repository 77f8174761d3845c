// SPDX-License-Identifier: Apache-2.0
import { copyFileSync, mkdirSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join, resolve } from 'node:path';
import { defineConfig } from 'vite';

const require = createRequire(import.meta.url);

/** The Draco decoder is a plain script with its WebAssembly beside it: both go out as they are. */
const draco = {
  outDir: '',
  name: 'draco-files',
  configResolved({ root, build }) { draco.outDir = resolve(root, build.outDir); },
  closeBundle() {
    const from = join(dirname(require.resolve('three')), '../examples/jsm/libs/draco/gltf');
    mkdirSync(join(draco.outDir, 'draco'), { recursive: true });
    for (const file of ['draco_wasm_wrapper.js', 'draco_decoder.wasm']) {
      copyFileSync(join(from, file), join(draco.outDir, 'draco', file));
    }
  },
};

export default defineConfig({
  base: './',
  plugins: [draco],
  resolve: { dedupe: ['three'] },
  worker: { format: 'es' },
  // Nothing inline: the page runs under a Content-Security-Policy without data: and blob:.
  build: { target: 'es2022', assetsInlineLimit: 0, modulePreload: { polyfill: false }, chunkSizeWarningLimit: 1200 },
});
