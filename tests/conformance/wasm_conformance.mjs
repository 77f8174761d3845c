// SPDX-License-Identifier: Apache-2.0
// The table of vectors through the decoder as WebAssembly: hashes and errors as expected, in one piece and byte by
// byte, and the rows that every prefix promises. A vector that is missing fails.
// Usage: node wasm_conformance.mjs nmc_decoder.wasm VECTORS
import { readFileSync } from 'node:fs';
import { join } from 'node:path';

const [wasmPath, vectors] = process.argv.slice(2);
const STATUS = {
  0: 'NMC_OK', '-10': 'NMC_ERR_NOT_NMC', '-12': 'NMC_ERR_VERSION', '-14': 'NMC_ERR_FEATURE', '-20': 'NMC_ERR_CORRUPT',
  '-22': 'NMC_ERR_CHECKSUM', '-24': 'NMC_ERR_TRUNCATED', '-30': 'NMC_ERR_LIMIT', '-32': 'NMC_ERR_NO_MEMORY',
};
const wasm = (await WebAssembly.instantiate(readFileSync(wasmPath), {})).instance.exports;
const buffer = wasm.allocate(1 << 20), out = wasm.allocate(64);

function textAt(address) {
  const bytes = new Uint8Array(wasm.memory.buffer, address);
  return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
}
function hash(call) {
  if (call(out) !== 0) return '0'.repeat(16);
  const [low, high] = new Uint32Array(wasm.memory.buffer, out, 2);
  return ((BigInt(high) << 32n) | BigInt(low)).toString(16).padStart(16, '0');
}

function decode(bytes, limits, piece) {
  const decoder = wasm.create(limits.maxMemory ?? 0, limits.maxVertices ?? 0, limits.maxBaseVertices ?? 0,
    limits.maxLevels ?? 0);
  const seen = { layers: [] };
  let status = 0;
  for (let position = 0, row = 0; ;) {
    status = wasm.next(decoder);
    if (status < 0) break;
    if (status === 2) {
      wasm.layer(decoder, row++, out);
      const [level, endByte] = new Float64Array(wasm.memory.buffer, out, 2);
      seen.layers.push({ level, endByte, stateHash: hash((at) => wasm.stateHash(decoder, at)),
        positionHash: hash((at) => wasm.positionHash(decoder, level, at)) });
    }
    if (status !== 0) continue;
    if (position >= bytes.length) {
      status = wasm.finish(decoder);
      break;
    }
    const part = bytes.subarray(position, position + piece);
    new Uint8Array(wasm.memory.buffer, buffer, part.length).set(part);
    position += part.length;
    status = wasm.feed(decoder, buffer, part.length);
    if (status < 0) break;
  }
  seen.status = STATUS[status] ?? String(status);
  if (status < 0) {
    wasm.error(decoder, out);
    const [offset, , section] = new Float64Array(wasm.memory.buffer, out, 3);
    seen.errorOffset = offset;
    seen.errorSection = textAt(section);
  }
  wasm.destroy(decoder);
  return seen;
}

let failures = 0, prefixes = 0;
function compare(what, seen, expected) {
  const a = JSON.stringify(seen), b = JSON.stringify(expected);
  if (a === b) return;
  if (++failures <= 20) console.error(`${what}\n  expected ${b}\n  found    ${a}`);
}
const ordered = (e, layers) => ({
  layers: layers.map(({ level, endByte, stateHash, positionHash }) => ({ level, endByte, stateHash, positionHash })),
  status: e.status,
  ...(e.status === 'NMC_OK' ? {} : { errorOffset: e.errorOffset, errorSection: e.errorSection }),
});

const ids = JSON.parse(readFileSync(join(vectors, 'index.json'), 'utf8'));
if (ids.length < 60) throw new Error(`only ${ids.length} vectors`);
for (const id of ids) {
  const expected = JSON.parse(readFileSync(join(vectors, id, 'expected.json'), 'utf8'));
  const bytes = new Uint8Array(readFileSync(join(vectors, id, 'stream.nmc')));
  for (const piece of [1 << 20, 1]) {
    compare(`${id} in pieces of ${piece}`, decode(bytes, expected.limits ?? {}, piece), ordered(expected, expected.layers));
  }
  if (expected.status !== 'NMC_OK' || bytes.length > 1200) continue;
  for (let size = 0; size < bytes.length; ++size, ++prefixes) {
    const cut = { status: 'NMC_ERR_TRUNCATED', errorOffset: size, errorSection: '3.2' };
    compare(`${id}, the first ${size} bytes`, decode(bytes.subarray(0, size), {}, 1 << 20),
      ordered(cut, expected.layers.filter((layer) => layer.endByte <= size)));
  }
}
console.log(`${ids.length} vectors, ${prefixes} prefixes, ${failures} failures`);
process.exit(failures ? 1 : 0);
