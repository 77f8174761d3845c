// SPDX-License-Identifier: Apache-2.0
// The package as a user gets it: `npm pack`, installed in an empty folder for node and in an empty Vite project.
import assert from 'node:assert/strict';
import { copyFileSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';

import Ajv from 'ajv/dist/2020.js';

import { here, program, root, run, startBrowser, startNginx, stopBrowser, temporaryFolder } from './harness.mjs';
import { endWithin, step, until } from './steps.mjs';

const folder = temporaryFolder();
const vector = join(root, 'tests/conformance/vectors/layers-3');
const { layers } = JSON.parse(readFileSync(join(vector, 'expected.json'), 'utf8'));
const expected = layers.at(-1).positionHash;
const project = join(folder, 'web');  // with three.js
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
  mkdirSync(join(project, 'public'), { recursive: true });
  const { version } = JSON.parse(readFileSync(join(root, 'viewer/node_modules/three/package.json'), 'utf8'));
  writeFileSync(join(project, 'package.json'), '{ "type": "module" }');
  run('npm', ['install', '--no-audit', '--no-fund', '--prefer-offline', tarball, `three@${version}`], { cwd: project });
});
after(() => endWithin(60, 'the end of the suite'));

test('plain node', () => {
  const plain = join(folder, 'plain');
  mkdirSync(plain);
  writeFileSync(join(plain, 'package.json'), '{ "type": "module" }');
  run('npm', ['install', '--no-audit', '--no-fund', '--omit=peer', tarball], { cwd: plain });
  writeFileSync(join(plain, 'main.js'), `
    import { readFileSync } from 'node:fs';
    import { decode } from 'nmc-decoder';
    const mesh = await decode(readFileSync(process.argv[2]), { hashes: true });
    console.log(mesh.positionHash);`);
  assert.equal(run(process.execPath, ['main.js', join(vector, 'stream.nmc')], { cwd: plain }).trim(), expected);
});

test('a strict TypeScript project', () => {
  const typed = join(folder, 'typed');
  mkdirSync(typed);
  writeFileSync(join(typed, 'package.json'), '{ "type": "module" }');
  const versionOf = (name) => JSON.parse(readFileSync(join(here, 'node_modules', name, 'package.json'), 'utf8')).version;
  run('npm', ['install', '--no-audit', '--no-fund', '--prefer-offline', '--omit=peer', tarball,
    `@types/three@${versionOf('@types/three')}`], { cwd: typed });
  copyFileSync(join(here, 'typed_project.ts'), join(typed, 'main.ts'));
  for (const [modules, resolution] of [['nodenext', 'nodenext'], ['esnext', 'bundler']]) {
    try {
      run(process.execPath, [join(here, 'node_modules/typescript/bin/tsc'), '--noEmit', '--strict', '--skipLibCheck',
        '--target', 'es2022', '--module', modules, '--moduleResolution', resolution, 'main.ts'], { cwd: typed });
    } catch (error) {
      assert.fail(`--moduleResolution ${resolution}: ${error.stdout || error.message}`);
    }
  }
});

test('a GLB of nmc-encode keeps its schema; the plugin shows the plain mesh, then the stream', { skip: !process.env.NMC_ENCODE }, () => {
  const side = 64;
  const vertices = Array.from({ length: side * side }, (_, i) => [i % side, Math.floor(i / side)])
    .map(([x, y]) => [x, y, 6 * Math.sin(x / 9) + 5 * Math.cos(y / 11)]);
  const faces = Array.from({ length: (side - 1) ** 2 }, (_, i) => Math.floor(i / (side - 1)) * side + (i % (side - 1)))
    .flatMap((v) => [[v, v + 1, v + side], [v + 1, v + side + 1, v + side]]);
  writeFileSync(join(project, 'waves.off'), ['OFF', `${vertices.length} ${faces.length} 0`,
    ...vertices.map((vertex) => vertex.join(' ')), ...faces.map((face) => `3 ${face.join(' ')}`)].join('\n'));
  run(program('NMC_ENCODE', 'nmc-encode'), ['waves.off', '-o', 'waves.nmc', '--glb', 'waves.glb', '--rms-error', '0.01%', '--effort', '1'],
    { cwd: project });
  const glb = readFileSync(join(project, 'waves.glb'));
  const gltf = JSON.parse(glb.toString('utf8', 20, 20 + glb.readUInt32LE(12)));
  const [primitive] = gltf.meshes[0].primitives;
  const said = primitive.extensions.NMC_progressive_mesh;
  const schemas = new Ajv({ strict: false, validateFormats: false });
  schemas.addSchema({ $id: 'glTFProperty.schema.json', type: 'object' });
  schemas.addSchema({ $id: 'glTFid.schema.json', type: 'integer', minimum: 0 });
  const isValid = schemas.compile(JSON.parse(readFileSync(join(root, 'docs/NMC_progressive_mesh/schema.json'), 'utf8')));
  assert.ok(isValid(said), JSON.stringify(isValid.errors));
  writeFileSync(join(project, 'gltf.js'), `
    import { readFileSync } from 'node:fs';
    import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
    import { NMCProgressiveMesh } from 'nmc-decoder/gltf';
    import { NMCLoader } from 'nmc-decoder/three';
    globalThis.self ??= globalThis;
    const bytes = readFileSync('waves.glb');
    const plain = [];
    let onGeometry;
    const whole = new Promise((resolve, reject) => {
      onGeometry = (geometry) => geometry.finished.then(resolve, reject);
      new GLTFLoader().register((parser) => new NMCProgressiveMesh(parser, {
        loader: new NMCLoader().setWorkerLimit(0), onGeometry, onError: reject,
      })).parse(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length), '', ({ scene }) => {
        scene.traverse(({ geometry }) => { if (geometry) plain.push(geometry.index.count / 3); });
      }, reject);
    });
    const { positionHash, index } = await whole;
    console.log(JSON.stringify({ plain, fine: index.count / 3, positionHash }));`);
  const { plain, fine, positionHash } = JSON.parse(run(process.execPath, ['gltf.js'], { cwd: project }));
  assert.deepEqual(plain, [gltf.accessors[primitive.indices].count / 3]);
  assert.equal(fine, said.layers.at(-1).triangles);
  assert.ok(fine > plain[0], `${plain[0]} triangles at first, ${fine} at the end`);
  const decoded = run(program('NMC_DECODE', 'nmc-decode'), ['waves.nmc', '--hash', '--no-output'], { cwd: project });
  assert.equal(positionHash, /positions ([0-9a-f]{16})/.exec(decoded)[1]);
});

test('an empty Vite project: the worker follows the bundle, under a strict policy', async (t) => {
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
