// SPDX-License-Identifier: Apache-2.0
// NMCLoader under node, where streams are decoded on the calling thread.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { Mesh, MeshBasicMaterial, PerspectiveCamera, Raycaster, Vector3 } from 'three';

import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

import { decode, NmcDecoder } from '../nmc-decoder.mjs';
import { NMCProgressiveMesh } from '../three/nmc-gltf.mjs';
import { lengthOfPixels, NMCLoader, NMCMesh } from '../three/nmc-loader.mjs';
import { refineValues, StreamJob } from '../three/nmc-worker.mjs';

const vectors = join(dirname(fileURLToPath(import.meta.url)), '../../../tests/conformance/vectors');
const bytesOf = (id) => new Uint8Array(readFileSync(join(vectors, id, 'stream.nmc')));
const loader = () => new NMCLoader().setWorkerLimit(0);

async function* slowly(bytes, size = 60) {
  for (let i = 0; i < bytes.length; i += size) {
    await new Promise((resolve) => { setTimeout(resolve, 1); });
    yield bytes.subarray(i, i + size);
  }
}

test('loader: resolves at the first mesh and refines in place to the whole stream', async () => {
  const bytes = bytesOf('layers-3');
  const whole = await decode(bytes, { hashes: true });
  const seen = [];
  const geometry = await loader().open(slowly(bytes));
  assert.equal(geometry.isComplete, false);
  assert.equal(geometry.layer.index, 0);
  geometry.addEventListener('layer', ({ layer }) => seen.push(layer.index));
  await geometry.finished;
  assert.ok(seen.length >= 1);
  assert.deepEqual(geometry.attributes.position.array, whole.positions);
  assert.deepEqual(geometry.index.array, whole.indices);
  assert.equal(geometry.positionHash, whole.positionHash);
  assert.equal(geometry.receivedBytes, bytes.length);
  assert.ok(geometry.boundingBox.containsPoint(new Vector3(...geometry.header.box.min)));
  geometry.dispose();
});

test('loader: parse, rays, and a mesh that is drawn by plain three.js', async () => {
  const geometry = await new Promise((resolve, reject) => loader().parse(bytesOf('base-torus').buffer, resolve, reject));
  await geometry.finished;
  const mesh = new Mesh(geometry, new MeshBasicMaterial({ side: 2 }));
  const at = new Vector3().fromBufferAttribute(geometry.attributes.position, 0);
  const from = at.clone().add(new Vector3(3, 5, 7).multiplyScalar(geometry.boundingSphere.radius));
  assert.ok(new Raycaster(from, at.clone().sub(from).normalize()).intersectObject(mesh).length >= 0);
  assert.equal(geometry.attributes.normal.count, geometry.attributes.position.count);
});

test('loader: goals hold the stream and moving them lets it go on', async () => {
  const bytes = bytesOf('layers-4');
  const geometry = await loader().open(slowly(bytes, 20), { goal: { maxLayer: 1 } });
  await geometry.refineTo({ layer: 1 });
  await new Promise((resolve) => { setTimeout(resolve, 30); });
  assert.equal(geometry.layer.index, 1);
  const last = geometry.layers.length - 1;
  assert.equal((await geometry.refineTo({ layer: last })).index, last);
  await geometry.refineTo({});
  assert.ok(geometry.isComplete);
});

test('loader: a pause and a goal that is met stop the source', async () => {
  const bytes = bytesOf('layers-4');
  let read = 0;
  const source = (async function* () {
    for await (const piece of slowly(bytes, 20)) {
      read += piece.length;
      yield piece;
    }
  })();
  const rest = () => new Promise((resolve) => { setTimeout(resolve, 60); });
  const standsStill = async (what) => {
    await rest();
    const before = read;
    await rest();
    assert.equal(read, before, what);
    assert.ok(read < bytes.length, `${what}: all of it was read`);
  };
  const geometry = await loader().open(source, { goal: { maxLayer: 1 } });
  await geometry.refineTo({ layer: 1 });
  await standsStill('goal');
  geometry.pause();
  const last = geometry.refineTo({});
  await standsStill('pause');
  geometry.resume();
  await last;
  assert.ok(geometry.isComplete);
  assert.equal(read, bytes.length);
});

test('loader: a mesh that came while the page was busy is shown before the next one', async () => {
  const bytes = bytesOf('layers-4');
  const whole = await decode(bytes);
  const job = [];
  let gate;
  const opened = new Promise((resolve) => { gate = resolve; });
  const end = whole.header.streamBytes - 1;
  const source = (async function* () {
    yield bytes.subarray(0, end);
    await opened;
    yield bytes.subarray(end);
  })();
  const stream = new StreamJob((message) => job.push(message), source, { morphTriangles: 0 });
  const meshes = () => job.filter(({ type }) => type === 'mesh').map(({ layer }) => layer.index);
  const wait = (milliseconds) => new Promise((resolve) => { setTimeout(resolve, milliseconds); });
  await wait(100);
  assert.deepEqual(meshes(), [0], 'the page has not asked for another one');
  stream.handle({ type: 'ready' });
  await wait(300);
  assert.deepEqual(meshes(), [0, whole.layer.index - 1]);
  gate();
  stream.handle({ type: 'ready' });
  await wait(200);
  assert.deepEqual(meshes().at(-1), whole.layer.index);
  stream.handle({ type: 'ready' });
  await wait(50);
  assert.equal(job.at(-1).type, 'complete');
});

test('loader: a cut-off stream keeps its mesh and says so; a file of another kind rejects', async () => {
  const bytes = bytesOf('layers-3');
  const geometry = await loader().open(slowly(bytes.subarray(0, -3)));
  await assert.rejects(geometry.finished, { code: 'NMC_ERR_TRUNCATED' });
  assert.ok(geometry.attributes.position.count > 0);
  assert.equal(geometry.error.code, 'NMC_ERR_TRUNCATED');
  await assert.rejects(loader().parseAsync(new TextEncoder().encode('DRACO and more')), { code: 'NMC_ERR_NOT_NMC' });
  await assert.rejects(loader().parseAsync(new ArrayBuffer(0)), { code: 'NMC_ERR_TRUNCATED' });
  const controller = new AbortController();
  const opening = loader().open(slowly(bytes, 4), { signal: controller.signal });
  controller.abort();
  await assert.rejects(opening, { name: 'AbortError' });
});

test('loader: stop rules in triangles and memory', async () => {
  const bytes = bytesOf('tensions');
  const few = await loader().open(bytes, { maxTriangles: 100 });
  await few.finished;
  assert.equal(few.layer.triangles, 96);
  const small = await loader().open(bytes, { maxMemory: 150 * 100 });
  await small.finished;
  assert.equal(small.layer.triangles, 96);
});

test('loader: load() follows the protocol of loaders', async () => {
  const fetch = async () => new Response(bytesOf('tensions'));
  const totals = [];
  const it = loader().setOptions({ fetch }).setPath('http://localhost/');
  const geometry = await it.loadAsync('x.nmc', ({ loaded, total }) => totals.push([loaded, total]));
  await geometry.finished;
  assert.ok(totals.length > 0);
  const missing = loader().setOptions({ fetch: async () => new Response('', { status: 404 }) });
  await assert.rejects(missing.loadAsync('http://localhost/x.nmc'), { code: 'HTTP_404' });
});

test('morph: a finer mesh starts on the coarser one', async () => {
  const bytes = bytesOf('level-5-tetrahedron');
  const decoder = await NmcDecoder.create();
  decoder.feed(bytes);
  while (decoder.next() !== 'end');
  const { level } = decoder.layer;
  const read = (l) => ({ positions: decoder.readPositions(l), indices: decoder.readIndices(l) });
  const coarse = read(level - 1);
  const fine = read(level);
  const start = refineValues(coarse.positions, 3, [{ indices: fine.indices, vertexCount: fine.positions.length / 3 }]);
  assert.deepEqual(start.subarray(0, coarse.positions.length), coarse.positions);
  const area = (positions, indices) => {
    let sum = 0;
    const [a, b, c] = [new Vector3(), new Vector3(), new Vector3()];
    for (let i = 0; i < indices.length; i += 3) {
      a.fromArray(positions, 3 * indices[i]);
      b.fromArray(positions, 3 * indices[i + 1]).sub(a);
      c.fromArray(positions, 3 * indices[i + 2]).sub(a);
      sum += b.cross(c).length() / 2;
    }
    return sum;
  };
  const expected = area(coarse.positions, coarse.indices);
  const found = area(start, fine.indices);
  assert.ok(Math.abs(found - expected) < 1e-4 * expected, `${found} instead of ${expected}`);
});

test('morph: NMCMesh asks for it, and the geometry carries the start', async () => {
  const geometry = await loader().open(slowly(bytesOf('layers-3'), 10));
  new NMCMesh(geometry, new MeshBasicMaterial(), { duration: 5 });
  let hadStart = false;
  geometry.addEventListener('layer', () => { hadStart ||= geometry.attributes.nmcStart !== undefined; });
  await geometry.finished;
  assert.ok(hadStart);
  assert.equal(geometry.attributes.nmcStart?.count ?? geometry.attributes.position.count,
    geometry.attributes.position.count);
});

test('pixels: an error of one pixel is smaller near by', async () => {
  const geometry = await loader().open(bytesOf('base-torus'));
  const length = (distance) => {
    const camera = new PerspectiveCamera(50, 1, 0.001, 1e6);
    camera.position.set(0, 0, geometry.boundingSphere.center.z + distance * geometry.boundingSphere.radius);
    return lengthOfPixels(1, { camera, viewportHeight: 1000, geometry });
  };
  assert.ok(length(2) < length(20));
});

/** A GLB of one triangle whose primitive carries `stream`. */
function glbWith(stream) {
  const json = {
    asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }], extensionsUsed: ['NMC_progressive_mesh'],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, extensions: { NMC_progressive_mesh: { bufferView: 1 } } }] }],
    accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: 'VEC3', min: [0, 0, 0], max: [1, 1, 0] }],
    bufferViews: [{ buffer: 0, byteLength: 36 }, { buffer: 0, byteOffset: 36, byteLength: stream.length }],
    buffers: [{ byteLength: 36 + stream.length }],
  };
  const padded = (bytes, fill) => Buffer.concat([bytes, Buffer.alloc((4 - (bytes.length % 4)) % 4, fill)]);
  const text = padded(Buffer.from(JSON.stringify(json)), ' ');
  const triangle = Buffer.from(new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0]).buffer);
  const binary = padded(Buffer.concat([triangle, stream]), 0);
  const head = (length, type) => {
    const bytes = Buffer.alloc(8);
    bytes.writeUInt32LE(length);
    bytes.write(type, 4, 'latin1');
    return bytes;
  };
  const size = Buffer.alloc(8);
  size.writeUInt32LE(2);
  size.writeUInt32LE(28 + text.length + binary.length, 4);
  return Buffer.concat([Buffer.from('glTF'), size, head(text.length, 'JSON'), text, head(binary.length, 'BIN\0'), binary]);
}

async function readGlb(glb) {
  const seen = { geometries: [], errors: [] };
  const gltf = await new Promise((resolve, reject) => {
    const settings = {
      loader: loader(), onGeometry: (geometry) => seen.geometries.push(geometry), onError: (error) => seen.errors.push(error),
    };
    const bytes = glb.buffer.slice(glb.byteOffset, glb.byteOffset + glb.length);
    new GLTFLoader().register((parser) => new NMCProgressiveMesh(parser, settings)).parse(bytes, '', resolve, reject);
  });
  let mesh = null;
  gltf.scene.traverse((object) => { if (object.isMesh) mesh = object; });
  assert.equal(mesh.geometry.attributes.position.count, 3);
  for (let i = 0; i < 200 && seen.geometries.length + seen.errors.length === 0; ++i) {
    await new Promise((resolve) => { setTimeout(resolve, 10); });
  }
  return { mesh, ...seen };
}

test('glTF: the plain mesh comes first, the stream takes its place; a broken stream leaves it', async () => {
  globalThis.self ??= globalThis;
  const stream = bytesOf('layers-3');
  const good = await readGlb(glbWith(stream));
  assert.equal(good.geometries.length, 1);
  assert.equal(good.mesh.geometry, good.geometries[0]);
  await good.geometries[0].finished;
  assert.equal(good.geometries[0].positionHash, (await decode(stream, { hashes: true })).positionHash);
  const bad = await readGlb(glbWith(Buffer.from('not a stream')));
  assert.equal(bad.errors[0]?.code, 'NMC_ERR_NOT_NMC');
  assert.equal(bad.mesh.geometry.attributes.position.count, 3);
});
