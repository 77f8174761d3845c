// SPDX-License-Identifier: Apache-2.0
// The package under node: the conformance vectors, streaming, limits and errors.
import assert from 'node:assert/strict';
import { existsSync, readdirSync, readFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { dirname, join } from 'node:path';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { brotliCompressSync } from 'node:zlib';

import { decode, NmcDecoder, NmcError, NmcStream } from '../nmc-decoder.mjs';

const here = dirname(fileURLToPath(import.meta.url));
const vectors = join(here, '../../../tests/conformance/vectors');
const ids = JSON.parse(readFileSync(join(vectors, 'index.json'), 'utf8'));
const bytesOf = (id) => new Uint8Array(readFileSync(join(vectors, id, 'stream.nmc')));

/** Everything there is to see of a stream, fed in pieces. */
async function look(bytes, limits, piece) {
  const decoder = await NmcDecoder.create({ limits });
  const seen = { status: 'NMC_OK', layers: [] };
  try {
    for (let position = 0; ;) {
      const event = decoder.next();
      if (event === 'layer') {
        seen.layers.push({ level: decoder.layer.level, endByte: decoder.layer.bytes,
          stateHash: decoder.stateHash(), positionHash: decoder.positionHash() });
      }
      if (event !== null) continue;
      if (position >= bytes.length) {
        decoder.finish();
        break;
      }
      decoder.feed(bytes.subarray(position, position + piece));
      position += piece;
    }
  } catch (error) {
    assert.ok(error instanceof NmcError, String(error));
    Object.assign(seen, { status: error.code, errorOffset: error.byteOffset, errorSection: error.specSection });
  }
  decoder.dispose();
  return seen;
}

test('every conformance vector: hashes and errors equal to those of the library', async () => {
  assert.ok(ids.length >= 60);
  for (const id of ids) {
    const expected = JSON.parse(readFileSync(join(vectors, id, 'expected.json'), 'utf8'));
    const { status, errorOffset, errorSection } = expected;
    // Hashes of attributes are compared by tests/conformance; this package has none to show.
    const layers = expected.layers.map(({ attributeHashes, ...layer }) => layer);
    const wanted = status === 'NMC_OK' ? { status, layers } : { status, layers, errorOffset, errorSection };
    for (const piece of [1 << 20, 7]) assert.deepEqual(await look(bytesOf(id), expected.limits, piece), wanted, id);
  }
});

test('decode: indices in range, positions finite, normals of length one', async () => {
  const mesh = await decode(bytesOf('layers-3'), { normals: true, hashes: true });
  assert.equal(mesh.positions.length, mesh.normals.length);
  assert.equal(mesh.indices.length, 3 * mesh.layer.triangles);
  assert.ok(mesh.indices.every((i) => i < mesh.positions.length / 3));
  assert.ok(mesh.positions.every(Number.isFinite));
  for (let v = 0; v < mesh.normals.length; v += 3) {
    assert.ok(Math.abs(Math.hypot(...mesh.normals.subarray(v, v + 3)) - 1) < 1e-5);
  }
  assert.match(mesh.stateHash, /^[0-9a-f]{16}$/);
});

test('decode: stop rules choose a layer', async () => {
  const bytes = bytesOf('tensions');
  assert.equal((await decode(bytes, { maxLevel: 1 })).level, 1);
  assert.equal((await decode(bytes, { maxTriangles: 100 })).layer.triangles, 96);
  assert.equal((await decode(bytes, { maxBytes: 10 })).level, 0);
});

test('decode: a cut-off stream rejects, or gives what there is', async () => {
  const bytes = bytesOf('tensions').subarray(0, -1);
  await assert.rejects(decode(bytes), { name: 'NmcError', code: 'NMC_ERR_TRUNCATED', byteOffset: bytes.length });
  const mesh = await decode(bytes, { allowPartial: true });
  assert.equal(mesh.error.code, 'NMC_ERR_TRUNCATED');
  assert.equal(mesh.level, 2);
});

test('decode: limits and wrong bytes', async () => {
  const decoder = await NmcDecoder.create();
  decoder.feed(bytesOf('valence-40'));
  while (decoder.next() !== 'end');
  decoder.readPositions();
  const limits = { maxMemory: decoder.peakMemory - 1 };
  decoder.dispose();
  await assert.rejects(decode(bytesOf('valence-40'), { limits }), { code: 'NMC_ERR_LIMIT' });
  await assert.rejects(decode(bytesOf('tensions'), { limits: { maxMemory: 10 } }), { code: 'NMC_ERR_LIMIT' });
  await assert.rejects(decode(new TextEncoder().encode('ply\nformat ascii 1.0')), { code: 'NMC_ERR_NOT_NMC' });
  await assert.rejects(decode(new ArrayBuffer(0)), { code: 'NMC_ERR_TRUNCATED' });
});

test('stream: layers come from coarse to fine, and the last equals the whole', async () => {
  const bytes = bytesOf('layers-3');
  async function* pieces() {
    for (let i = 0; i < bytes.length; i += 50) yield bytes.subarray(i, i + 50);
  }
  const stream = await NmcStream.open(pieces());
  assert.equal(stream.layer.index, 0);
  const seen = [];
  let events = 0;
  stream.addEventListener('layer', () => { ++events; });
  let last;
  for await (const layer of stream) {
    seen.push(layer.index);
    last = layer.mesh();
  }
  assert.deepEqual(seen, stream.layers.map((row) => row.index));
  assert.equal(events, seen.length);
  assert.deepEqual(last.positions, (await decode(bytes)).positions);
  stream.dispose();
  assert.throws(() => stream.mesh(), { code: 'NMC_ERR_STATE' });
});

test('stream: a stop rule ends the source, an abort rejects, a failing HTTP answer is told', async () => {
  const bytes = bytesOf('tensions');
  let cancelled = false;
  const source = new ReadableStream({
    pull(controller) { controller.enqueue(bytes.slice(0, 400)); },
    cancel() { cancelled = true; },
  });
  const stream = await NmcStream.open(source, { maxLevel: 0 });
  assert.equal((await stream.run()).level, 0);
  assert.ok(cancelled);

  const controller = new AbortController();
  const slow = await NmcStream.open([bytes.subarray(0, 200), bytes.subarray(200)], { signal: controller.signal });
  controller.abort();
  await assert.rejects(slow.run(), { name: 'AbortError' });

  const fetch = async () => new Response('', { status: 404 });
  await assert.rejects(NmcStream.open('http://localhost/x.nmc', { fetch }), { code: 'HTTP_404' });
});

test('package: no eval, no blobs, no files beside it', () => {
  const text = readFileSync(join(here, '../nmc-decoder.mjs'), 'utf8');
  assert.doesNotMatch(text, /\beval\(|new Function|createObjectURL|import\.meta/);
  assert.ok(existsSync(join(here, '../nmc-decoder.d.mts')));
  assert.ok(readdirSync(join(here, '..')).includes('package.json'));
});

/** A server of one file, as a function for `fetch`, that breaks the connection after `cut` bytes of each answer. */
function brokenServer(bytes, { cut, ranges = true, tag = () => '"1"' }) {
  const requests = [];
  const fetch = async (url, { headers }) => {
    const range = /bytes=(\d+)-/.exec(headers.get('range') ?? '')?.[1];
    requests.push(range === undefined ? 0 : Number(range));
    const from = ranges && range !== undefined ? Number(range) : 0;
    if (from >= bytes.length) return new Response('', { status: 416 });
    let position = from;
    const body = new ReadableStream({
      pull(controller) {
        if (position >= bytes.length) return controller.close();
        const end = Math.min(bytes.length, position + 40);
        if (end - from > cut * requests.length) return controller.error(new TypeError('connection reset'));
        controller.enqueue(bytes.slice(position, end));
        position = end;
      },
    });
    return new Response(body, { status: from > 0 ? 206 : 200, headers: { etag: tag(requests.length) } });
  };
  return { fetch, requests };
}

const sleep = (milliseconds) => new Promise((resolve) => { setTimeout(resolve, milliseconds); });
async function until(condition, what) {
  for (let i = 0; i < 500; ++i, await sleep(10)) if (condition()) return;
  assert.fail(`waited in vain for ${what}`);
}

/** A real server on the loopback that sends 40 bytes every few milliseconds. */
async function slowServer(bytes, ranges) {
  const requests = [];
  const server = createServer(async ({ headers }, response) => {
    const from = Number(/bytes=(\d+)-/.exec(headers.range ?? '')?.[1] ?? 0);
    const request = { from, isClosed: false };
    requests.push(request);
    response.on('close', () => { request.isClosed = true; });
    response.writeHead(from > 0 ? 206 : 200, { etag: '"1"', ...(ranges ? { 'accept-ranges': 'bytes' } : {}) });
    for (let at = from; at < bytes.length && !request.isClosed; at += 40) {
      response.write(bytes.subarray(at, at + 40));
      await sleep(3);
    }
    response.end();
  });
  await new Promise((resolve) => { server.listen(0, '127.0.0.1', resolve); });
  return { url: `http://127.0.0.1:${server.address().port}/x.nmc`, requests, server };
}

test('stream: a broken connection is taken up again where it broke', async () => {
  const bytes = bytesOf('tensions');
  const whole = await decode(bytes, { hashes: true });
  for (const ranges of [true, false]) {
    const { fetch, requests } = brokenServer(bytes, { cut: 200, ranges });
    const retried = [];
    const stream = await NmcStream.open('http://localhost/x.nmc',
      { fetch, retryDelay: 1, onRetry: (received) => retried.push(received) });
    await stream.run();
    assert.equal(stream.positionHash(), whole.positionHash);
    assert.equal(stream.receivedBytes, bytes.length);
    assert.ok(requests.length > 1, `${requests}`);
    assert.deepEqual(requests.slice(1), retried);
    stream.dispose();
  }
});

test('stream: a file that was replaced, a server that stays away, a file that is too short', async () => {
  const bytes = bytesOf('tensions');
  const read = async (source) => (await NmcStream.open('http://localhost/x.nmc', { ...source, retryDelay: 1 })).run();
  const replaced = brokenServer(bytes, { cut: 200, tag: (request) => `"${request}"` });
  await assert.rejects(read(replaced), { code: 'SOURCE_CHANGED' });
  const away = brokenServer(bytes, { cut: 0 });
  await assert.rejects(read({ ...away, retries: 2 }), { code: 'NETWORK' });
  const short = brokenServer(bytes.subarray(0, -1), { cut: 1e9 });
  await assert.rejects(read(short), { code: 'NMC_ERR_TRUNCATED', byteOffset: bytes.length - 1 });
  assert.deepEqual(short.requests, [0, bytes.length - 1]);
});

test('stream: a pause ends the request where Range is known, and the rest is asked for afterwards', async () => {
  const bytes = bytesOf('tensions');
  const whole = await decode(bytes, { hashes: true });
  for (const ranges of [true, false]) {
    const { url, requests, server } = await slowServer(bytes, ranges);
    const retried = [];
    const stream = await NmcStream.open(url, { onRetry: (received) => retried.push(received) });
    const running = stream.run();
    stream.pause();
    if (ranges) await until(() => requests[0].isClosed, 'the end of the request');
    else await sleep(60);
    const { receivedBytes } = stream;
    await sleep(60);
    assert.equal(stream.receivedBytes, receivedBytes, 'bytes were read in the pause');
    assert.ok(receivedBytes < bytes.length);
    assert.equal(requests.length, 1);
    stream.resume();
    await running;
    assert.equal(stream.positionHash(), whole.positionHash);
    assert.equal(stream.receivedBytes, bytes.length);
    assert.deepEqual(requests.map(({ from }) => from), ranges ? [0, receivedBytes] : [0]);
    assert.deepEqual(retried, [], 'a pause is no broken connection');
    stream.dispose();
    server.close();
  }
});

test('stream: dispose ends a request that is waiting', async () => {
  const bytes = bytesOf('tensions');
  let cancelled = false;
  const body = new ReadableStream({
    start(controller) { controller.enqueue(bytes.slice(0, -10)); },
    cancel() { cancelled = true; },
  });
  const stream = await NmcStream.open(body);
  const running = stream.run();
  setTimeout(() => stream.dispose(), 20);
  await assert.rejects(running, { code: 'NMC_ERR_STATE' });
  assert.ok(cancelled);
});

test('offsets: none in the base mesh, as many as vertices, and they follow the level', async () => {
  const decoder = await NmcDecoder.create();
  decoder.feed(bytesOf('tangential-dense'));
  while (decoder.next() !== 'end');
  const base = decoder.meshSize(0).vertexCount;
  const { normal, isOffNormal } = decoder.readOffsets();
  assert.equal(normal.length, decoder.meshSize().vertexCount);
  assert.ok(normal.subarray(0, base).every((length) => length === 0));
  assert.ok(normal.some((length) => length !== 0) && isOffNormal.some((flag) => flag === 1));
  decoder.dispose();
});

test('regions: rows are left out one by one, and what came stays as it is in the whole', async () => {
  const bytes = bytesOf('regions-closed');
  const look = async (wants) => {
    const decoder = await NmcDecoder.create();
    let at = 0;
    while (decoder.next() === null) decoder.feed(bytes.subarray(at, ++at));
    assert.equal(at, decoder.header.headerBytes);
    for (const row of decoder.layers) {
      if (wants(row)) {
        decoder.feed(bytes.subarray(at, row.bytes));
        assert.equal(decoder.next(), 'layer');
      } else {
        decoder.skipLayer();
      }
      at = row.bytes;
    }
    assert.equal(decoder.next(), 'end');
    const seen = { regions: decoder.readRegions(), offsets: decoder.readOffsets(decoder.header.levelCount).normal };
    decoder.dispose();
    return { ...seen, header: decoder.header };
  };
  const whole = await look(() => true), part = await look((row) => !(row.region > 0));
  assert.ok(whole.header.regionCount > 1);
  assert.equal(new Set(whole.regions).size, whole.header.regionCount);
  assert.ok(part.offsets.every((offset, v) => offset === whole.offsets[v] || offset === 0));
  assert.ok(part.offsets.some((offset, v) => offset !== whole.offsets[v]));
  const decoder = await NmcDecoder.create();
  assert.throws(() => decoder.skipLayer(), (error) => error.code === 'NMC_ERR_STATE');
  decoder.dispose();
});

test('errors: their sentence tells what the section of the format is about', async () => {
  await assert.rejects(decode(bytesOf('checksum-base')), (error) => error.specSection === '3.2' && /damaged/.test(error.message));
});

test('package: at most 40 kB with brotli', () => {
  const size = brotliCompressSync(readFileSync(join(here, '../nmc-decoder.mjs'))).length;
  assert.ok(size <= 40000, `${size} bytes`);
});
