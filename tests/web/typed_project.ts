// SPDX-License-Identifier: Apache-2.0
// A user of the package's types: compiled by package.test.mjs, never run.
import { decode, NmcError, NmcStream, type NmcMesh } from 'nmc-decoder';
import { NMCProgressiveMesh } from 'nmc-decoder/gltf';
import { NMCLoader, NMCMesh, type NMCGeometry } from 'nmc-decoder/three';
import { MeshStandardMaterial, Scene } from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

const abort = new AbortController();
const mesh: NmcMesh = await decode(new Uint8Array(3), { normals: true, maxError: 1, limits: { maxMemory: 1e6 } });
const units: '' | 'mm' | 'cm' | 'm' | 'in' | 'ft' | 'km' = mesh.header.units;
const counts: number[] = [mesh.indices.length, mesh.colors?.length ?? 0, units.length];

const stream = await NmcStream.open('scan.nmc', { maxError: 0.1, signal: abort.signal });
for await (const layer of stream) counts.push(layer.bytes, layer.mesh().level);
stream.pause();
stream.resume();
stream.dispose();

const loader = new NMCLoader().setWorkerLimit(2).setOptions({ maxMemory: 1e8, goal: { maxError: 1 } });
const geometry: NMCGeometry = await loader.loadAsync('scan.nmc');
loader.load('scan.nmc', (other) => counts.push(other.layer.index), undefined, (error) => console.error(error));
loader.parse(new ArrayBuffer(3), (other) => counts.push(other.receivedBytes), ({ code }) => console.error(code));
geometry.addEventListener('layer', ({ layer }) => counts.push(layer.triangles));
await geometry.refineTo({ layer: 3 });
new Scene().add(new NMCMesh(geometry, new MeshStandardMaterial()));
new GLTFLoader().register((parser) => new NMCProgressiveMesh(parser, {
  loader, onGeometry: (other, { name }) => console.log(name, other.layer.bytes),
}));
try {
  await geometry.finished;
} catch (error) {
  if (error instanceof NmcError) console.error(error.code, error.byteOffset);
}
// @ts-expect-error: a rule of another name is a mistake
await decode(new Uint8Array(3), { maximumError: 1 });
// @ts-expect-error: the geometry's layer is that of the decoder, not just anything
counts.push(geometry.layer.name);
// @ts-expect-error: layers have indices, not names
await geometry.refineTo({ layer: 'last' });
loader.dispose();
