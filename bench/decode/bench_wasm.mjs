// SPDX-License-Identifier: Apache-2.0
// The same as nmc-bench-decode for the WebAssembly module, under node: best of several runs, processor time.
// Usage: node bench/decode/bench_wasm.mjs nmc_decoder.wasm STREAM.nmc...
import { readFileSync } from 'node:fs';

const [modulePath, ...streams] = process.argv.slice(2);
const { instance } = await WebAssembly.instantiate(readFileSync(modulePath), {});
const wasm = instance.exports;
const check = (status) => {
  if (status < 0) throw new Error(`status ${status}`);
  return status;
};

for (const path of streams) {
  const bytes = readFileSync(path);
  let best = Infinity;
  let faceCount = 0;
  for (let run = 0; run < 30; ++run) {
    const decoder = wasm.create(0, 0, 0, 0);
    const input = wasm.allocate(bytes.length);
    new Uint8Array(wasm.memory.buffer).set(bytes, input);
    const start = process.cpuUsage();
    check(wasm.feed(decoder, input, bytes.length));
    while (check(wasm.next(decoder)) > 0);
    const info = wasm.allocate(8 * 32);
    check(wasm.info(decoder, info));
    const level = new Float64Array(wasm.memory.buffer, info, 32)[3];
    check(wasm.meshSize(decoder, level, info));
    const [vertexCount, faces] = new Uint32Array(wasm.memory.buffer, info, 2);
    faceCount = faces;
    const positions = wasm.allocate(12 * vertexCount);
    const indices = wasm.allocate(12 * faces);
    check(wasm.readPositions(decoder, level, positions, vertexCount));
    check(wasm.readIndices(decoder, level, indices, 3 * faces));
    const used = process.cpuUsage(start);
    best = Math.min(best, (used.user + used.system) / 1e6);
    for (const pointer of [input, info, positions, indices]) wasm.release(pointer);
    wasm.destroy(decoder);
  }
  const rate = (faceCount / best / 1e6).toFixed(2);
  console.log(`${path}: ${faceCount} triangles in ${(best * 1e3).toFixed(2)} ms: ${rate} million triangles/s`);
}
