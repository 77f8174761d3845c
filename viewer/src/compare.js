// SPDX-License-Identifier: Apache-2.0
// Another file for the right pane: GLB, plain or with Draco or meshopt inside.
import { BufferAttribute, BufferGeometry, LinearSRGBColorSpace } from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';

/** What GLTFLoader wants of a Draco loader, over public/draco-worker.js. */
class DracoWorker {
  #worker = null;
  #count = 0;
  #waiting = new Map();
  decodeMilliseconds = 0;

  preload() {
    if (this.#worker) return this;
    this.#worker = new Worker(new URL('draco-worker.js', document.baseURI));
    this.#worker.onmessage = ({ data }) => {
      const { resolve, reject } = this.#waiting.get(data.id);
      this.#waiting.delete(data.id);
      if (data.error) reject(new Error(data.error));
      else resolve(data);
    };
    return this;
  }
  async decodeDracoFile(buffer, callback, ids, types, colorSpace = LinearSRGBColorSpace, onError = () => {}) {
    void colorSpace;
    try {
      this.preload();
      const id = ++this.#count;
      const names = Object.fromEntries(Object.entries(types).map(([name, type]) => [name, type.name ?? type]));
      const data = await new Promise((resolve, reject) => {
        this.#waiting.set(id, { resolve, reject });
        this.#worker.postMessage({ id, buffer, ids, types: names }, [buffer]);
      });
      this.decodeMilliseconds = data.milliseconds;
      const geometry = new BufferGeometry();
      geometry.setIndex(new BufferAttribute(data.index, 1));
      for (const [name, { array, itemSize }] of Object.entries(data.attributes)) {
        geometry.setAttribute(name, new BufferAttribute(array, itemSize));
      }
      callback(geometry);
    } catch (error) {
      onError(error);
    }
  }
  dispose() { this.#worker?.terminate(); }
}

/** Reads `pieces`, telling `onProgress(bytes)`, and resolves to { root, bytes, triangles, kind }. */
export async function readGlb(pieces, onProgress) {
  const parts = [];
  let size = 0;
  for await (const piece of pieces) {
    parts.push(piece.slice());
    size += piece.length;
    onProgress(size);
  }
  const bytes = new Uint8Array(await new Blob(parts).arrayBuffer());
  const draco = new DracoWorker();
  const loader = new GLTFLoader().setDRACOLoader(draco).setMeshoptDecoder(MeshoptDecoder);
  const gltf = await loader.parseAsync(bytes.buffer, '');
  const used = gltf.parser.json.extensionsUsed ?? [];
  draco.dispose();
  let triangles = 0;
  gltf.scene.updateMatrixWorld(true);
  gltf.scene.traverse(({ isMesh, geometry }) => {
    if (isMesh) triangles += (geometry.index ?? geometry.attributes.position).count / 3;
  });
  const kind = used.includes('KHR_draco_mesh_compression') ? 'Draco GLB'
    : used.some((name) => /meshopt/.test(name)) ? 'meshopt GLB' : 'GLB';
  return { root: gltf.scene, bytes: size, triangles, kind };
}
