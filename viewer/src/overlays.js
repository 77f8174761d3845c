// SPDX-License-Identifier: Apache-2.0
// Colours and lines over a progressive mesh. Vertices keep their numbers from level to level and the four children of
// a face stand together, so everything here follows from the indices of the level shown.
import { BufferAttribute } from 'three';

/** Lines beyond so many triangles are closer than pixels: a coarser level is drawn instead. */
const MOST_WIRE_TRIANGLES = 120000;

/** Indices of the next coarser level. */
function coarser(indices) {
  const coarse = new Uint32Array(indices.length / 4);
  for (let i = 0, j = 0; i < indices.length; i += 12, j += 3) {
    coarse[j] = indices[i];
    coarse[j + 1] = indices[i + 4];
    coarse[j + 2] = indices[i + 8];
  }
  return coarse;
}

/** Pairs of vertices: the edges of the finest level that is worth drawing. */
export function wireIndices(geometry) {
  let indices = geometry.index.array;
  for (let { level } = geometry.layer; level > 0 && indices.length > 3 * MOST_WIRE_TRIANGLES; --level) {
    indices = coarser(indices);
  }
  const lines = new Uint32Array(2 * indices.length);
  let count = 0;
  for (let i = 0; i < indices.length; i += 3) {
    for (let k = 0; k < 3; ++k) {
      const a = indices[i + k];
      const b = indices[i + ((k + 1) % 3)];
      if (a > b) continue;  // the face on the other side draws it; boundaries are drawn by chance only
      lines[count++] = a;
      lines[count++] = b;
    }
  }
  return new BufferAttribute(lines.slice(0, count), 1);
}

/**
 * Pairs of vertices: the edges of the base mesh as they run over the surface. Side k of a face lies on the sides k of
 * its children j != k (spec 6.1), so the faces along it have no digit k in base 4.
 */
export function baseIndices(geometry) {
  const indices = geometry.index.array;
  const { level } = geometry.layer;
  const perBase = 4 ** level;
  const lines = [];
  for (let k = 0; k < 3; ++k) {
    let along = [0];
    for (let l = 0; l < level; ++l) along = along.flatMap((face) => [0, 1, 2].filter((j) => j !== k).map((j) => 4 * face + j));
    for (let first = 0; 3 * first < indices.length; first += perBase) {
      for (const face of along) {
        const at = 3 * (first + face);
        lines.push(indices[at + ((k + 1) % 3)], indices[at + ((k + 2) % 3)]);
      }
    }
  }
  return new BufferAttribute(new Uint32Array(lines), 1);
}

const ramp = (stops) => {
  const table = new Uint8Array(3 * 256);
  for (let i = 0; i < 256; ++i) {
    const x = (i / 255) * (stops.length - 1);
    const at = Math.min(Math.floor(x), stops.length - 2);
    for (let k = 0; k < 3; ++k) {
      const value = ((stops[at][k] * (1 - x + at) + stops[at + 1][k] * (x - at)) / 255);
      table[3 * i + k] = Math.round(255 * (value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4));
    }
  }
  return table;
};
const hex = (text) => text.split(' ').map((c) => [1, 3, 5].map((i) => parseInt(c.slice(i, i + 2), 16)));
const RAMPS = {
  heat: ramp(hex('#30123b #4686fb #1ae4b6 #a4fc3c #fb7e21 #7a0403')),   // Turbo, A. Mikhailov
  signed: ramp(hex('#2166ac #92c5de #f7f7f7 #f4a582 #b2182b')),         // ColorBrewer RdBu
  levels: ramp(hex('#440154 #3b528b #21918c #5ec962 #fde725')),         // viridis
};

/** Four bytes per vertex, linear, from a number in 0 ... 1 per vertex. */
export function coloursOf(count, table, share) {
  const bytes = new Uint8Array(4 * count);
  for (let v = 0; v < count; ++v) {
    const at = 3 * Math.max(0, Math.min(255, Math.round(255 * share(v))));
    bytes[4 * v] = table[at];
    bytes[4 * v + 1] = table[at + 1];
    bytes[4 * v + 2] = table[at + 2];
    bytes[4 * v + 3] = 255;
  }
  return new BufferAttribute(bytes, 4, true);
}

/** By the level at which a vertex came: coarse ones dark. */
export function levelColours(geometry) {
  const count = geometry.attributes.position.count;
  const last = Math.max(1, geometry.layer.level);
  const bounds = [];
  for (let l = 0; l <= geometry.layer.level; ++l) {
    bounds.push(geometry.levels[l]?.vertexCount ?? Infinity);
  }
  let level = 0;
  return coloursOf(count, RAMPS.levels, (v) => {
    if (v === 0) level = 0;
    while (level < last && v >= bounds[level]) ++level;
    return level / last;
  });
}

/** Signed length of the normal offsets, by a scale that `largest` gives: small ones stay visible. */
export function offsetColours({ normal }) {
  const sample = Float32Array.from({ length: Math.min(normal.length, 20000) },
    (_, i) => Math.abs(normal[Math.floor((i * normal.length) / Math.min(normal.length, 20000))])).sort();
  const largest = sample[Math.floor(0.97 * (sample.length - 1))] || sample.at(-1) || 1;
  return {
    largest,
    attribute: coloursOf(normal.length, RAMPS.signed,
      (v) => 0.5 + 0.5 * Math.sign(normal[v]) * Math.sqrt(Math.min(1, Math.abs(normal[v]) / largest))),
  };
}

/** Red where a vertex also moved sideways. */
export function offNormalColours({ isOffNormal }) {
  let count = 0;
  const bytes = new Uint8Array(4 * isOffNormal.length);
  for (let v = 0; v < isOffNormal.length; ++v) {
    const colour = isOffNormal[v] ? [255, 28, 28] : [104, 114, 128];
    count += isOffNormal[v];
    bytes.set(colour, 4 * v);
    bytes[4 * v + 3] = 255;
  }
  return { count, attribute: new BufferAttribute(bytes, 4, true) };
}

export function heatColours(distances, largest) {
  return coloursOf(distances.length, RAMPS.heat, (v) => distances[v] / largest);
}
