// SPDX-License-Identifier: Apache-2.0
// Scans as GLB files, for the comparisons of the tests and benchmarks.
import { copyFileSync, readFileSync, statSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { extname, join } from 'node:path';
import { pathToFileURL } from 'node:url';

import { here, root, run, writeDracoGlb } from './harness.mjs';

const require = createRequire(join(root, 'viewer/package.json'));
const fromViewer = (name) => import(pathToFileURL(require.resolve(name)).href);

/** Positions and triangles of a PLY or OBJ file. */
export async function readScan(path) {
  const bytes = readFileSync(path);
  if (extname(path) === '.ply') {
    const { PLYLoader } = await fromViewer('three/addons/loaders/PLYLoader.js');
    const geometry = new PLYLoader().parse(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
    return { positions: geometry.attributes.position.array, indices: Uint32Array.from(geometry.index.array) };
  }
  const positions = [];
  const indices = [];
  for (const line of bytes.toString('latin1').split('\n')) {
    const words = line.trim().split(/\s+/);
    if (words[0] === 'v') positions.push(...words.slice(1, 4).map(Number));
    if (words[0] !== 'f') continue;
    const corners = words.slice(1).map((word) => Number.parseInt(word, 10) - 1);
    for (let k = 2; k < corners.length; ++k) indices.push(corners[0], corners[k - 1], corners[k]);
  }
  return { positions: Float32Array.from(positions), indices: Uint32Array.from(indices) };
}

/** A PLY file of the same. */
export function writePly(path, { positions, indices }) {
  const head = Buffer.from(`ply\nformat binary_little_endian 1.0\nelement vertex ${positions.length / 3}\nproperty float x\n` +
    `property float y\nproperty float z\nelement face ${indices.length / 3}\nproperty list uchar int vertex_indices\nend_header\n`);
  const faces = Buffer.alloc((13 * indices.length) / 3);
  for (let face = 0; 3 * face < indices.length; ++face) {
    faces[13 * face] = 3;
    for (let k = 0; k < 3; ++k) faces.writeInt32LE(indices[3 * face + k], 13 * face + 1 + 4 * k);
  }
  writeFileSync(path, Buffer.concat([head, Buffer.from(positions.buffer, positions.byteOffset, positions.byteLength), faces]));
}

/** The smallest GLB there is: positions in single precision and indices. */
export function writePlainGlb(path, { positions, indices }) {
  const min = [Infinity, Infinity, Infinity];
  const max = [-Infinity, -Infinity, -Infinity];
  positions.forEach((x, i) => {
    min[i % 3] = Math.min(min[i % 3], x);
    max[i % 3] = Math.max(max[i % 3], x);
  });
  const json = Buffer.from(JSON.stringify({
    asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1 }] }],
    accessors: [{ bufferView: 0, componentType: 5126, count: positions.length / 3, type: 'VEC3', min, max },
      { bufferView: 1, componentType: 5125, count: indices.length, type: 'SCALAR' }],
    bufferViews: [{ buffer: 0, byteLength: positions.byteLength },
      { buffer: 0, byteOffset: positions.byteLength, byteLength: indices.byteLength }],
    buffers: [{ byteLength: positions.byteLength + indices.byteLength }],
  }));
  const text = Buffer.concat([json, Buffer.alloc((4 - (json.length % 4)) % 4, ' ')]);
  const head = Buffer.alloc(20);
  const size = positions.byteLength + indices.byteLength;
  head.write('glTF');
  head.writeUInt32LE(2, 4);
  head.writeUInt32LE(28 + text.length + size, 8);
  head.writeUInt32LE(text.length, 12);
  head.write('JSON', 16);
  const binaryHead = Buffer.alloc(8);
  binaryHead.writeUInt32LE(size);
  binaryHead.write('BIN\0', 4, 'latin1');
  writeFileSync(path, Buffer.concat([head, text, binaryHead, Buffer.from(positions.buffer, positions.byteOffset, positions.byteLength),
    Buffer.from(indices.buffer)]));
}

/** Positions and triangles of a GLB of one mesh, plain, Draco or meshopt, in the space of the scene. */
export async function readPlain(path) {
  const { NodeIO } = await import('@gltf-transform/core');
  const { ALL_EXTENSIONS } = await import('@gltf-transform/extensions');
  const draco3d = (await import('draco3d')).default;
  const { MeshoptDecoder } = await fromViewer('three/addons/libs/meshopt_decoder.module.js');
  await MeshoptDecoder.ready;
  const io = new NodeIO().registerExtensions(ALL_EXTENSIONS)
    .registerDependencies({ 'draco3d.decoder': await draco3d.createDecoderModule(), 'meshopt.decoder': MeshoptDecoder });
  const document = await io.read(path);
  const [node] = document.getRoot().listNodes().filter((each) => each.getMesh());
  const [primitive] = node.getMesh().listPrimitives();
  const matrix = node.getWorldMatrix();
  const position = primitive.getAttribute('POSITION');
  const positions = new Float32Array(3 * position.getCount());
  for (let v = 0, at = []; v < position.getCount(); ++v) {
    position.getElement(v, at);
    for (let k = 0; k < 3; ++k) {
      positions[3 * v + k] = matrix[k] * at[0] + matrix[4 + k] * at[1] + matrix[8 + k] * at[2] + matrix[12 + k];
    }
  }
  return { positions, indices: Uint32Array.from(primitive.getIndices().getArray()) };
}

/** gltfpack's simplification alone, by quadrics: positions stay in single precision. */
export function simplifyGlb(input, output, share) {
  run(process.execPath, [join(here, 'node_modules/gltfpack/cli.js'), '-i', input, '-o', output, '-noq', '-si', String(share), '-se', '1']);
}

/** A Draco GLB of at most `bytes`, simplified from `triangles` until it fits. Returns its size. */
export async function writeDracoGlbOfSize(input, output, triangles, bytes, bits = 12) {
  // Draco takes from 1.5 to 4 bytes per triangle at such sizes.
  let [low, high] = [4, 1.5].map((each) => Math.log(Math.min(1, bytes / (each * triangles))));
  const trial = `${output}.trial.glb`;
  let best = Infinity;
  for (let i = 0; i < 4; ++i) {
    const middle = i === 0 ? low : (low + high) / 2;
    simplifyGlb(input, trial, Math.exp(middle));
    await writeDracoGlb(trial, trial, bits);
    const { size } = statSync(trial);
    if (size > bytes) {
      high = middle;
      continue;
    }
    low = middle;
    best = size;
    copyFileSync(trial, output);
  }
  return best;
}
