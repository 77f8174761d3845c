// SPDX-License-Identifier: Apache-2.0
// nmc-decoder: decodes .nmc streams in pages, workers and node >= 18. One file, the WebAssembly inside, no eval.
//
//   import { decode, NmcStream } from 'nmc-decoder';
//   const mesh = await decode(bytes);                         // { positions, indices, layer, header, ... }
//   for await (const layer of await NmcStream.open(url)) {    // from coarse to fine, as bytes arrive
//     const { positions, indices } = layer.mesh();
//   }

const MODULE_TEXT = '@MODULE_TEXT@';

/** What the sections of the format that name errors are about: the module itself has no room for sentences. */
const RULES = {
  2.2: 'a number is misspelt', 3.1: 'this is not an nmc stream, or one of another version', 3.2: 'a chunk is damaged, '
    + 'missing, unknown or behind the end', 3.3: 'the header is damaged', '3.3.1': 'a reserved flag is set',
  '3.3.2': 'unknown units or up axis', '3.3.3': 'the grid is out of range', '3.3.4': 'a count or step is out of range',
  '3.3.5': 'a row of the layer table is wrong', 4.3: 'a chunk comes out of order', 4.4: 'the base mesh is no manifold',
  4.6: 'a base vertex lies outside the grid', 4.7: 'a base correction is too short', 5.1: 'a chunk ends too early',
  5.3: 'a chunk of coefficients is wrong', '5.3.4': 'a tangential coefficient names no edge', 5.4: 'a region is wrong',
  8: 'a limit is passed', 8.2: 'so few bytes may not describe so much', 10.1: 'the table of attributes is wrong',
  10.3: 'a chunk of an attribute is wrong',
};
const STATUS = {
  '-10': 'NMC_ERR_NOT_NMC', '-12': 'NMC_ERR_VERSION', '-14': 'NMC_ERR_FEATURE', '-20': 'NMC_ERR_CORRUPT',
  '-22': 'NMC_ERR_CHECKSUM', '-24': 'NMC_ERR_TRUNCATED', '-30': 'NMC_ERR_LIMIT', '-32': 'NMC_ERR_NO_MEMORY',
  '-34': 'NMC_ERR_STOPPED', '-40': 'NMC_ERR_ARGUMENT', '-42': 'NMC_ERR_STATE',
};
const UNITS = ['', 'mm', 'cm', 'm', 'in', 'ft', 'km'];
const UP = ['', 'y', 'z'];
const CRITERIA = { maxError: 1, rmsError: 2, maxTriangles: 3, maxBytes: 4, maxLevel: 5 };
const DEFAULT_LIMITS = { maxMemory: 2 ** 30, maxVertices: 25e6, maxBaseVertices: 2 ** 20, maxLevels: 14 };

/** What went wrong in a stream, and where. `code` is the name of a status of nmc.h. */
export class NmcError extends Error {
  constructor(code, message, detail = {}) {
    super(message || code);
    this.name = 'NmcError';
    this.code = code;
    this.byteOffset = detail.byteOffset ?? 0;
    this.chunkType = detail.chunkType ?? 0;
    this.specSection = detail.specSection ?? '';
  }
}

/** False where there is no WebAssembly; then `ready` rejects. */
export const supported = typeof WebAssembly === 'object' && typeof WebAssembly.instantiate === 'function';

let compiled = null;
/** The compiled module, compiled at the first call. */
export function ready() {
  if (!supported) return Promise.reject(new NmcError('NMC_ERR_FEATURE', 'this environment has no WebAssembly'));
  compiled ??= WebAssembly.compile(bytesOfText(MODULE_TEXT));
  return compiled;
}

/** The inverse of textOfBytes() in build.mjs. */
function bytesOfText(text) {
  const digit = (i) => text.charCodeAt(i) - (text[i] > '\\' ? 36 : 35);
  const bytes = [];
  for (let i = 0; i < text.length; ++i) {
    bytes.push(text[i] === '!' ? 90 + digit(++i) : text[i] === '~' ? 180 + digit(++i) : digit(i));
  }
  return new Uint8Array(bytes);
}

/**
 * One stream in its own WebAssembly instance, so that dispose() gives all its memory back. The synchronous core of
 * this package: feed bytes, ask for events, read meshes.
 */
export class NmcDecoder {
  /** Resolves to a decoder. `limits`: maxMemory in bytes, maxVertices, maxBaseVertices, maxLevels. */
  static async create({ limits = {} } = {}) {
    const instance = await WebAssembly.instantiate(await ready(), {});
    return new NmcDecoder(instance.exports, { ...DEFAULT_LIMITS, ...limits });
  }

  #wasm;
  #decoder;
  #scratch;
  #header = null;
  #layers = [];
  #current = -1;

  /** @private use NmcDecoder.create() */
  constructor(wasm, limits) {
    this.#wasm = wasm;
    this.#decoder = wasm.create(limits.maxMemory, limits.maxVertices, limits.maxBaseVertices, limits.maxLevels);
    this.#scratch = this.#decoder && wasm.allocate(32 * 8);
    if (!this.#scratch) throw new NmcError('NMC_ERR_LIMIT', 'the limits leave no room for a decoder');
  }

  /** Of the stream; null before the 'header' event. */
  get header() { return this.#header; }
  /** The layer table; empty before the 'header' event. */
  get layers() { return this.#layers; }
  /** The row whose state is read; null before the first 'layer' event. */
  get layer() { return this.#layers[this.#current] ?? null; }
  /** The most memory that the decoder has held, in bytes. */
  get peakMemory() { return this.#live().memoryPeak(this.#decoder); }

  /** Appends bytes of the stream; they are copied. */
  feed(bytes) {
    const wasm = this.#live();
    const piece = 1 << 16;
    const address = wasm.allocate(Math.min(piece, bytes.length) || 1);
    if (!address) throw new NmcError('NMC_ERR_NO_MEMORY', 'memory exhausted');
    try {
      for (let start = 0; start < bytes.length; start += piece) {
        const part = bytes.subarray(start, start + piece);
        new Uint8Array(wasm.memory.buffer, address, part.length).set(part);
        this.#check(wasm.feed(this.#decoder, address, part.length));
      }
    } finally {
      wasm.release(address);
    }
  }

  /**
   * Leaves out the next row of the table, one of a region: its bytes are not fed, and bytes have been fed up to its
   * beginning only. No event follows.
   */
  skipLayer() {
    this.#check(this.#live().skipLayer(this.#decoder));
    ++this.#current;
  }

  /** Per face of the base mesh its region, as Uint8Array; face f of level l lies in that of f >> (2 l). */
  readRegions() {
    const count = this.#header?.base.triangleCount ?? 0;
    return this.#read(Uint8Array, count, (address) => this.#wasm.readRegions(this.#decoder, address, count));
  }

  /** 'header', 'layer', 'end', or null when more input is needed. Throws NmcError. */
  next() {
    const event = this.#live().next(this.#decoder);
    if (event < 0) this.#check(event);
    if (event === 1) this.#readHeader();
    if (event === 2) ++this.#current;
    return event === 0 ? null : ['header', 'layer', 'end'][event - 1];
  }

  /** Tells that no more bytes will come. Throws NmcError NMC_ERR_TRUNCATED when layers are missing. */
  finish() { this.#check(this.#live().finish(this.#decoder)); }

  /** Starts anew with the same limits. */
  reset() {
    this.#check(this.#live().reset(this.#decoder));
    this.#header = null;
    this.#layers = [];
    this.#current = -1;
  }

  /** { index, isMet } of the row for one of maxError, rmsError, maxTriangles, maxBytes, maxLevel. */
  selectLayer(criterion, value) {
    const wasm = this.#live();
    this.#check(wasm.selectLayer(this.#decoder, CRITERIA[criterion] ?? 0, value, this.#scratch));
    const words = new Uint32Array(wasm.memory.buffer, this.#scratch, 2);
    return { index: words[0], isMet: words[1] !== 0 };
  }

  /** { vertexCount, triangleCount } of a level; default: that of the current layer. */
  meshSize(level = this.layer?.level ?? 0) {
    const wasm = this.#live();
    this.#check(wasm.meshSize(this.#decoder, level, this.#scratch));
    const words = new Uint32Array(wasm.memory.buffer, this.#scratch, 2);
    return { vertexCount: words[0], triangleCount: words[1] };
  }

  /** Three indices per triangle. They depend on the level alone: read them once per level. */
  readIndices(level = this.layer?.level ?? 0) {
    const count = 3 * this.meshSize(level).triangleCount;
    return this.#read(Uint32Array, count, (at) => this.#wasm.readIndices(this.#decoder, level, at, count));
  }
  /** x, y, z of each vertex in single precision, in the state of the current layer. */
  readPositions(level = this.layer?.level ?? 0) {
    const { vertexCount } = this.meshSize(level);
    return this.#read(Float32Array, 3 * vertexCount,
      (at) => this.#wasm.readPositions(this.#decoder, level, at, vertexCount));
  }
  /** The same in double precision. */
  readPositionsDouble(level = this.layer?.level ?? 0) {
    const { vertexCount } = this.meshSize(level);
    return this.#read(Float64Array, 3 * vertexCount,
      (at) => this.#wasm.readPositionsDouble(this.#decoder, level, at, vertexCount));
  }
  /** Unit normals of each vertex. */
  readNormals(level = this.layer?.level ?? 0) {
    const { vertexCount } = this.meshSize(level);
    return this.#read(Float32Array, 3 * vertexCount,
      (at) => this.#wasm.readNormals(this.#decoder, level, at, vertexCount));
  }
  /** Red, green, blue and opacity of each vertex, sRGB, 0 ... 255; null when the stream has no colours or none yet. */
  readColors(level = this.layer?.level ?? 0) {
    if (!this.#header?.hasColors) return null;
    const { vertexCount } = this.meshSize(level);
    try {
      return this.#read(Uint8Array, 4 * vertexCount,
        (at) => this.#wasm.readColors(this.#decoder, level, at, vertexCount));
    } catch (error) {
      if (error.code === 'NMC_ERR_STATE') return null;
      throw error;
    }
  }
  /** { normal, isOffNormal }: length of each vertex's offset along its normal, and 1 where it also moves sideways. */
  readOffsets(level = this.layer?.level ?? 0) {
    const { vertexCount } = this.meshSize(level);
    const wasm = this.#wasm;
    return {
      normal: this.#read(Float32Array, vertexCount,
        (at) => wasm.readOffsets(this.#decoder, level, at, 0, vertexCount)),
      isOffNormal: this.#read(Uint8Array, vertexCount,
        (at) => wasm.readOffsets(this.#decoder, level, 0, at, vertexCount)),
    };
  }
  /** Hash of the integers of the current layer as 16 hexadecimal digits: equal in every conformant decoder. */
  stateHash() { return this.#hash((at) => this.#wasm.stateHash(this.#decoder, at)); }
  /** Hash of the positions of a level in double precision. */
  positionHash(level = this.layer?.level ?? 0) {
    return this.#hash((at) => this.#wasm.positionHash(this.#decoder, level, at));
  }

  /** Gives all memory back. The decoder is of no use afterwards. */
  dispose() { this.#wasm = null; }

  #live() {
    if (!this.#wasm) throw new NmcError('NMC_ERR_STATE', 'the decoder was disposed of');
    return this.#wasm;
  }
  #text(address) {
    const bytes = new Uint8Array(this.#wasm.memory.buffer, address);
    return String.fromCharCode(...bytes.subarray(0, bytes.indexOf(0)));
  }
  #check(status) {
    if (status >= 0) return;
    const wasm = this.#wasm;
    wasm.error(this.#decoder, this.#scratch);
    const [byteOffset, chunkType, section, message] = new Float64Array(wasm.memory.buffer, this.#scratch, 4);
    throw new NmcError(STATUS[status] ?? 'NMC_UNKNOWN', this.#text(message) || RULES[this.#text(section)],
      { byteOffset, chunkType, specSection: this.#text(section) });
  }
  #read(Type, count, fill) {
    const wasm = this.#live();
    const address = wasm.allocate(count * Type.BYTES_PER_ELEMENT || 1);
    if (!address) throw new NmcError('NMC_ERR_NO_MEMORY', 'memory exhausted');
    try {
      this.#check(fill(address));
      return new Type(wasm.memory.buffer, address, count).slice();
    } finally {
      wasm.release(address);
    }
  }
  #hash(fill) {
    this.#live();
    this.#check(fill(this.#scratch));
    const [low, high] = new Uint32Array(this.#wasm.memory.buffer, this.#scratch, 2);
    return high.toString(16).padStart(8, '0') + low.toString(16).padStart(8, '0');
  }
  #readHeader() {
    const wasm = this.#wasm;
    this.#check(wasm.info(this.#decoder, this.#scratch));
    const f = Array.from(new Float64Array(wasm.memory.buffer, this.#scratch, 22));
    this.#header = Object.freeze({
      headerBytes: f[0], streamBytes: f[1], layerCount: f[2], levelCount: f[3], qualityLayerCount: f[4],
      base: { vertexCount: f[5], triangleCount: f[6] }, input: { vertexCount: f[7], triangleCount: f[8] },
      box: { min: f.slice(9, 12), max: f.slice(12, 15) }, diagonal: f[15], gridStep: f[16],
      units: UNITS[f[17]] ?? '', up: UP[f[18]] ?? '', hasCreases: f[19] !== 0, hasColors: f[20] !== 0, regionCount: f[21],
    });
    this.#layers = [];
    for (let index = 0; index < f[2]; ++index) {
      this.#check(wasm.layer(this.#decoder, index, this.#scratch));
      const r = new Float64Array(wasm.memory.buffer, this.#scratch, 7);
      this.#layers.push(Object.freeze({
        index, level: r[0], bytes: r[1], triangles: r[2], region: r[6] < 0 ? undefined : r[6],
        maxError: r[5] ? r[3] : undefined, rmsError: r[5] ? r[4] : undefined,
      }));
    }
  }
}

/** The last row that the options want: one of maxError, rmsError, maxTriangles, maxBytes, maxLevel; default all. */
function lastRow(decoder, options) {
  let row = decoder.layers.length - 1;
  for (const criterion of Object.keys(CRITERIA)) {
    if (options[criterion] !== undefined) {
      row = Math.min(row, decoder.selectLayer(criterion, options[criterion]).index);
    }
  }
  return row;
}

function meshOf(decoder, options) {
  const level = decoder.layer.level;
  const mesh = {
    header: decoder.header, layer: decoder.layer, level, indices: decoder.readIndices(level),
    positions: options.positions === 'f64' ? decoder.readPositionsDouble(level) : decoder.readPositions(level),
  };
  if (options.normals) mesh.normals = decoder.readNormals(level);
  if (options.colors) mesh.colors = decoder.readColors(level) ?? undefined;
  return mesh;
}

const asBytes = (data) => (data instanceof Uint8Array ? data
  : ArrayBuffer.isView(data) ? new Uint8Array(data.buffer, data.byteOffset, data.byteLength) : new Uint8Array(data));

/**
 * Decodes a whole buffer. A stream that is cut off or damaged rejects with NmcError, unless allowPartial is set and
 * at least one layer is complete; then the mesh has `error`.
 */
export async function decode(bytes, options = {}) {
  options.signal?.throwIfAborted();
  const decoder = await NmcDecoder.create(options);
  options.signal?.throwIfAborted();
  let error;
  try {
    try {
      decoder.feed(asBytes(bytes));
      let row = Infinity;
      for (let event; (event = decoder.next()) !== 'end';) {
        if (event === null) decoder.finish();
        if (event === 'header') row = lastRow(decoder, options);
        if (event === 'layer' && decoder.layer.index >= row) break;
      }
    } catch (thrown) {
      if (!options.allowPartial || !decoder.layer) throw thrown;
      error = thrown;
    }
    const mesh = meshOf(decoder, options);
    if (options.hashes) Object.assign(mesh, { stateHash: decoder.stateHash(), positionHash: decoder.positionHash() });
    return error ? { ...mesh, error } : mesh;
  } finally {
    decoder.dispose();
  }
}

/** Hands on what a ReadableStream gives, until it ends or `signal` fires. */
async function* piecesOfBody(body, signal) {
  const reader = body.getReader();
  const cancel = () => reader.cancel(signal.reason).catch(() => {});
  signal.addEventListener('abort', cancel);
  try {
    for (let part; !(part = await reader.read()).done;) yield asBytes(part.value);
    signal.throwIfAborted();
  } finally {
    signal.removeEventListener('abort', cancel);
    reader.cancel().catch(() => {});  // ends the request when a stop rule is met
  }
}

const bodyOf = (response) => {
  if (!response.ok) {
    throw new NmcError('HTTP_' + response.status, `${response.url || 'the stream'}: HTTP ${response.status}`);
  }
  return response.body;
};

/** Whether a reader wants bytes. It is shut while there is any reason to. */
export class Valve {
  #reasons = new Set();
  #opened = null;
  #wake = null;
  /** Told when it shuts. */
  onShut = null;

  get isShut() { return this.#reasons.size > 0; }
  shut(reason) {
    if (!this.isShut) this.#opened = new Promise((resolve) => { this.#wake = resolve; });
    this.#reasons.add(reason);
    this.onShut?.();
  }
  /** Takes one reason back, or all. */
  open(reason) {
    if (reason === undefined) this.#reasons.clear();
    else this.#reasons.delete(reason);
    if (!this.isShut) this.#wake?.();
  }
  /** Resolves as soon as it is open. */
  async pass() { while (this.isShut) await this.#opened; }
}

/**
 * Pieces of a URL. When the connection breaks the rest is asked for with Range, up to `retries` times in a row with a
 * growing delay; a server without Range sends all again, and what is known is skipped. `wanted()` is the size of the
 * whole once it is known: a body that ends before it counts as broken.
 *
 * While `valve` is shut nothing is read. That alone would not stop the network: browser and system take some megabytes
 * more. So a request of which the server has said that it knows Range is ended, and the rest is asked for afterwards.
 */
async function* piecesOfUrl(url, options, signal, wanted, valve) {
  const { retries = 6, retryDelay = 400, requestInit = {} } = options;
  let received = 0;
  let hasAnswered = false;
  let knowsRange = false;
  let tag = null;
  for (let failures = 0; ; ++failures) {
    let problem = null;
    await valve.pass();
    signal.throwIfAborted();
    const request = new AbortController();
    const end = () => request.abort(signal.reason);
    signal.addEventListener('abort', end, { once: true });
    let isHeld = false;
    valve.onShut = () => {
      if (received > 0 && !knowsRange) return;
      isHeld = true;
      request.abort();
    };
    try {
      const headers = new Headers(requestInit.headers);
      if (received > 0) {
        headers.set('Range', `bytes=${received}-`);
        if (tag && !tag.startsWith('W/')) headers.set('If-Range', tag);
      }
      const response = await (options.fetch ?? fetch)(url, { ...requestInit, headers, signal: request.signal });
      if (received > 0 && response.status === 416) return;
      if (received > 0 && response.status >= 500) throw new Error(`HTTP ${response.status}`);
      const body = bodyOf(response);
      const newTag = response.headers.get('etag');
      if (received > 0 && newTag !== tag) {
        throw new NmcError('SOURCE_CHANGED', 'the file was replaced on the server while it was being read');
      }
      tag = newTag;
      hasAnswered = true;
      knowsRange = response.status === 206 || response.headers.get('accept-ranges') === 'bytes';
      let position = response.status === 206 ? received : 0;
      for await (const piece of piecesOfBody(body, request.signal)) {
        const fresh = piece.subarray(Math.min(piece.length, received - position));
        position += piece.length;
        received += fresh.length;
        failures = 0;
        if (fresh.length > 0) yield fresh;
        await valve.pass();
      }
      if (received >= (wanted() ?? 0)) return;
    } catch (error) {
      if (error instanceof NmcError || signal.aborted) throw error;
      problem = error;
    } finally {
      signal.removeEventListener('abort', end);
      valve.onShut = null;
    }
    if (isHeld) {
      --failures;
      continue;
    }
    if (!hasAnswered || failures >= retries) {
      if (!problem) return;
      throw new NmcError('NETWORK', `${url}: ${problem.message}`, { byteOffset: received });
    }
    options.onRetry?.(received, problem);
    await new Promise((resolve) => { setTimeout(resolve, retryDelay * 2 ** failures); });
    signal.throwIfAborted();
  }
}

/**
 * Pieces of any source, as Uint8Array, until `signal` fires; see piecesOfUrl() for `wanted` and `valve`. For those who
 * feed a decoder elsewhere.
 */
export function piecesOf(source, options, signal, wanted, valve = new Valve()) {
  if (typeof source === 'string' || source instanceof URL) return piecesOfUrl(source, options, signal, wanted, valve);
  if (typeof Response === 'function' && source instanceof Response) source = bodyOf(source);
  if (typeof source?.getReader === 'function') return piecesOfBody(source, signal);
  if (source instanceof ArrayBuffer || ArrayBuffer.isView(source)) source = [source];
  if (!source?.[Symbol.asyncIterator] && !source?.[Symbol.iterator]) {
    throw new NmcError('NMC_ERR_ARGUMENT', 'a stream is a URL, Response, ReadableStream, buffer or iterable of buffers');
  }
  return (async function* () {
    for await (const part of source) yield asBytes(part);
  })();
}

/**
 * A stream that refines as bytes arrive. Iterate over it for its layers, or listen to its events 'progress', 'layer',
 * 'complete' and 'error'. Work happens only while it is iterated or run() is awaited; leaving the loop ends the request.
 */
export class NmcStream extends EventTarget {
  /** Resolves when the first mesh is there. Options: those of decode(), fetch, requestInit, retries, retryDelay. */
  static async open(source, options = {}) {
    const stream = new NmcStream(await NmcDecoder.create(options), options);
    try {
      options.signal?.addEventListener('abort', () => stream.#abort.abort(options.signal.reason), { once: true });
      if (options.signal?.aborted) stream.#abort.abort(options.signal.reason);
      stream.#pieces = piecesOf(source, options, stream.#abort.signal, () => stream.header?.streamBytes,
        stream.#valve);
      stream.#hasFirst = await stream.#advance();
    } catch (error) {
      stream.dispose();
      throw error;
    }
    return stream;
  }

  #decoder;
  #options;
  #pieces;
  #abort = new AbortController();
  #received = 0;
  #hasFirst = false;
  #row = Infinity;
  #isDone = false;
  #valve = new Valve();

  /** @private use NmcStream.open() */
  constructor(decoder, options) {
    super();
    this.#decoder = decoder;
    this.#options = options;
  }

  get header() { return this.#decoder.header; }
  get layers() { return this.#decoder.layers; }
  /** The layer that mesh() reads. */
  get layer() { return this.#decoder.layer; }
  get isDone() { return this.#isDone; }
  /** Bytes that have arrived so far. */
  get receivedBytes() { return this.#received; }
  /** The decoder behind the stream, for everything else that can be read of a mesh. */
  get decoder() { return this.#decoder; }

  /** Indices, positions and, if asked for, normals of the current layer, in fresh arrays. */
  mesh(options = {}) { return meshOf(this.#decoder, { ...this.#options, ...options }); }
  stateHash() { return this.#decoder.stateHash(); }
  positionHash() { return this.#decoder.positionHash(); }

  /**
   * Holds the stream before its next layer. A request of a URL is ended where the server knows Range, and resume() asks
   * for the rest; other sources are not read meanwhile.
   */
  pause() { this.#valve.shut('pause'); }
  resume() { this.#valve.open('pause'); }

  /** Yields each layer; the first one is there already. Throws NmcError; what was read before stands. */
  async *[Symbol.asyncIterator]() {
    try {
      for (let has = this.#hasFirst; has; has = await this.#advance()) {
        this.#hasFirst = false;
        this.dispatchEvent(new Event('layer'));
        yield { ...this.layer, mesh: (options) => this.mesh(options) };
      }
      this.dispatchEvent(new Event('complete'));
    } catch (error) {
      this.dispatchEvent(Object.assign(new Event('error'), { error }));
      throw error;
    } finally {
      await this.#close();
    }
  }
  /** Works through the whole stream; events tell of the layers. */
  async run() {
    for await (const layer of this) void layer;
    return this.layer;
  }
  /** Ends the request and gives all memory back. */
  dispose() {
    this.#abort.abort(new NmcError('NMC_ERR_STATE', 'the stream was disposed of'));
    this.#isDone = true;
    this.#valve.open();
    this.#decoder.dispose();
  }

  async #close() {
    this.#isDone = true;
    await this.#pieces?.return?.().catch(() => {});
  }

  /** True with the next layer in place, false at the end. */
  async #advance() {
    while (!this.#isDone) {
      await this.#valve.pass();
      this.#abort.signal.throwIfAborted();
      const event = this.#decoder.next();
      if (event === 'header') this.#row = lastRow(this.#decoder, this.#options);
      if (event === 'layer') {
        if (this.layer.index >= this.#row) await this.#close();
        return true;
      }
      if (event === 'end') await this.#close();
      if (event !== null) continue;
      const piece = await this.#pieces.next();
      if (piece.done) {
        this.#decoder.finish();
      } else {
        this.#abort.signal.throwIfAborted();
        this.#received += piece.value.length;
        this.#decoder.feed(piece.value);
        this.dispatchEvent(new Event('progress'));
      }
    }
    return false;
  }
}
