// SPDX-License-Identifier: Apache-2.0
// Puts the WebAssembly into the module: nmc-decoder.src.mjs to nmc-decoder.mjs, which is not kept in the tree.
// Usage: node build.mjs [DIRECTORY OF nmc_decoder.wasm]; without it the module is compiled first.
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { brotliCompressSync } from 'node:zlib';

const here = dirname(fileURLToPath(import.meta.url));
let directory = process.argv[2];
if (!directory) {
  directory = mkdtempSync(join(tmpdir(), 'nmc-wasm-'));
  execFileSync(join(here, '../wasm/build_wasm.sh'), [directory], { stdio: 'inherit' });
}
const wasm = readFileSync(join(directory, 'nmc_decoder.wasm'));
const source = readFileSync(join(here, 'nmc-decoder.src.mjs'), 'utf8');
// Hexadecimal digits: a server's brotli still sees the bytes, and makes 6 % more of them than of the file itself. In
// base64, plain or deflated, it does not, and the package would be 5 kB larger on the wire.
const bundle = source.replace('@MODULE_HEX@', wasm.toString('hex'));
// Comments stay in the source; the types beside the module carry what a user reads.
const [licence, ...lines] = bundle.split('\n');
const shipped = [licence, ...lines.filter((line) => !/^\s*(\/\/|\/\*\*|\*)/.test(line))].join('\n');
writeFileSync(join(here, 'nmc-decoder.mjs'), shipped);
const size = (bytes) => `${bytes.length} bytes, ${brotliCompressSync(bytes).length} with brotli`;
console.log(`nmc_decoder.wasm: ${size(wasm)}; nmc-decoder.mjs: ${size(Buffer.from(shipped))}`);
