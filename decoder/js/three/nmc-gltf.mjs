// SPDX-License-Identifier: Apache-2.0
// Extension NMC_progressive_mesh for GLTFLoader: the primitive's plain mesh shows at once, and the stream that the
// file carries (or names) refines it. Schema: docs/NMC_progressive_mesh/ in nmc's source tree.
//
//   const nmc = new NMCLoader();
//   new GLTFLoader().register((parser) => new NMCProgressiveMesh(parser, { loader: nmc }));
import { NMCLoader } from './nmc-loader.mjs';

export const NMC_PROGRESSIVE_MESH = 'NMC_progressive_mesh';

export class NMCProgressiveMesh {
  /**
   * `loader`: an NMCLoader. `options`: those of its open(). `onGeometry(geometry, mesh)` is told of each refined one,
   * and `onError(error, mesh)` of a stream that failed: the plain mesh then stays.
   */
  constructor(parser, { loader = new NMCLoader(), options = {}, onGeometry, onError } = {}) {
    this.name = NMC_PROGRESSIVE_MESH;
    this.parser = parser;
    this.loader = loader;
    this.options = options;
    this.onGeometry = onGeometry;
    this.onError = onError;
  }

  /** GLTFLoader calls it once the whole scene graph stands. */
  async afterRoot(root) {
    const primitives = [];
    for (const scene of root.scenes) {
      scene.traverse((object) => {
        const { meshes, primitives: index = 0 } = this.parser.associations.get(object) ?? {};
        if (!object.isMesh || meshes === undefined) return;
        const extension = this.parser.json.meshes[meshes].primitives[index].extensions?.[NMC_PROGRESSIVE_MESH];
        if (extension) primitives.push({ object, extension });
      });
    }
    const geometries = new Map();  // a mesh that stands in several places is decoded once
    for (const { object, extension } of primitives) {
      if (!geometries.has(extension)) geometries.set(extension, this.#open(extension));
      geometries.get(extension).then((geometry) => {
        const plain = object.geometry;
        object.geometry = geometry;
        if (object.isSkinnedMesh !== true && geometry.attributes.color) this.#showColors(object);
        plain.dispose();
        this.onGeometry?.(geometry, object);
      }, (error) => this.onError?.(error, object));
    }
  }
  #showColors(object) {
    if (object.material.vertexColors) return;
    object.material = object.material.clone();
    object.material.vertexColors = true;
  }
  async #open({ bufferView, uri }) {
    if (uri !== undefined) return this.loader.open(new URL(uri, this.#base()).href, this.options);
    const bytes = await this.parser.getDependency('bufferView', bufferView);
    // The plain mesh is as good as the stream's first layers, so those need not be shown.
    return this.loader.open(bytes, this.options);
  }
  #base() {
    const here = globalThis.document?.baseURI ?? globalThis.location?.href;
    return new URL(this.parser.options.path || '.', here);
  }
}
