// SPDX-License-Identifier: Apache-2.0
// Figures for docs/web.md, as tables in Markdown.
//   node bench/web/bytes_and_speed.mjs --bytes SCAN...     bytes that must arrive until the screen shows an RMS error of
//     1, 0.1 and 0.02 % of the diagonal: nmc by its layers, the others whole files, each the smallest of a sweep of
//     simplification (gltfpack -si, quadrics) and bits per coordinate that reaches the error
//   node bench/web/bytes_and_speed.mjs --speed STREAM       decoding: native, WebAssembly, Draco's WebAssembly, in one run
// Programs by environment: NMC_ENCODE, NMC_DECODE, NMC_COMPARE. Install tests/web, viewer and decoder/js first.
import { mkdirSync, readFileSync, statSync } from 'node:fs';
import { createRequire } from 'node:module';
import { basename, extname, join } from 'node:path';
import { pathToFileURL } from 'node:url';

import { decode, NmcDecoder } from '../../decoder/js/nmc-decoder.mjs';
import { program, root, run, temporaryFolder, writeDracoGlb, writeMeshoptGlb } from '../../tests/web/harness.mjs';
import { readScan, simplifyGlb, writePlainGlb } from '../../tests/web/meshes.mjs';

const folder = temporaryFolder();

const LIMITS = [1, 0.1, 0.02];
const SHARES = (process.env.NMC_SHARES ?? '1 0.3 0.1 0.03 0.01 0.004').split(' ').map(Number);

/** RMS distance to the scan in percent of its diagonal. */
function errorOf(scan, path) {
  return 100 * JSON.parse(run(program('NMC_COMPARE', 'nmc-compare'), [scan, path, '--json'])).relativeRms;
}

async function bytesTable(scans) {
  console.log('| scan | RMS | nmc | Draco GLB | meshopt GLB | plain GLB |\n|---|--:|--:|--:|--:|--:|');
  for (const scan of scans) {
    const name = basename(scan, extname(scan));
    const at = (suffix) => join(folder, `${name}${suffix}`);
    const best = Object.fromEntries(LIMITS.map((limit) => [limit, { nmc: Infinity, draco: Infinity, meshopt: Infinity, plain: Infinity }]));
    const keep = (kind, bytes, error) => {
      for (const limit of LIMITS) if (error <= limit) best[limit][kind] = Math.min(best[limit][kind], bytes);
    };
    run(program('NMC_ENCODE', 'nmc-encode'), [scan, '-o', at('.nmc'), '-f', '--rms-error', '0.02%', '--layers', '3',
      '-e', process.env.NMC_EFFORT ?? '5', '--quiet']);
    const { layers, diagonal } = (await header(at('.nmc')));
    for (const { bytes, rmsError } of layers) keep('nmc', bytes, (100 * rmsError) / diagonal);
    writePlainGlb(at('.glb'), await readScan(scan));
    for (const share of SHARES) {
      // Without quantization and compression first, so that the error is that of the simplification.
      simplifyGlb(at('.glb'), at('.s.glb'), share);
      const error = errorOf(scan, at('.s.glb'));
      keep('plain', statSync(at('.s.glb')).size, error);
      for (const bits of [10, 12, 14]) {
        // A grid of 2^bits cells along the box adds about 0.29 of a cell.
        const sum = Math.hypot(error, 29 / 2 ** bits);
        await writeDracoGlb(at('.s.glb'), at('.d.glb'), bits);
        keep('draco', statSync(at('.d.glb')).size, sum);
        writeMeshoptGlb(at('.s.glb'), at('.m.glb'), { bits });
        keep('meshopt', statSync(at('.m.glb')).size, sum);
      }
    }
    const kilobytes = (bytes) => (bytes === Infinity ? '–' : `${(bytes / 1e3).toPrecision(3)} kB`);
    for (const limit of LIMITS) {
      const { nmc, draco, meshopt, plain } = best[limit];
      console.log(`| ${name} | ${limit} % | ${[nmc, draco, meshopt, plain].map(kilobytes).join(' | ')} |`);
    }
  }
}

async function header(path) {
  const decoder = await NmcDecoder.create();
  decoder.feed(readFileSync(path));
  decoder.next();
  const result = { layers: decoder.layers, diagonal: decoder.header.diagonal };
  decoder.dispose();
  return result;
}

const best = async (times, work) => {
  let least = Infinity;
  for (let i = 0; i < times; ++i) {
    const begin = performance.now();
    await work();
    least = Math.min(least, performance.now() - begin);
  }
  return least;
};

async function speedTable(stream) {
  const bytes = new Uint8Array(readFileSync(stream));
  let mesh = null;
  const wasm = await best(5, async () => { mesh = await decode(bytes); });
  const triangles = mesh.indices.length / 3;
  const said = run(program('NMC_DECODE', 'nmc-decode'), [stream, '--repeat', '5', '--no-output']);
  const draco3d = (await import(pathToFileURL(createRequire(join(root, 'tests/web/package.json')).resolve('draco3d')).href)).default;
  const encoderModule = await draco3d.createEncoderModule();
  const encoder = new encoderModule.Encoder();
  const builder = new encoderModule.MeshBuilder();
  const input = new encoderModule.Mesh();
  builder.AddFacesToMesh(input, triangles, mesh.indices);
  builder.AddFloatAttributeToMesh(input, encoderModule.POSITION, mesh.positions.length / 3, 3, mesh.positions);
  encoder.SetEncodingMethod(encoderModule.MESH_EDGEBREAKER_ENCODING);
  encoder.SetAttributeQuantization(encoderModule.POSITION, 14);
  encoder.SetSpeedOptions(5, 5);
  const output = new encoderModule.DracoInt8Array();
  const size = encoder.EncodeMeshToDracoBuffer(input, output);
  const packed = Int8Array.from({ length: size }, (_, i) => output.GetValue(i));
  const decoderModule = await draco3d.createDecoderModule();
  const draco = await best(5, () => {
    const decoder = new decoderModule.Decoder();
    const result = new decoderModule.Mesh();
    decoder.DecodeArrayToMesh(packed, packed.length, result);
    const at = decoderModule._malloc(triangles * 12);
    decoder.GetTrianglesUInt32Array(result, triangles * 12, at);
    decoderModule._free(at);
    decoderModule.destroy(result);
    decoderModule.destroy(decoder);
  });
  const row = (name, milliseconds, length) =>
    console.log(`| ${name} | ${length} | ${milliseconds.toFixed(0)} | ${(triangles / milliseconds / 1e3).toFixed(1)} |`);
  console.log(`${triangles} triangles\n\n| decoder | bytes | ms | million triangles a second |\n|---|--:|--:|--:|`);
  row('nmc, WebAssembly', wasm, bytes.length);
  row('Draco, WebAssembly, same mesh', draco, size);
  console.log(`nmc-decode: ${said.trim()}`);
}

mkdirSync(folder, { recursive: true });
const [mode, ...files] = process.argv.slice(2);
if (mode === '--bytes' && files.length > 0) await bytesTable(files);
else if (mode === '--speed' && files.length === 1) await speedTable(files[0]);
else {
  console.error('usage: bytes_and_speed.mjs --bytes SCAN... | --speed STREAM');
  process.exit(1);
}
process.exit(0);
