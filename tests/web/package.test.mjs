// SPDX-License-Identifier: Apache-2.0
// The package as a user gets it: `npm pack`, installed in an empty folder for node and in an empty Vite project.
import assert from 'node:assert/strict';
import { copyFileSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';

import { here, root, run, startBrowser, startNginx, stopBrowser, temporaryFolder } from './harness.mjs';
import { endWithin, step, until } from './steps.mjs';

const folder = temporaryFolder();
const vector = join(root, 'tests/conformance/vectors/layers-3');
const { layers } = JSON.parse(readFileSync(join(vector, 'expected.json'), 'utf8'));
const expected = layers.at(-1).positionHash;
let tarball;
endWithin(1080);

before(() => {
  const [packed] = JSON.parse(run('npm', ['pack', '--json', '--pack-destination', folder], { cwd: join(root, 'decoder/js') }));
  tarball = join(folder, packed.filename);
  const names = packed.files.map(({ path }) => path);
  for (const name of ['nmc-decoder.mjs', 'nmc-decoder.d.mts', 'three/nmc-loader.mjs', 'three/nmc-loader.d.mts', 'three/nmc-worker.mjs', 'three/nmc-gltf.mjs',
    'three/nmc-gltf.d.mts', 'README.md']) {
    assert.ok(names.includes(name), `${name} is not in the package`);
  }
  assert.ok(!names.some((name) => /test|build|src/.test(name)), names.join());
});
after(() => endWithin(60, 'the end of the suite'));

test('plain node', () => {
  const project = join(folder, 'plain');
  mkdirSync(project);
  writeFileSync(join(project, 'package.json'), '{ "type": "module" }');
  run('npm', ['install', '--no-audit', '--no-fund', '--omit=peer', tarball], { cwd: project });
  writeFileSync(join(project, 'main.js'), `
    import { readFileSync } from 'node:fs';
    import { decode } from 'nmc-decoder';
    const mesh = await decode(readFileSync(process.argv[2]), { hashes: true });
    console.log(mesh.positionHash);`);
  assert.equal(run(process.execPath, ['main.js', join(vector, 'stream.nmc')], { cwd: project }).trim(), expected);
});

test('a strict TypeScript project', () => {
  const project = join(folder, 'typed');
  mkdirSync(project);
  writeFileSync(join(project, 'package.json'), '{ "type": "module" }');
  const versionOf = (name) => JSON.parse(readFileSync(join(here, 'node_modules', name, 'package.json'), 'utf8')).version;
  run('npm', ['install', '--no-audit', '--no-fund', '--prefer-offline', '--omit=peer', tarball,
    `@types/three@${versionOf('@types/three')}`], { cwd: project });
  copyFileSync(join(here, 'typed_project.ts'), join(project, 'main.ts'));
  for (const [modules, resolution] of [['nodenext', 'nodenext'], ['esnext', 'bundler']]) {
    try {
      run(process.execPath, [join(here, 'node_modules/typescript/bin/tsc'), '--noEmit', '--strict', '--skipLibCheck',
        '--target', 'es2022', '--module', modules, '--moduleResolution', resolution, 'main.ts'], { cwd: project, timeout: 300000 });
    } catch (error) {
      assert.fail(`--moduleResolution ${resolution}: ${error.stdout || error.message}`);
    }
  }
});

test('an empty Vite project: the worker follows the bundle, under a strict policy', async (t) => {
  const project = join(folder, 'vite');
  mkdirSync(join(project, 'public'), { recursive: true });
  const { version } = JSON.parse(readFileSync(join(root, 'viewer/node_modules/three/package.json'), 'utf8'));
  writeFileSync(join(project, 'package.json'), '{ "type": "module" }');
  run('npm', ['install', '--no-audit', '--no-fund', '--prefer-offline', tarball, `three@${version}`], { cwd: project });
  copyFileSync(join(vector, 'stream.nmc'), join(project, 'public/stream.nmc'));
  writeFileSync(join(project, 'index.html'), '<!doctype html><title>t</title><script type="module" src="/main.js"></script>');
  writeFileSync(join(project, 'main.js'), `
    import { NMCLoader } from 'nmc-decoder/three';
    const loader = new NMCLoader();
    const geometry = await loader.loadAsync('stream.nmc');
    await geometry.finished;
    document.title = geometry.positionHash + ' ' + loader.workerCount;`);
  run(process.execPath, [join(here, 'node_modules/vite/bin/vite.js'), 'build', '--config', join(here, 'empty.config.js')], { cwd: project });
  const nginx = await startNginx(join(project, 'dist'));
  t.after(() => nginx.stop());
  const browser = await startBrowser();
  t.after(() => stopBrowser(browser));
  const page = await step('a page', 120, () => browser.newPage());
  await step('the page of the project', 120, () => page.goto(nginx.url, { timeout: 0 }));
  const title = await until('the hash', 120, async () => {
    const now = await page.title();
    return now.length > 10 ? now : null;
  });
  assert.equal(title, `${expected} 1`);
});
