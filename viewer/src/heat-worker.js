// SPDX-License-Identifier: Apache-2.0
// Distances of vertices to an original mesh, by a bounding volume hierarchy over its triangles.
// In: { type: 'original', buffer } (a PLY file), then { type: 'measure', request, positions }.
// Out: { type: 'original', triangles } or { type: 'error', message }; { type: 'distances', request, distances, ... }.
import { BufferAttribute, Vector3 } from 'three';
import { PLYLoader } from 'three/addons/loaders/PLYLoader.js';
import { MeshBVH } from 'three-mesh-bvh';

let hierarchy = null;

function begin(buffer) {
  const geometry = new PLYLoader().parse(buffer);
  const { position } = geometry.attributes;
  if (!position || position.count < 3) throw new Error('the PLY file has no triangles');
  if (!geometry.index) {
    geometry.setIndex(new BufferAttribute(Uint32Array.from({ length: position.count }, (_, i) => i), 1));
  }
  for (const name of Object.keys(geometry.attributes)) if (name !== 'position') geometry.deleteAttribute(name);
  hierarchy = new MeshBVH(geometry, { maxLeafSize: 8 });
  return geometry.index.count / 3;
}

function measure(positions) {
  const distances = new Float32Array(positions.length / 3);
  const point = new Vector3();
  const hit = {};
  let sum = 0;
  let largest = 0;
  for (let v = 0; v < distances.length; ++v) {
    point.fromArray(positions, 3 * v);
    const { distance } = hierarchy.closestPointToPoint(point, hit);
    distances[v] = distance;
    sum += distance * distance;
    largest = Math.max(largest, distance);
  }
  return { distances, rms: Math.sqrt(sum / distances.length), largest };
}

onmessage = ({ data }) => {
  try {
    if (data.type === 'original') {
      postMessage({ type: 'original', triangles: begin(data.buffer) });
    } else {
      const result = measure(data.positions);
      postMessage({ type: 'distances', request: data.request, ...result }, [result.distances.buffer]);
    }
  } catch (error) {
    postMessage({ type: 'error', request: data.request, message: error.message });
  }
};
