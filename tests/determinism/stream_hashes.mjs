// SPDX-License-Identifier: Apache-2.0
// stream_hashes_main.cpp for the decoder as WebAssembly: node stream_hashes.mjs nmc_decoder.wasm FILE...
import { readFileSync } from 'node:fs';

const [wasmPath, ...files] = process.argv.slice(2);
const STATUS = {
  0: 'NMC_OK', '-10': 'NMC_ERR_NOT_NMC', '-12': 'NMC_ERR_VERSION', '-14': 'NMC_ERR_FEATURE', '-20': 'NMC_ERR_CORRUPT',
  '-22': 'NMC_ERR_CHECKSUM', '-24': 'NMC_ERR_TRUNCATED', '-30': 'NMC_ERR_LIMIT', '-32': 'NMC_ERR_NO_MEMORY',
};
const module = new WebAssembly.Module(readFileSync(wasmPath));
const lines = [];

for (const file of files) {
  const wasm = new WebAssembly.Instance(module, {}).exports;
  const bytes = readFileSync(file), name = file.split('/').slice(-2).join('/');
  const decoder = wasm.create(0, 0, 0, 0), out = wasm.allocate(64), buffer = wasm.allocate(1 << 16);
  const hash = (call) => {
    if (call(out) !== 0) return '0'.repeat(16);
    const [low, high] = new Uint32Array(wasm.memory.buffer, out, 2);
    return ((BigInt(high) << 32n) | BigInt(low)).toString(16).padStart(16, '0');
  };
  // FNV-1a over the bits of the floats, as in C++, in two halves of 32 bits.
  const hashOfFloats = (count, read) => {
    let high = 0xcbf29ce4, low = 0x84222325;
    const address = wasm.allocate(4 * count || 4);
    if (count) read(address);
    for (const word of new Uint32Array(wasm.memory.buffer, address, count)) {
      low = (low ^ word) >>> 0;
      // (high, low) * 0x100000001b3
      const product = BigInt(low) * 0x1b3n;
      const carry = Number(product >> 32n);
      high = (Math.imul(high, 0x1b3) + carry + (low << 8)) >>> 0;
      low = Number(product & 0xffffffffn);
    }
    wasm.release(address);
    return high.toString(16).padStart(8, '0') + low.toString(16).padStart(8, '0');
  };
  let status = 0;
  for (let position = 0, row = 0; ;) {
    status = wasm.next(decoder);
    if (status < 0) break;
    if (status === 2) {
      wasm.layer(decoder, row++, out);
      const [level, end] = new Float64Array(wasm.memory.buffer, out, 2);
      const state = hash((at) => wasm.stateHash(decoder, at));
      const positions = hash((at) => wasm.positionHash(decoder, level, at));
      const count = wasm.meshSize(decoder, level, out) === 0 ? new Uint32Array(wasm.memory.buffer, out, 1)[0] : 0;
      const xyz = hashOfFloats(3 * count, (at) => wasm.readPositions(decoder, level, at, count));
      const normals = hashOfFloats(3 * count, (at) => wasm.readNormals(decoder, level, at, count));
      lines.push(`${name} row ${end} ${level} ${state} ${positions} ${xyz} ${normals}`);
    }
    if (status !== 0) continue;
    if (position >= bytes.length) {
      status = wasm.finish(decoder);
      break;
    }
    const part = bytes.subarray(position, position + (1 << 16));
    new Uint8Array(wasm.memory.buffer, buffer, part.length).set(part);
    position += part.length;
    status = wasm.feed(decoder, buffer, part.length);
    if (status < 0) break;
  }
  wasm.error(decoder, out);
  const [offset, , section] = new Float64Array(wasm.memory.buffer, out, 3);
  const text = new Uint8Array(wasm.memory.buffer, section);
  lines.push(`${name} ${STATUS[status] ?? status} ${offset} ${new TextDecoder().decode(text.slice(0, text.indexOf(0)))}`);
}
console.log(lines.join('\n'));
