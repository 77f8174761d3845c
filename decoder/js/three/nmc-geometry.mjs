// SPDX-License-Identifier: Apache-2.0
// The geometry that NMCLoader gives: coarse at first, refined in place by the job of a worker.
import { Box3, BufferGeometry, Sphere, Vector3 } from 'three';

import { NmcError } from '../nmc-decoder.mjs';
import { nextFrame, uploadAttributes } from './nmc-upload.mjs';

/** What a triangle costs in bytes: 20 in arrays, as much on the card, and what the decoder holds. */
const BYTES_PER_TRIANGLE = 150;

/** As stop rules of nmc-decoder: `maxMemory` in bytes becomes a number of triangles. */
export function stopRulesOf({ maxMemory, maxTriangles, ...rest }) {
  const affordable = maxMemory === undefined ? Infinity : Math.floor(maxMemory / BYTES_PER_TRIANGLE);
  const most = Math.min(affordable, maxTriangles ?? Infinity);
  return most === Infinity ? rest : { ...rest, maxTriangles: most };
}

/** The length that `pixels` on the screen stand for at the point of a geometry that is nearest to the camera. */
export function lengthOfPixels(pixels, { camera, viewportHeight, object, geometry }) {
  object?.updateWorldMatrix(true, false);
  camera.updateWorldMatrix(true, false);
  const scale = object ? object.matrixWorld.getMaxScaleOnAxis() : 1;
  const sphere = geometry.boundingSphere.clone();
  if (object) sphere.applyMatrix4(object.matrixWorld);
  if (camera.isOrthographicCamera) {
    return (pixels * (camera.top - camera.bottom)) / (camera.zoom * viewportHeight * scale);
  }
  const eye = new Vector3().setFromMatrixPosition(camera.matrixWorld);
  const distance = Math.max(eye.distanceTo(sphere.center) - sphere.radius, camera.near);
  const height = (2 * distance * Math.tan((camera.fov * Math.PI) / 360)) / camera.zoom;
  return (pixels * height) / (viewportHeight * scale);
}

/**
 * Events: 'layer' when a better mesh is in place, 'progress' (loaded, total), 'retry' when a broken connection is
 * taken up again, 'hold' when the goal is met, 'complete', 'error' (error; the mesh stays as it is).
 * Levels and layers come in the order of the stream; on a fast line some are never shown.
 */
export class NMCGeometry extends BufferGeometry {
  /** @private NMCLoader makes them. `send(message)` reaches the job, `release` ends it. */
  constructor({ send, release, renderer, bytesPerFrame }) {
    super();
    this.isNMCGeometry = true;
    this.header = null;
    this.layers = [];
    this.levels = [];        // { vertexCount, triangleCount } of each level; null where unknown
    this.layer = null;       // that is in place
    this.receivedBytes = 0;
    this.isComplete = false;
    this.error = null;
    this.stateHash = '';
    this.positionHash = '';  // of the finest mesh, when complete: what nmc-decode --hash prints
    this._send = send;
    this._release = release;
    this._renderer = renderer;
    this._bytesPerFrame = bytesPerFrame;
    this._isOver = false;
    this._requests = new Map();
    this._requestCount = 0;
    this._morphTriangles = 0;
    this._morphDuration = 0;
    this._morphBegin = -Infinity;
    this._work = Promise.resolve();
    this._onRestored = () => {
      for (const each of [this.index, ...Object.values(this.attributes)]) each?.forgetBuffer?.();
      this._dropBuffers();
    };
    renderer?.domElement?.addEventListener('webglcontextrestored', this._onRestored);
    /** Resolves at the end of the stream, to this; rejects with NmcError when it breaks. */
    this.finished = new Promise((resolve, reject) => {
      this._settle = { resolve: () => resolve(this), reject };
    });
    this.finished.catch(() => {});
  }

  /**
   * Refines until a goal is met, then holds, the network included; resolves to the layer in place. Goals: `maxError`
   * in model units, `layer`, an index; or `pixels` with `camera`, `viewportHeight` and `object`, the mesh. A later
   * call moves the goal; refineTo({}) asks for all there is. Never makes a mesh coarser.
   */
  refineTo(goal) {
    const maxError = goal.pixels === undefined ? goal.maxError
      : lengthOfPixels(goal.pixels, { ...goal, geometry: this });
    const maxLayer = goal.layer;
    this._send({ type: 'goal', goal: { maxError, maxLayer } });
    const isMet = () => this.isComplete || (maxError !== undefined && this.layer.maxError <= maxError) ||
      (maxLayer !== undefined && this.layer.index >= maxLayer);
    return new Promise((resolve, reject) => {
      const look = () => {
        const isOver = this._isOver || this.error;
        if (!isOver && !isMet()) return;
        for (const type of ['layer', 'complete', 'error', 'dispose']) this.removeEventListener(type, look);
        if (isMet()) resolve(this.layer);
        else reject(this.error ?? new NmcError('NMC_ERR_STATE', 'the geometry was disposed of'));
      };
      for (const type of ['layer', 'complete', 'error', 'dispose']) this.addEventListener(type, look);
      look();
    });
  }
  /** Reads no more, as in NmcStream.pause(); what has been decoded is still shown. */
  pause() { this._send({ type: 'pause' }); }
  resume() { this._send({ type: 'resume' }); }

  /** { normal, isOffNormal } of the vertices in place, see nmc_decoder_read_offsets(). Needs option keepDecoder. */
  readOffsets() {
    const request = ++this._requestCount;
    return new Promise((resolve, reject) => {
      this._requests.set(request, { resolve, reject });
      this._send({ type: 'overlay', request });
    });
  }

  /** Of levels up to so many triangles the worker also sends where they start; NMCMesh asks for it. */
  enableMorph(triangles, duration) {
    this._morphTriangles = Math.max(this._morphTriangles, triangles);
    this._morphDuration = duration;
    this._send({ type: 'morph', triangles: this._morphTriangles });
  }
  /** 0 at the start of a morph, 1 from its end on. */
  morphShare(now = performance.now()) {
    const share = (now - this._morphBegin) / this._morphDuration;
    return share >= 1 || !this.attributes.nmcStart ? 1 : share * share * (3 - 2 * share);
  }
  get isMorphing() { return this.morphShare() < 1; }

  /** Ends the stream and frees everything. */
  dispose() {
    if (!this._isOver) {
      this._isOver = true;
      this._renderer?.domElement?.removeEventListener('webglcontextrestored', this._onRestored);
      this._release();
      for (const { reject } of this._requests.values()) {
        reject(new NmcError('NMC_ERR_STATE', 'the geometry was disposed of'));
      }
      this._requests.clear();
      this._settle.reject(new NmcError('NMC_ERR_STATE', 'the geometry was disposed of'));
    }
    super.dispose();
  }

  /** @private Messages of the job, in their order. */
  receive(message) {
    if (message.type === 'progress') {
      this.receivedBytes = message.received;
      this.dispatchEvent({ type: 'progress', loaded: message.received, total: this.header?.streamBytes ?? 0 });
    } else if (message.type === 'overlay') {
      const { resolve, reject } = this._requests.get(message.request) ?? {};
      this._requests.delete(message.request);
      if (message.error) reject?.(Object.assign(new NmcError(message.error.code, message.error.message), message.error));
      else resolve?.(message);
    } else if (message.type === 'retry') {
      this.dispatchEvent({ type: 'retry', loaded: message.received, reason: message.problem });
    } else {
      this._work = this._work.then(() => (this._isOver ? null : this._apply(message)));
    }
  }

  async _apply(message) {
    if (message.type === 'mesh') {
      await this._showMesh(message);
    } else if (message.type === 'hold') {
      this.dispatchEvent({ type: 'hold', layer: this.layer });
    } else if (message.type === 'complete') {
      this.isComplete = true;
      this.stateHash = message.stateHash;
      this.positionHash = message.positionHash;
      this.dispatchEvent({ type: 'complete', layer: this.layer });
      this._settle.resolve();
    } else if (message.type === 'error') {
      this.error = Object.assign(new NmcError(message.error.code, message.error.message), message.error);
      this.dispatchEvent({ type: 'error', error: this.error });
      this._settle.reject(this.error);
    }
  }

  async _showMesh(message) {
    this._send({ type: 'ready' });  // the worker prepares the next one while this one is uploaded
    const { positions, normals, indices, colors, startPositions, startNormals } = message;
    const piece = (array, itemSize, normalized) => (array ? { array, itemSize, normalized } : null);
    const attributes = await uploadAttributes([
      piece(positions, 3, false), piece(normals, 4, true), indices ? { array: indices, itemSize: 1, normalized: false, isIndex: true } : null,
      piece(colors, 4, true),
      piece(startPositions, 3, false), piece(startNormals, 4, true),
    ], this._renderer, this._bytesPerFrame, () => this._isOver);
    if (!attributes) return;
    const [position, normal, index, color, start, startNormal] = attributes;
    const keptIndex = index ?? this.index;
    if (!index) this.index = null;  // of the same level: its buffer is not dropped
    this._dropBuffers();
    if (message.header) {
      this.header = message.header;
      this.layers = message.layers;
      this.levels = message.levels;
    }
    this.layer = this.layers[message.layer.index];
    this.receivedBytes = Math.max(this.receivedBytes, message.received);
    const set = (name, attribute) => (attribute ? this.setAttribute(name, attribute) : this.deleteAttribute(name));
    this.setIndex(keptIndex);
    set('position', position);
    set('normal', normal);
    set('color', color);
    set('nmcStart', start);
    set('nmcStartNormal', startNormal);
    this._morphBegin = start ? performance.now() : -Infinity;
    this._setBounds();
    this.dispatchEvent({ type: 'layer', layer: this.layer });
    if (start) await this._endOfMorph();
  }
  /** The next layer waits for it: what grows out of a mesh must find that mesh. */
  async _endOfMorph() {
    const end = performance.now() + this._morphDuration;
    while (!this._isOver && performance.now() < end) await nextFrame();
  }
  /** The box of the input, wider by what the layer may lie outside; no pass over the vertices. */
  _setBounds() {
    const { box, diagonal } = this.header;
    this.boundingBox = new Box3(new Vector3(...box.min), new Vector3(...box.max))
      .expandByScalar(this.layer.maxError ?? 0.05 * diagonal);
    this.boundingSphere = this.boundingBox.getBoundingSphere(new Sphere());
  }
  /** Tells renderers to delete the buffers of all attributes; they are made anew at the next use. */
  _dropBuffers() { super.dispose(); }
}
