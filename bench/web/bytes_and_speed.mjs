// SPDX-License-Identifier: Apache-2.0
// Figures for docs/web.md, as tables in Markdown.
//   node bench/web/bytes_and_speed.mjs --bytes SCAN...    bytes that must arrive until the screen shows an RMS error of 1,
//     0.1 and 0.02 % of the diagonal. nmc: prefixes of one stream, by its layers. The others show nothing before their
//     end, so each gets a file of its own for each error, the smallest over simplification (gltfpack -si, quadrics, in
//     steps of a sixth) and bits per coordinate that reaches it when it is decoded and measured; meshopt and plain GLB
//     with brotli on the way.
//   node bench/web/bytes_and_speed.mjs --speed STREAM [DRACO_GLB] ...    processor time of decoding in one run of chromium:
//     nmc and Draco by WebAssembly, of the stream's own mesh and of a file of equal error; and native code
// Programs by environment: NMC_ENCODE, NMC_DECODE, NMC_COMPARE, CHROMIUM. NMC_BENCH_FOLDER keeps the files, and a stream
// that is there is used again; NMC_ENCODE_OPTIONS. Install tests/web, viewer and decoder/js first.
import assert from 'node:assert/strict';
import { existsSync, mkdirSync, readFileSync, renameSync, statSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { basename, extname, join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { brotliCompressSync } from 'node:zlib';

import { decode, NmcDecoder } from '../../decoder/js/nmc-decoder.mjs';
import { program, root, run, startBrowser, temporaryFolder, writeDracoGlb, writeMeshoptGlb } from '../../tests/web/harness.mjs';
import { readPlain, readScan, simplifyGlb, writePlainGlb } from '../../tests/web/meshes.mjs';

const folder = process.env.NMC_BENCH_FOLDER ?? temporaryFolder();
mkdirSync(folder, { recursive: true });
const requireFromTests = createRequire(join(root, 'tests/web/package.json'));

const LIMITS = [1, 0.1, 0.02];
const BITS = [8, 9, 10, 11, 12, 13, 14];
const shareOf = (step) => (5 / 6) ** step;
const MOST_STEPS = 47;

/** RMS distance to the scan in percent of its diagonal. */
function errorOf(scan, path) {
  return 100 * JSON.parse(run(program('NMC_COMPARE', 'nmc-compare'), [scan, path, '--json'])).relativeRms;
}

/** The smallest files of each kind for an error; bytes are those that cross the network. */
class Peers {
  #scan;
  #at;
  #errors = [];
  #gridShare;

  constructor(scan, name, { positions, indices }) {
    this.#scan = scan;
    this.#at = (suffix) => join(folder, `${name}${suffix}`);
    writePlainGlb(this.#at('.glb'), { positions, indices });
    const [min, max] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
    positions.forEach((x, i) => {
      min[i % 3] = Math.min(min[i % 3], x);
      max[i % 3] = Math.max(max[i % 3], x);
    });
    const sides = min.map((low, k) => max[k] - low);
    this.#gridShare = Math.max(...sides) / Math.hypot(...sides);
  }
  /** Positions and indices alone, after so many steps of simplification. */
  #simplified(step) {
    const path = this.#at(`.${step}.glb`);
    if (!existsSync(path)) simplifyGlb(this.#at('.glb'), path, shareOf(step));
    return path;
  }
  #errorAfter(step) {
    this.#errors[step] ??= errorOf(this.#scan, this.#simplified(step));
    return this.#errors[step];
  }
  /** The most steps that keep the error, by bisection; -1 when none does. */
  #stepsFor(limit) {
    let [low, high] = [-1, MOST_STEPS + 1];
    while (high - low > 1) {
      const middle = Math.floor((low + high) / 2);
      if (this.#errorAfter(middle) <= limit) low = middle;
      else high = middle;
    }
    return low;
  }

  plain(limit) {
    const steps = this.#stepsFor(limit);
    return steps < 0 ? Infinity : Math.min(statSync(this.#simplified(steps)).size, brotliSize(this.#simplified(steps)));
  }
  /** `write(input, output, bits)` makes the file, which stays as NAME.KIND.LIMIT.glb. */
  async quantized(kind, limit, write, sizeOf) {
    const trial = this.#at('.trial.glb');
    const kept = this.#at(`.${kind}.${limit}.glb`);
    let best = Infinity;
    for (const bits of BITS) {
      // Rounding to a grid moves a surface along its normal by a cell over the root of 12.
      const grid = (100 * this.#gridShare) / 2 ** bits / Math.sqrt(12);
      if (grid >= limit) continue;
      for (let steps = this.#stepsFor(Math.sqrt(limit ** 2 - grid ** 2)); steps >= 0; --steps) {
        await write(this.#simplified(steps), trial, bits);
        const size = sizeOf(trial);
        if (size >= best) break;
        writePlainGlb(this.#at('.decoded.glb'), await readPlain(trial));
        if (errorOf(this.#scan, this.#at('.decoded.glb')) > limit) continue;
        best = size;
        renameSync(trial, kept);
        break;
      }
    }
    return best;
  }
}

const brotliSize = (path) => brotliCompressSync(readFileSync(path)).length;

async function bytesTable(scans) {
  const options = (process.env.NMC_ENCODE_OPTIONS ?? '--rms-error 0.02% --layers 3').split(' ');
  console.log(`nmc-encode ${options.join(' ')}\n`);
  console.log('| scan | RMS | nmc | Draco GLB | meshopt GLB | plain GLB |\n|---|--:|--:|--:|--:|--:|');
  for (const scan of scans) {
    const name = basename(scan, extname(scan));
    const stream = join(folder, `${name}.nmc`);
    if (!existsSync(stream)) run(program('NMC_ENCODE', 'nmc-encode'), [scan, '-o', stream, '--quiet', ...options], { timeout: 0 });
    const { layers, diagonal } = await header(stream);
    const peers = new Peers(scan, name, await readScan(scan));
    const kilobytes = (bytes) => (Number.isFinite(bytes) ? `${(bytes / 1e3).toPrecision(3)} kB` : '–');
    for (const limit of LIMITS) {
      const row = layers.find(({ rmsError }) => rmsError !== undefined && (100 * rmsError) / diagonal <= limit * 1.0005);
      const sizes = [
        row?.bytes ?? Infinity,
        await peers.quantized('draco', limit, writeDracoGlb, (path) => statSync(path).size),
        await peers.quantized('meshopt', limit, (input, output, bits) => writeMeshoptGlb(input, output, { bits }), brotliSize),
        peers.plain(limit),
      ];
      console.log(`| ${name} | ${limit} % | ${sizes.map(kilobytes).join(' | ')} |`);
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

/** A mesh as Draco's own file: 14 bits, edgebreaker, the default speed. */
async function dracoOf({ positions, indices }) {
  const module = await (await import(pathToFileURL(requireFromTests.resolve('draco3d')).href)).default.createEncoderModule();
  const encoder = new module.Encoder();
  const builder = new module.MeshBuilder();
  const mesh = new module.Mesh();
  builder.AddFacesToMesh(mesh, indices.length / 3, indices);
  builder.AddFloatAttributeToMesh(mesh, module.POSITION, positions.length / 3, 3, positions);
  encoder.SetEncodingMethod(module.MESH_EDGEBREAKER_ENCODING);
  encoder.SetAttributeQuantization(module.POSITION, 14);
  encoder.SetSpeedOptions(5, 5);
  const output = new module.DracoInt8Array();
  const size = encoder.EncodeMeshToDracoBuffer(mesh, output);
  return Int8Array.from({ length: size }, (_, i) => output.GetValue(i));
}
/** The Draco file inside a GLB of one mesh. */
function dracoInside(path) {
  const file = readFileSync(path);
  const size = file.readUInt32LE(12);
  const { meshes, bufferViews } = JSON.parse(file.toString('utf8', 20, 20 + size));
  const [primitive] = meshes[0].primitives;
  assert.equal(meshes.length * meshes[0].primitives.length, 1);
  const { byteOffset = 0, byteLength } = bufferViews[primitive.extensions.KHR_draco_mesh_compression.bufferView];
  return file.subarray(28 + size + byteOffset, 28 + size + byteOffset + byteLength);
}

/** A page whose files come from here: `open()` gives it, with both decoders loaded. */
async function openPage(browser, files) {
  const page = await browser.newPage();
  const draco = join(root, 'tests/web/node_modules/draco3d');
  const pages = {
    '/': ['text/html', '<!doctype html><title>bench</title><script src="/draco.js"></script>'],
    '/nmc-decoder.mjs': ['text/javascript', readFileSync(join(root, 'decoder/js/nmc-decoder.mjs'))],
    '/draco.js': ['text/javascript', readFileSync(join(draco, 'draco_decoder_nodejs.js'))],
    '/draco.wasm': ['application/wasm', readFileSync(join(draco, 'draco_decoder.wasm'))],
  };
  for (const [name, bytes] of Object.entries(files)) pages[`/${name}`] = ['application/octet-stream', Buffer.from(bytes)];
  await page.route('**/*', (route) => {
    const [contentType, body] = pages[new URL(route.request().url()).pathname] ?? [];
    return body ? route.fulfill({ contentType, body }) : route.fulfill({ status: 404 });
  });
  await page.goto('http://localhost/');
  return page;
}

/** In the page: sets up work[name](), each of which decodes once; resolves to the triangles of 'equal'. */
async function prepareInPage({ hasEqualError }) {
  const bytesOf = async (name) => new Uint8Array(await (await fetch(name)).arrayBuffer());
  const { decode: decodeNmc } = await import('/nmc-decoder.mjs');
  const stream = await bytesOf('/stream');
  const module = await globalThis.DracoDecoderModule({ wasmBinary: await bytesOf('/draco.wasm') });
  let triangles = 0;
  const dracoWork = (bytes) => () => {
    const decoder = new module.Decoder();
    const mesh = new module.Mesh();
    decoder.DecodeArrayToMesh(new Int8Array(bytes.buffer), bytes.length, mesh);
    triangles = mesh.num_faces();
    // As three.js reads it: indices and positions, copied out.
    const size = 4 * Math.max(3 * triangles, 3 * mesh.num_points());
    const at = module._malloc(size);
    decoder.GetTrianglesUInt32Array(mesh, 12 * triangles, at);
    new Uint32Array(module.HEAPU8.buffer, at, 3 * triangles).slice();
    const attribute = decoder.GetAttribute(mesh, decoder.GetAttributeId(mesh, module.POSITION));
    decoder.GetAttributeDataArrayForAllPoints(mesh, attribute, module.DT_FLOAT32, 12 * mesh.num_points(), at);
    new Float32Array(module.HEAPU8.buffer, at, 3 * mesh.num_points()).slice();
    module._free(at);
    module.destroy(mesh);
    module.destroy(decoder);
  };
  globalThis.work = {
    nmc: () => decodeNmc(stream), withNormals: () => decodeNmc(stream, { normals: true }), draco: dracoWork(await bytesOf('/draco')),
  };
  if (hasEqualError) {
    globalThis.work.equal = dracoWork(await bytesOf('/equal'));
    globalThis.work.equal();
  }
  return triangles;
}

/** Milliseconds of processor time of the page's thread for work[name](), the mean of `times`. */
async function timeInPage(page, session, name, times) {
  const repeat = (count) => page.evaluate(async ([what, most]) => {
    for (let i = 0; i < most; ++i) await globalThis.work[what]();
  }, [name, count]);
  const now = async () => (await session.send('Performance.getMetrics')).metrics.find((each) => each.name === 'ThreadTime').value;
  await repeat(2);
  const begin = await now();
  await repeat(times);
  return (1e3 * (await now() - begin)) / times;
}

/** The same of nmc-decode, which also reads the file and starts: the mean of further decodings. */
function timeNatively(stream, times) {
  const spent = (count) => {
    const said = run('sh', ['-c', '"$0" "$1" --repeat "$2" --no-output --quiet; times', program('NMC_DECODE', 'nmc-decode'), stream,
      String(count)]);
    const seconds = [...said.trim().split('\n').at(-1).matchAll(/(\d+)m([0-9.]+)s/g)].map(([, minutes, rest]) => 60 * minutes + Number(rest));
    return seconds[0] + seconds[1];
  };
  return (1e3 * (spent(times + 1) - spent(1))) / times;
}

async function speedTable(files) {
  // Optimized from the first call on: otherwise it depends on the machine's other work when V8 gets to it.
  const browser = await startBrowser(['--js-flags=--no-liftoff']);
  console.log('| stream | decoder | bytes | triangles | ms | million triangles a second |\n|---|---|--:|--:|--:|--:|');
  for (let i = 0; i < files.length; ++i) {
    const path = files[i];
    const name = basename(path, '.nmc');
    const stream = new Uint8Array(readFileSync(path));
    const mesh = await decode(stream);
    const triangles = mesh.indices.length / 3;
    const same = await dracoOf(mesh);
    const equal = files[i + 1]?.endsWith('.glb') ? dracoInside(files[++i]) : null;
    const times = Math.ceil(3e6 / triangles);
    const page = await openPage(browser, { stream, draco: same, ...(equal ? { equal } : {}) });
    const session = await page.context().newCDPSession(page);
    await session.send('Performance.enable', { timeDomain: 'threadTicks' });
    const equalTriangles = await page.evaluate(prepareInPage, { hasEqualError: Boolean(equal) });
    const row = (decoder, bytes, count, milliseconds) => console.log(`| ${name} | ${decoder} | ${bytes} | ${count} | ` +
      `${milliseconds.toPrecision(3)} | ${(count / milliseconds / 1e3).toPrecision(2)} |`);
    row('nmc, native', stream.length, triangles, timeNatively(path, times));
    for (const [what, text, bytes, count] of [
      ['nmc', 'nmc, WebAssembly', stream.length, triangles],
      ['withNormals', 'nmc, WebAssembly, with normals', stream.length, triangles],
      ['draco', 'Draco, WebAssembly, the same mesh', same.length, triangles],
      ...(equal ? [['equal', 'Draco, WebAssembly, the scan simplified to the same error', equal.length, equalTriangles]] : []),
    ]) {
      row(text, bytes, count, await timeInPage(page, session, what, times));
    }
    await page.close();
  }
  await browser.close();
}

const [mode, ...files] = process.argv.slice(2);
if (mode === '--bytes' && files.length > 0) await bytesTable(files);
else if (mode === '--speed' && files.length > 0) await speedTable(files);
else {
  console.error('usage: bytes_and_speed.mjs --bytes SCAN... | --speed STREAM [DRACO_GLB] ...');
  process.exit(1);
}
process.exit(0);
