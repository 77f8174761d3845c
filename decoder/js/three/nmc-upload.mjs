// SPDX-License-Identifier: Apache-2.0
// Attributes whose bytes go to the graphics card in slices, a few megabytes per frame. three.js uploads an attribute
// whole at its first use, and a card that is busy makes the page wait for it; this goes around that with the
// renderer's own context. A BufferAttribute in all other respects: rays, wireframes and clones find the array.
import { BufferAttribute } from 'three';

export class UploadedAttribute extends BufferAttribute {
  /** `buffer` holds the array's bytes on the card of `gl`; three.js deletes it with the geometry. */
  constructor(array, itemSize, normalized, gl, buffer) {
    super(array, itemSize, normalized);
    this.buffer = buffer;
    this.type = typeOf(gl, array);
    this.elementSize = array.BYTES_PER_ELEMENT;
    this.isGLBufferAttribute = true;
  }
  /** An ordinary attribute again: for when the context was lost, and the buffer with it. */
  forgetBuffer() {
    delete this.isGLBufferAttribute;
    this.needsUpdate = true;
  }
}

function typeOf(gl, array) {
  if (array instanceof Float32Array) return gl.FLOAT;
  if (array instanceof Uint32Array) return gl.UNSIGNED_INT;
  if (array instanceof Uint16Array) return gl.UNSIGNED_SHORT;
  if (array instanceof Int8Array) return gl.BYTE;
  return gl.UNSIGNED_BYTE;
}

/** The next frame, or a little later where there are none: a page in the background draws nothing. */
export const nextFrame = () => new Promise((resolve) => {
  const timer = setTimeout(resolve, 120);
  if (typeof requestAnimationFrame !== 'function') return;
  requestAnimationFrame(() => {
    clearTimeout(timer);
    resolve();
  });
});

/**
 * Resolves once the card has done what it was asked so far: bytes that are sent while it is busy may find no room, and
 * then the page waits for it.
 */
async function cardIsIdle(gl, isOver) {
  const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
  gl.flush();
  const end = performance.now() + 5000;
  do await nextFrame();
  while (!isOver() && !gl.isContextLost() && performance.now() < end &&
    gl.getSyncParameter(fence, gl.SYNC_STATUS) !== gl.SIGNALED);
  gl.deleteSync(fence);
}

/** WebGL wants to know of a buffer of indices by its first binding. */
function bindFirstAsIndex(gl, buffer) {
  const current = gl.getParameter(gl.VERTEX_ARRAY_BINDING);
  const own = gl.createVertexArray();
  gl.bindVertexArray(own);
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffer);
  gl.bindVertexArray(current);
  gl.deleteVertexArray(own);
}

/**
 * Attributes for `pieces`, rows of { array, itemSize, normalized, isIndex }, null for each null. With a WebGL renderer their
 * bytes are uploaded before the promise resolves, at most `bytesPerFrame` in a frame; `isOver()` ends it early, and
 * then it resolves to null.
 */
export async function uploadAttributes(pieces, renderer, bytesPerFrame, isOver) {
  const gl = renderer?.isWebGLRenderer ? renderer.getContext() : null;
  const plain = () => pieces.map((piece) => piece && new BufferAttribute(piece.array, piece.itemSize, piece.normalized));
  if (!gl || gl.isContextLost()) return plain();
  const buffers = [];
  const size = pieces.reduce((sum, piece) => sum + (piece?.array.byteLength ?? 0), 0);
  let left = size > bytesPerFrame ? 0 : bytesPerFrame;  // what fits one frame comes at once
  for (const piece of pieces) {
    if (!piece) continue;
    const { array } = piece;
    // Bound where no vertex array object notices: the renderer keeps count of its own bindings.
    const buffer = gl.createBuffer();
    buffers.push(buffer);
    if (piece.isIndex) bindFirstAsIndex(gl, buffer);
    gl.bindBuffer(gl.COPY_WRITE_BUFFER, buffer);
    gl.bufferData(gl.COPY_WRITE_BUFFER, array.byteLength, gl.STATIC_DRAW);
    const bytes = new Uint8Array(array.buffer, array.byteOffset, array.byteLength);
    for (let start = 0; start < bytes.length;) {
      if (left === 0) {
        await cardIsIdle(gl, isOver);
        left = bytesPerFrame;
        if (isOver()) {
          for (const unused of buffers) gl.deleteBuffer(unused);
          return null;
        }
        if (gl.isContextLost()) return plain();
        gl.bindBuffer(gl.COPY_WRITE_BUFFER, buffer);
      }
      const size = Math.min(left, bytes.length - start);
      gl.bufferSubData(gl.COPY_WRITE_BUFFER, start, bytes, start, size);
      start += size;
      left -= size;
    }
    gl.bindBuffer(gl.COPY_WRITE_BUFFER, null);
  }
  return pieces.map((piece) => piece &&
    new UploadedAttribute(piece.array, piece.itemSize, piece.normalized, gl, buffers.shift()));
}
