// SPDX-License-Identifier: Apache-2.0
import type { Mesh } from 'three';
import type { GLTFLoaderPlugin, GLTFParser } from 'three/addons/loaders/GLTFLoader.js';
import type { NmcError } from '../nmc-decoder.mjs';
import type { NMCGeometry, NMCLoader, NMCLoaderOptions } from './nmc-loader.mjs';

export const NMC_PROGRESSIVE_MESH: 'NMC_progressive_mesh';

export class NMCProgressiveMesh implements GLTFLoaderPlugin {
  constructor(parser: GLTFParser, settings?: {
    loader?: NMCLoader;
    options?: NMCLoaderOptions;
    onGeometry?: (geometry: NMCGeometry, mesh: Mesh) => void;
    onError?: (error: NmcError, mesh: Mesh) => void;
  });
  readonly name: string;
  afterRoot(root: unknown): Promise<void>;
}
