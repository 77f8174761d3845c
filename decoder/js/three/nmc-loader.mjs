// SPDX-License-Identifier: Apache-2.0
// NMCLoader: .nmc streams for three.js. It resolves at the first mesh and refines it in place.
//
//   const loader = new NMCLoader().setRenderer(renderer);
//   const geometry = await loader.loadAsync('statue.nmc');
//   scene.add(new NMCMesh(geometry, new MeshStandardMaterial()));  // or any Mesh: then levels appear at once
import { Loader } from 'three';

import { NmcError, Valve, piecesOf } from '../nmc-decoder.mjs';
import { NMCGeometry, lengthOfPixels, stopRulesOf } from './nmc-geometry.mjs';
import { NMCMesh, enableMorph } from './nmc-mesh.mjs';

export { NMCGeometry, NMCMesh, NmcError, enableMorph, lengthOfPixels };

/** So many bytes may be on their way to a worker; more would defeat pause(). */
const BYTES_IN_FLIGHT = 1 << 18;

/** Workers that serve several jobs each; one on this thread where there are none. */
class JobPool {
  #slots = [];
  #limit = 4;
  #count = 0;
  #createWorker = () => new Worker(new URL('./nmc-worker.mjs', import.meta.url), { type: 'module' });

  set limit(limit) { this.#limit = limit; }
  set createWorker(create) { this.#createWorker = create; }
  get workerCount() { return this.#slots.length; }

  #slot() {
    const idle = this.#slots.find(({ receivers }) => receivers.size === 0);
    if (idle) return idle;
    if (this.#slots.length < this.#limit) {
      const slot = { worker: this.#createWorker(), receivers: new Map() };
      slot.worker.onmessage = ({ data }) => slot.receivers.get(data.id)?.(data);
      slot.worker.onerror = (event) => {
        event.preventDefault?.();
        const error = { code: 'WORKER', message: event.message || 'the worker could not be started' };
        for (const receive of [...slot.receivers.values()]) receive({ type: 'error', error });
        this.#slots = this.#slots.filter((other) => other !== slot);
      };
      this.#slots.push(slot);
      return slot;
    }
    return this.#slots.reduce((a, b) => (b.receivers.size < a.receivers.size ? b : a));
  }
  preload() { if (this.#hasWorkers) this.#slot(); }
  get #hasWorkers() { return this.#limit > 0 && typeof Worker === 'function'; }

  /** { send, release } of a new job whose messages go to `receive`. */
  open(source, options, receive) {
    const id = ++this.#count;
    const transfer = source instanceof ArrayBuffer ? [source] : [];
    if (!this.#hasWorkers) return this.#openHere(source, options, receive);
    const slot = this.#slot();
    slot.receivers.set(id, receive);
    slot.worker.postMessage({ id, type: 'open', source, options }, transfer);
    return {
      send: (message, moved = []) => slot.worker.postMessage({ ...message, id }, moved),
      release: () => {
        if (slot.receivers.delete(id)) slot.worker.postMessage({ id, type: 'dispose' });
      },
    };
  }
  #openHere(source, options, receive) {
    let isOver = false;
    const job = import('./nmc-worker.mjs').then(({ StreamJob }) =>
      new StreamJob((message) => { if (!isOver) receive(message); }, source, options));
    const send = (message) => { job.then((it) => it.handle(message)); };
    return {
      send,
      release: () => {
        isOver = true;
        send({ type: 'dispose' });
      },
    };
  }
  dispose() {
    for (const { worker } of this.#slots) worker.terminate();
    this.#slots = [];
  }
}

export class NMCLoader extends Loader {
  #pool = new JobPool();
  #options = {};
  #geometries = new Set();
  #renderer = null;

  /** With the WebGLRenderer that will draw, meshes are uploaded in slices; without, at once by three.js. */
  setRenderer(renderer) {
    this.#renderer = renderer;
    return this;
  }
  /** At most so many workers, default 4; 0 decodes on the calling thread. */
  setWorkerLimit(limit) {
    this.#pool.limit = limit;
    return this;
  }
  /** For bundlers that do not follow new URL(..., import.meta.url): makes the worker of nmc-decoder/worker. */
  setWorkerFactory(create) {
    this.#pool.createWorker = create;
    return this;
  }
  /**
   * Defaults for all streams. Stop rules: maxError, rmsError, maxTriangles, maxBytes, maxLevel, maxMemory. goal: as
   * refineTo(), to start with. normals: false for none. limits, retries, retryDelay, fetch, signal as nmc-decoder.
   * uploadBytesPerFrame, default 2 MiB. keepDecoder: the worker keeps the stream after its end, for readOffsets().
   */
  setOptions(options) {
    this.#options = { ...this.#options, ...options };
    return this;
  }
  get workerCount() { return this.#pool.workerCount; }
  /** Starts a worker before it is needed. */
  preload() {
    this.#pool.preload();
    return this;
  }

  load(url, onLoad, onProgress, onError) {
    const { manager } = this;
    const fail = (error) => {
      if (onError) onError(error);
      else console.error(error);
      manager.itemError(url);
    };
    manager.itemStart(url);
    this.open(this.#resolved(url), {
      onProgress: (loaded, total) => onProgress?.({ lengthComputable: total > 0, loaded, total }),
    }).then((geometry) => {
      // As loaders do: a mistake in onLoad is reported like a file that is wrong.
      onLoad?.(geometry);
    }).catch(fail).finally(() => manager.itemEnd(url));
  }
  /** The geometry of a whole stream in memory, at its first mesh; the buffer is copied. */
  parse(buffer, onLoad, onError = console.error) {
    this.parseAsync(buffer).then(onLoad, onError);
  }
  parseAsync(buffer, options = {}) { return this.open(buffer, options); }

  /**
   * The geometry of any source of nmc-decoder (URL, Response, ReadableStream, buffer, iterable), at its first mesh.
   * `options`: as setOptions(), and onProgress(loaded, total). Rejects with NmcError.
   */
  async open(source, options = {}) {
    const { fetch, signal, onProgress, uploadBytesPerFrame = 1 << 21, ...rest } = { ...this.#options, ...options };
    signal?.throwIfAborted();
    const isUrl = typeof source === 'string' || source instanceof URL;
    const isBuffer = source instanceof ArrayBuffer || ArrayBuffer.isView(source);
    const jobOptions = { ...stopRulesOf(rest), requestInit: this.#requestInit(), morphTriangles: 0 };
    const byWorker = isBuffer || (isUrl && !fetch);
    let sent = null;
    if (byWorker) sent = isBuffer ? copyOf(source) : this.#resolved(String(source));
    let geometry = null;
    const abort = new AbortController();
    const valve = new Valve();
    let arrived = 0;
    let wake = null;
    const receive = (message) => {
      if (message.type === 'hold') valve.shut('goal');
      if (message.type === 'go') valve.open('goal');
      if (message.type === 'progress') {
        arrived = message.received;
        wake?.();
      }
      geometry.receive(message);
    };
    const job = this.#pool.open(sent, jobOptions, receive);
    const send = (message) => {
      if (message.type === 'pause') valve.shut('pause');
      if (message.type === 'resume') valve.open('pause');
      job.send(message);
    };
    const release = () => {
      abort.abort();
      valve.open();
      wake?.();
      job.release();
      this.#geometries.delete(geometry);
    };
    geometry = new NMCGeometry({
      send, release, renderer: this.#renderer, bytesPerFrame: uploadBytesPerFrame,
    });
    this.#geometries.add(geometry);
    if (onProgress) geometry.addEventListener('progress', ({ loaded, total }) => onProgress(loaded, total));
    signal?.addEventListener('abort', () => geometry.dispose(), { once: true });
    if (!byWorker) {
      const wanted = () => geometry.header?.streamBytes;
      const room = async (posted) => {
        while (posted - arrived > BYTES_IN_FLIGHT && !abort.signal.aborted) {
          await new Promise((resolve) => { wake = resolve; });
        }
        await valve.pass();
      };
      const from = isUrl ? this.#resolved(String(source)) : source;
      const onRetry = (received, problem) => receive({ type: 'retry', received, problem: problem?.message ?? '' });
      this.#pump(piecesOf(from, { ...jobOptions, fetch, onRetry }, abort.signal, wanted, valve), job, room);
    }
    return new Promise((resolve, reject) => {
      const settle = (event) => {
        for (const type of ['layer', 'error', 'dispose']) geometry.removeEventListener(type, settle);
        if (geometry.layer) return resolve(geometry);
        geometry.dispose();
        reject(event.error ?? signal?.reason ?? new NmcError('NMC_ERR_STATE', 'the loader was disposed of'));
      };
      for (const type of ['layer', 'error']) geometry.addEventListener(type, settle);
      geometry.finished.catch(() => { if (!geometry.layer) settle({}); });
    });
  }

  /** Reads here what a worker cannot, and sends it on. */
  async #pump(pieces, job, room) {
    let posted = 0;
    try {
      for await (const piece of pieces) {
        const bytes = piece.slice();
        posted += bytes.length;
        job.send({ type: 'piece', bytes }, [bytes.buffer]);
        await room(posted);
      }
      job.send({ type: 'piece', isEnd: true });
    } catch (error) {
      const { code = 'NETWORK', message, byteOffset = posted } = error;
      job.send({ type: 'piece', problem: { code: String(code), message, byteOffset } });
    }
  }
  #resolved(url) {
    const full = this.manager.resolveURL(/^([a-z][a-z0-9+.-]*:|\/)/i.test(url) ? url : this.path + url);
    const base = globalThis.document?.baseURI ?? globalThis.location?.href;
    return base ? new URL(full, base).href : full;
  }
  #requestInit() {
    return {
      headers: { ...this.requestHeader }, credentials: this.withCredentials ? 'include' : 'same-origin',
      ...(this.priority && this.priority !== 'auto' ? { priority: this.priority } : {}),
      ...(this.cache && this.cache !== 'default' ? { cache: this.cache } : {}),
    };
  }
  /** Ends the streams that are on their way and the workers; geometries keep what they show. */
  dispose() {
    for (const geometry of this.#geometries) if (!geometry.layer) geometry.dispose();
    this.#geometries.clear();
    this.#pool.dispose();
    return this;
  }
}

const copyOf = (source) => (source instanceof ArrayBuffer ? source.slice(0)
  : source.buffer.slice(source.byteOffset, source.byteOffset + source.byteLength));
