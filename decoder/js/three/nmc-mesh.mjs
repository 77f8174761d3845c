// SPDX-License-Identifier: Apache-2.0
// A mesh whose refinements grow out of what stood there before: a new vertex starts on the middle of its edge and
// moves to its place (H. Hoppe, Progressive Meshes, SIGGRAPH 1996, section 3.1: geomorphs).
import { Mesh } from 'three';

const MORPH = 'nmcMorph';

/** Teaches a material of three.js to draw the mesh between its start and its end. Once per material. */
export function enableMorph(material) {
  if (material.userData[MORPH]) return material;
  const uniform = { value: 1 };
  Object.defineProperty(material.userData, MORPH, { value: uniform, enumerable: false });
  const { onBeforeCompile, customProgramCacheKey } = material;
  const key = customProgramCacheKey.call(material);
  material.customProgramCacheKey = () => `${key}|${MORPH}`;
  material.onBeforeCompile = (shader, renderer) => {
    onBeforeCompile.call(material, shader, renderer);
    shader.uniforms[MORPH] = uniform;
    shader.vertexShader = shader.vertexShader
      .replace('#include <common>',
        `#include <common>\nuniform float ${MORPH};\nattribute vec3 nmcStart;\nattribute vec3 nmcStartNormal;`)
      .replace('#include <beginnormal_vertex>',
        `#include <beginnormal_vertex>\nobjectNormal = mix(nmcStartNormal, objectNormal, ${MORPH});`)
      .replace('#include <begin_vertex>',
        `#include <begin_vertex>\ntransformed = mix(nmcStart, transformed, ${MORPH});`);
  };
  material.needsUpdate = true;
  return material;
}

export class NMCMesh extends Mesh {
  /** `geometry` of NMCLoader; `duration` of a morph in milliseconds; levels of more `triangles` appear at once. */
  constructor(geometry, material, { duration = 220, triangles = 400000 } = {}) {
    super(geometry, material);
    geometry.enableMorph?.(triangles, duration);
    // The shape is the header's box from the first moment on.
    this.onBeforeRender = (renderer, scene, camera, drawn, used) => {
      const uniform = (used.userData[MORPH] ? used : enableMorph(used)).userData[MORPH];
      uniform.value = this.geometry.morphShare?.() ?? 1;
      used.uniformsNeedUpdate = true;
    };
    for (const each of Array.isArray(material) ? material : [material]) enableMorph(each);
  }
}
