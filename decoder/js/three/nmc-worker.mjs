// SPDX-License-Identifier: Apache-2.0
// The worker of NMCLoader: decodes streams and hands on meshes that are ready to draw. Each stream lives in its own
// WebAssembly instance, so that its end gives its memory back; a worker serves several streams.
//
// Messages to it: { type, id, ... } with type
//   open     source: a URL, a buffer, or null for pieces by message; options, see openStream()
//   piece    bytes; or isEnd; or problem: what went wrong at the source
//   ready    the mesh sent last is in use: the next may come
//   goal     goal: { maxError?, maxLayer? }: work until one is met, then hold, network included
//   morph    triangles: finer meshes come without the place they start from
//   pause    read no more; the mesh of what was decoded still comes. resume, dispose
//   overlay  request, kind 'offsets': how vertices of the mesh that was sent last were set off their prediction
// Messages from it: progress, mesh, hold (the goal is met), go (it was moved), retry, complete, error, overlay.
import { NmcError, NmcStream } from '../nmc-decoder.mjs';

/** Pieces that arrive by message. */
class PieceQueue {
  #pieces = [];
  #wake = null;
  #problem = null;
  #hasEnded = false;

  push({ bytes, isEnd, problem }) {
    if (bytes) this.#pieces.push(bytes);
    this.#hasEnded ||= Boolean(isEnd || problem);
    this.#problem ??= problem ? Object.assign(new NmcError(problem.code, problem.message), problem) : null;
    this.#wake?.();
  }
  async *[Symbol.asyncIterator]() {
    for (;;) {
      while (this.#pieces.length > 0) yield this.#pieces.shift();
      if (this.#problem) throw this.#problem;
      if (this.#hasEnded) return;
      await new Promise((resolve) => { this.#wake = resolve; });
    }
  }
}

/** Lets messages that are waiting be handled; a resolved promise would not. */
const turn = (() => {
  const { port1, port2 } = new MessageChannel();
  const waiting = [];
  port1.onmessage = () => waiting.shift()();
  port1.unref?.();
  return () => new Promise((resolve) => {
    waiting.push(resolve);
    port1.ref?.();
    port2.postMessage(null);
  }).finally(() => port1.unref?.());
})();

/** Unit vectors as four signed bytes each, the last one unused: graphics cards want multiples of four. */
export function packNormals(normals) {
  const packed = new Int8Array((normals.length / 3) * 4);
  for (let i = 0, j = 0; i < normals.length; i += 3, j += 4) {
    packed[j] = Math.round(127 * normals[i]);
    packed[j + 1] = Math.round(127 * normals[i + 1]);
    packed[j + 2] = Math.round(127 * normals[i + 2]);
  }
  return packed;
}

const LINEAR = Uint16Array.from({ length: 256 }, (_, value) => {
  const share = value / 255;
  return Math.round(65535 * (share <= 0.04045 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4));
});
/** sRGB bytes with opacity as linear numbers of 16 bits, which three.js and glTF want (IEC 61966-2-1). */
export function linearColors(colors) {
  const linear = new Uint16Array(colors.length);
  for (let i = 0; i < colors.length; ++i) linear[i] = i % 4 === 3 ? 257 * colors[i] : LINEAR[colors[i]];
  return linear;
}

/**
 * Where a finer mesh starts when it is to look like the coarser one: `values`, with `size` numbers per vertex of the
 * coarser mesh, go on to the finer vertices, each new one to the mean of its edge's ends. The four faces of a split
 * face stand together and name the new vertices (spec 6.1), so the indices of the levels between are not needed.
 */
export function refineValues(values, size, levels) {
  let coarse = values;
  for (const { indices, vertexCount } of levels) {
    const fine = new values.constructor(size * vertexCount);
    fine.set(coarse);
    const average = (a, b, m) => {
      for (let k = 0; k < size; ++k) fine[size * m + k] = (coarse[size * a + k] + coarse[size * b + k]) / 2;
    };
    for (let i = 0; i < indices.length; i += 12) {
      const v0 = indices[i], m2 = indices[i + 1], m1 = indices[i + 2];
      const v1 = indices[i + 4], m0 = indices[i + 5], v2 = indices[i + 8];
      average(v1, v2, m0);
      average(v2, v0, m1);
      average(v0, v1, m2);
    }
    coarse = fine;
  }
  return coarse;
}

/** What crosses to the other side of an error. */
export const plainError = (error) => ({
  code: error.code ?? (error.name === 'AbortError' ? 'ABORTED' : 'INTERNAL'), message: error.message,
  byteOffset: error.byteOffset ?? 0, chunkType: error.chunkType ?? 0, specSection: error.specSection ?? '',
});

/**
 * One stream. `post(message, transfer)` takes what it has to say. Options: limits and stop rules of nmc-decoder,
 * normals, morphTriangles (levels with more start at once instead of growing out of the coarser one), retries,
 * retryDelay, requestInit, goal.
 */
export class StreamJob {
  #post;
  #options;
  #queue = null;
  #stream = null;
  #goal;
  #isWanted = true;
  #isPaused = false;
  #isHolding = false;  // the goal is met
  #isOver = false;
  #wake = null;
  #shown = null;  // what the other side draws: layer, level, positions, normals, indices

  constructor(post, source, options) {
    this.#post = post;
    this.#options = options;
    this.#goal = options.goal ?? {};
    if (source === null) this.#queue = new PieceQueue();
    this.#run(source ?? this.#queue);
  }

  handle(message) {
    if (message.type === 'piece') this.#queue?.push(message);
    if (message.type === 'ready') this.#want();
    if (message.type === 'goal') this.#goal = message.goal;
    if (message.type === 'pause' || message.type === 'resume') {
      this.#isPaused = message.type === 'pause';
      this.#steer();
    }
    if (message.type === 'morph') this.#options = { ...this.#options, morphTriangles: message.triangles };
    if (message.type === 'overlay') this.#sendOverlay(message.request);
    if (message.type === 'dispose') {
      this.#isOver = true;
      this.#stream?.dispose();
      this.#shown = null;
    }
    this.#wake?.();
  }

  /**
   * The other side wants a mesh. If it has missed one, that one is sent unless the next comes soon: on a slow line, or
   * in a pause, it may take long.
   */
  #want() {
    this.#isWanted = true;
    setTimeout(() => {
      const layer = this.#stream?.layer;
      if (this.#isOver || !this.#isWanted || !this.#shown || !layer || layer.index === this.#shown.layer.index) return;
      try {
        this.#sendMesh();
      } catch {
        return;  // a stream that broke tells so itself
      }
    }, 100);
  }
  /** Lets the stream run or not. */
  #steer() {
    if (this.#isPaused || this.#isHolding) this.#stream?.pause();
    else this.#stream?.resume();
  }

  #isMet(layer) {
    const { maxError, maxLayer } = this.#goal;
    return (maxError !== undefined && layer.maxError !== undefined && layer.maxError <= maxError) ||
      (maxLayer !== undefined && layer.index >= maxLayer);
  }
  async #until(condition) {
    while (!this.#isOver && !condition()) await new Promise((resolve) => { this.#wake = resolve; });
  }

  async #run(source) {
    try {
      const { retries, retryDelay, requestInit, limits, maxError, rmsError, maxTriangles, maxBytes, maxLevel } =
        this.#options;
      const stream = this.#stream = await NmcStream.open(source, {
        retries, retryDelay, requestInit, limits, maxError, rmsError, maxTriangles, maxBytes, maxLevel,
        onRetry: (received, problem) => this.#post({ type: 'retry', received, problem: problem?.message ?? '' }),
      });
      if (this.#isOver) return stream.dispose();
      this.#steer();
      const tell = () => this.#post({ type: 'progress', received: stream.receivedBytes });
      stream.addEventListener('progress', tell);
      tell();
      for await (const layer of stream) {
        await turn();
        if (this.#isOver) return;
        if (this.#isWanted) this.#sendMesh();
        if (this.#isMet(layer)) {
          this.#isHolding = true;
          this.#steer();
          await this.#until(() => this.#isWanted);
          if (this.#isOver) return;
          this.#sendMesh();
          this.#post({ type: 'hold', layer: { ...layer, mesh: undefined } });
          await this.#until(() => !this.#isMet(layer));
          this.#isHolding = false;
          this.#steer();
          this.#post({ type: 'go' });
        }
        if (this.#isOver) return;
      }
      await this.#until(() => this.#isWanted);
      if (this.#isOver) return;
      this.#sendMesh();
      this.#post({ type: 'complete', stateHash: stream.stateHash(), positionHash: stream.positionHash() });
      if (!this.#options.keepDecoder) stream.dispose();
    } catch (error) {
      if (this.#isOver) return;
      await this.#sendLast();
      this.#post({ type: 'error', error: plainError(error) });
    }
  }
  /** After an error: what was decoded and not yet shown. */
  async #sendLast() {
    if (!this.#stream) return;
    await this.#until(() => this.#isWanted);
    try {
      if (!this.#isOver) this.#sendMesh();
    } catch {
      return;  // the older state may be lost, and then what is shown stands
    }
  }

  /** The mesh of the current layer, unless the other side has it. */
  #sendMesh() {
    const { decoder } = this.#stream;
    const { layer } = decoder;
    const shown = this.#shown;
    if (shown?.layer.index === layer.index) return;
    const { level } = layer;
    const { vertexCount, triangleCount } = decoder.meshSize(level);
    const isNewLevel = shown?.level !== level;
    const positions = decoder.readPositions(level);
    const normals = this.#options.normals === false ? null : packNormals(decoder.readNormals(level));
    const indices = isNewLevel ? decoder.readIndices(level) : null;
    const message = {
      type: 'mesh', layer, level, vertexCount, triangleCount, positions, normals, indices,
      received: this.#stream.receivedBytes,
    };
    const colors = this.#options.colors === false ? null : decoder.readColors(level);
    if (colors) message.colors = linearColors(colors);
    if (!shown) Object.assign(message, { header: decoder.header, layers: decoder.layers, levels: this.#levels() });
    const morphs = triangleCount <= this.#options.morphTriangles;
    if (shown?.positions && morphs) {
      const between = [];
      for (let l = shown.level + 1; l <= level; ++l) {
        between.push({ indices: l === level ? indices : decoder.readIndices(l), ...decoder.meshSize(l) });
      }
      message.startPositions = refineValues(shown.positions, 3, between);
      if (normals && shown.normals) message.startNormals = refineValues(shown.normals, 4, between);
      if (between.length === 0) {  // the arrays themselves, which are not needed here any more
        message.startPositions = shown.positions;
        message.startNormals = shown.normals;
      }
    }
    const next = 4 * triangleCount <= this.#options.morphTriangles || morphs;
    this.#shown = {
      layer, level, positions: next ? positions.slice() : null, normals: next ? normals?.slice() : null,
    };
    this.#isWanted = false;
    const arrays = [positions, normals, indices, message.colors, message.startPositions, message.startNormals];
    this.#post(message, [...new Set(arrays.filter(Boolean).map((array) => array.buffer))]);
  }
  #levels() {
    const { decoder } = this.#stream;
    return Array.from({ length: decoder.layers.at(-1).level + 1 }, (_, level) => {
      try {
        return decoder.meshSize(level);
      } catch {
        return null;  // so few bytes may not describe it yet
      }
    });
  }
  #sendOverlay(request) {
    try {
      const { normal, isOffNormal } = this.#stream.decoder.readOffsets(this.#shown.level);
      this.#post({ type: 'overlay', request, normal, isOffNormal }, [normal.buffer, isOffNormal.buffer]);
    } catch (error) {
      this.#post({ type: 'overlay', request, error: plainError(error) });
    }
  }
}

if (typeof WorkerGlobalScope !== 'undefined' && globalThis instanceof WorkerGlobalScope) {
  const jobs = new Map();
  globalThis.onmessage = ({ data }) => {
    const { id, type } = data;
    if (type === 'open') {
      const post = (message, transfer = []) => globalThis.postMessage({ ...message, id }, transfer);
      jobs.set(id, new StreamJob(post, data.source, data.options));
    } else {
      jobs.get(id)?.handle(data);
      if (type === 'dispose') jobs.delete(id);
    }
  };
}
