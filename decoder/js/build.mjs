// SPDX-License-Identifier: Apache-2.0
// Puts the WebAssembly into the module: nmc-decoder.src.mjs to nmc-decoder.mjs, which is not kept in the tree.
// Usage: node build.mjs [DIRECTORY OF nmc_decoder.wasm]; without it the module is compiled first.
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { brotliCompressSync } from 'node:zlib';

import { transform } from 'esbuild';

const here = dirname(fileURLToPath(import.meta.url));
let directory = process.argv[2];
if (!directory) {
  directory = mkdtempSync(join(tmpdir(), 'nmc-wasm-'));
  execFileSync(join(here, '../wasm/build_wasm.sh'), [directory], { stdio: 'inherit' });
}
const wasm = readFileSync(join(directory, 'nmc_decoder.wasm'));
if (!process.argv[2]) rmSync(directory, { recursive: true });
const source = readFileSync(join(here, 'nmc-decoder.src.mjs'), 'utf8');
const licence = source.slice(0, source.indexOf('\n') + 1);
const { code } = await transform(source, { minify: true, target: 'es2022', format: 'esm' });
const shipped = licence + code.replace(/['"`]@MODULE_TEXT@['"`]/, () => JSON.stringify(textOfBytes(wasm)));
writeFileSync(join(here, 'nmc-decoder.mjs'), shipped);
const size = (bytes) => `${bytes.length} bytes, ${brotliCompressSync(bytes).length} with brotli`;
console.log(`nmc_decoder.wasm: ${size(wasm)}; nmc-decoder.mjs: ${size(Buffer.from(shipped))}`);

/**
 * Bytes as printable ASCII: each is one of 90 letters, behind '!' or '~' when it is 90 or 180 and more. A server's
 * brotli still sees the bytes and makes 2 % more of them than of the file itself; with hexadecimal digits 8 %, with
 * base64, plain or deflated, 20 %.
 */
function textOfBytes(bytes) {
  const letter = (digit) => String.fromCharCode(digit + (digit < 57 ? 35 : 36));  // past the backslash
  return Array.from(bytes, (byte) => ['', '!', '~'][Math.floor(byte / 90)] + letter(byte % 90)).join('');
}
