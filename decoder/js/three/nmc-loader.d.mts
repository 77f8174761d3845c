// SPDX-License-Identifier: Apache-2.0
import type {
  BufferGeometry, BufferGeometryEventMap, Camera, Loader, LoadingManager, Material, Mesh, Object3D, WebGLRenderer,
} from 'three';
import { NmcError } from '../nmc-decoder.mjs';
import type { NmcHeader, NmcLayer, NmcLimits, NmcSource, NmcStopRules, NmcStreamOptions } from '../nmc-decoder.mjs';

export { NmcError };

export interface NMCGoal {
  /** In model units. */
  maxError?: number;
  /** Index of a layer. */
  layer?: number;
  /** On the screen; with camera, viewportHeight (in pixels) and object, the mesh that shows the geometry. */
  pixels?: number;
  camera?: Camera;
  viewportHeight?: number;
  object?: Object3D;
}

export interface NMCLoaderOptions extends NmcStopRules {
  /** Bytes on this side, the card and in the decoder together, about: 150 per triangle. */
  maxMemory?: number;
  limits?: NmcLimits;
  /** Where to hold at first. */
  goal?: { maxError?: number; maxLayer?: number };
  /** false: the geometry has none. */
  normals?: boolean;
  colors?: boolean;
  signal?: AbortSignal;
  fetch?: typeof fetch;
  retries?: number;
  retryDelay?: number;
  /** Default 2 MiB. Needs setRenderer(). */
  uploadBytesPerFrame?: number;
  /** The worker keeps the stream after its end, for readOffsets(). */
  keepDecoder?: boolean;
  onProgress?: (loaded: number, total: number) => void;
}

export interface NMCGeometryEventMap extends BufferGeometryEventMap {
  progress: { loaded: number; total: number };
  retry: { loaded: number; reason: string };
  layer: { layer: NmcLayer };
  hold: { layer: NmcLayer };
  complete: { layer: NmcLayer };
  error: { error: NmcError };
}

export class NMCGeometry extends BufferGeometry<any, NMCGeometryEventMap> {
  readonly isNMCGeometry: true;
  readonly header: NmcHeader;
  readonly layers: readonly NmcLayer[];
  readonly levels: readonly ({ vertexCount: number; triangleCount: number } | null)[];
  /** The layer in place. */
  readonly layer: NmcLayer;
  readonly receivedBytes: number;
  readonly isComplete: boolean;
  readonly error: NmcError | null;
  readonly stateHash: string;
  readonly positionHash: string;
  readonly finished: Promise<this>;
  readonly isMorphing: boolean;
  refineTo(goal: NMCGoal): Promise<NmcLayer>;
  /** Reads no more; ends the request of a URL where the server knows Range. */
  pause(): void;
  resume(): void;
  readOffsets(): Promise<{ normal: Float32Array; isOffNormal: Uint8Array }>;
  enableMorph(triangles: number, duration: number): void;
  morphShare(now?: number): number;
}

export class NMCMesh extends Mesh<BufferGeometry, Material | Material[]> {
  constructor(geometry: BufferGeometry, material: Material | Material[],
    settings?: { duration?: number; triangles?: number });
}

export function enableMorph<M extends Material>(material: M): M;
export function lengthOfPixels(pixels: number, view: {
  camera: Camera; viewportHeight: number; object?: Object3D; geometry: BufferGeometry;
}): number;

export class NMCLoader extends Loader<NMCGeometry> {
  constructor(manager?: LoadingManager);
  readonly workerCount: number;
  setRenderer(renderer: WebGLRenderer): this;
  setWorkerLimit(limit: number): this;
  setWorkerFactory(create: () => Worker): this;
  setOptions(options: NMCLoaderOptions): this;
  preload(): this;
  open(source: NmcSource, options?: NMCLoaderOptions): Promise<NMCGeometry>;
  parse(buffer: ArrayBuffer | ArrayBufferView, onLoad: (geometry: NMCGeometry) => void,
    onError?: (error: NmcError) => void): void;
  parseAsync(buffer: ArrayBuffer | ArrayBufferView, options?: NMCLoaderOptions): Promise<NMCGeometry>;
  dispose(): this;
}
