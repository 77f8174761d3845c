// SPDX-License-Identifier: Apache-2.0

export type NmcStatus =
  | 'NMC_ERR_NOT_NMC' | 'NMC_ERR_VERSION' | 'NMC_ERR_FEATURE' | 'NMC_ERR_CORRUPT' | 'NMC_ERR_CHECKSUM'
  | 'NMC_ERR_TRUNCATED' | 'NMC_ERR_LIMIT' | 'NMC_ERR_NO_MEMORY' | 'NMC_ERR_STOPPED' | 'NMC_ERR_ARGUMENT'
  | 'NMC_ERR_STATE'
  /** Of the transport: an answer that is none, a connection that cannot be taken up again, a file that was replaced. */
  | `HTTP_${number}` | 'NETWORK' | 'SOURCE_CHANGED';

export class NmcError extends Error {
  readonly code: NmcStatus;
  readonly byteOffset: number;
  readonly chunkType: number;
  readonly specSection: string;
}

export interface NmcLimits {
  /** Bytes; default 1 GiB. */
  maxMemory?: number;
  /** Default 25 million. */
  maxVertices?: number;
  maxBaseVertices?: number;
  maxLevels?: number;
}

/** Stop rules; several may be given, the first that is met counts. Lengths are in the units of the stream. */
export interface NmcStopRules {
  maxError?: number;
  rmsError?: number;
  maxTriangles?: number;
  maxBytes?: number;
  maxLevel?: number;
}

export interface NmcMeshOptions {
  normals?: boolean;
  colors?: boolean;
  positions?: 'f32' | 'f64';
}

export interface NmcOptions extends NmcStopRules, NmcMeshOptions {
  limits?: NmcLimits;
  signal?: AbortSignal;
}

export interface NmcDecodeOptions extends NmcOptions {
  allowPartial?: boolean;
  hashes?: boolean;
}

export interface NmcStreamOptions extends NmcOptions {
  fetch?: typeof fetch;
  /** Headers, credentials, priority and so on of every request. */
  requestInit?: RequestInit;
  /** How often in a row a broken connection is taken up again with Range; default 6. */
  retries?: number;
  /** Milliseconds before the first of them, doubled each time; default 400. */
  retryDelay?: number;
  /** Told before each of them. */
  onRetry?: (receivedBytes: number, problem: Error | null) => void;
}

export interface NmcHeader {
  readonly headerBytes: number;
  readonly streamBytes: number;
  readonly layerCount: number;
  readonly levelCount: number;
  readonly qualityLayerCount: number;
  readonly base: { vertexCount: number; triangleCount: number };
  readonly input: { vertexCount: number; triangleCount: number };
  readonly box: { min: number[]; max: number[] };
  readonly diagonal: number;
  readonly gridStep: number;
  readonly units: '' | 'mm' | 'cm' | 'm' | 'in' | 'ft' | 'km';
  readonly up: '' | 'y' | 'z';
  readonly hasCreases: boolean;
  readonly hasColors: boolean;
  /** Parts of the surface that can be fetched alone; 0: none. */
  readonly regionCount: number;
}

export interface NmcLayer {
  readonly index: number;
  readonly level: number;
  /** The first `bytes` bytes of the stream give this layer. */
  readonly bytes: number;
  readonly triangles: number;
  /** Whose bytes the row holds; undefined: needed by all. */
  readonly region?: number;
  readonly maxError?: number;
  readonly rmsError?: number;
}

export interface NmcMesh {
  header: NmcHeader;
  layer: NmcLayer;
  level: number;
  indices: Uint32Array;
  positions: Float32Array | Float64Array;
  normals?: Float32Array;
  /** Four per vertex: red, green, blue as sRGB, opacity. */
  colors?: Uint8Array;
  stateHash?: string;
  positionHash?: string;
  /** Set with allowPartial when the stream was cut off or damaged. */
  error?: NmcError;
}

export const supported: boolean;
export function ready(): Promise<WebAssembly.Module>;
export function decode(bytes: ArrayBuffer | ArrayBufferView, options?: NmcDecodeOptions): Promise<NmcMesh>;

export class NmcDecoder {
  static create(options?: { limits?: NmcLimits }): Promise<NmcDecoder>;
  private constructor();
  readonly header: NmcHeader | null;
  readonly layers: readonly NmcLayer[];
  readonly layer: NmcLayer | null;
  readonly peakMemory: number;
  feed(bytes: Uint8Array): void;
  next(): 'header' | 'layer' | 'end' | null;
  /** Leaves out the next row, one of a region, whose bytes are not fed. */
  skipLayer(): void;
  /** The region of each face of the base mesh. */
  readRegions(): Uint8Array;
  finish(): void;
  reset(): void;
  selectLayer(criterion: keyof NmcStopRules, value: number): { index: number; isMet: boolean };
  meshSize(level?: number): { vertexCount: number; triangleCount: number };
  readIndices(level?: number): Uint32Array;
  readPositions(level?: number): Float32Array;
  readPositionsDouble(level?: number): Float64Array;
  readNormals(level?: number): Float32Array;
  readColors(level?: number): Uint8Array | null;
  /** How each vertex was set off its prediction: length along the normal, and 1 where it also moved sideways. */
  readOffsets(level?: number): { normal: Float32Array; isOffNormal: Uint8Array };
  stateHash(): string;
  positionHash(level?: number): string;
  dispose(): void;
}

export type NmcSource =
  | string | URL | Response | ReadableStream<Uint8Array> | ArrayBuffer | ArrayBufferView
  | AsyncIterable<Uint8Array> | Iterable<Uint8Array>;

export class NmcStream extends EventTarget implements AsyncIterable<NmcLayer & { mesh(o?: NmcMeshOptions): NmcMesh }> {
  static open(source: NmcSource, options?: NmcStreamOptions): Promise<NmcStream>;
  private constructor();
  readonly header: NmcHeader;
  readonly layers: readonly NmcLayer[];
  readonly layer: NmcLayer;
  readonly isDone: boolean;
  readonly receivedBytes: number;
  readonly decoder: NmcDecoder;
  mesh(options?: NmcMeshOptions): NmcMesh;
  stateHash(): string;
  positionHash(): string;
  /** Holds before the next layer; ends the request of a URL where the server knows Range. */
  pause(): void;
  /** Goes on, with the rest of the file. */
  resume(): void;
  run(): Promise<NmcLayer>;
  dispose(): void;
  [Symbol.asyncIterator](): AsyncIterator<NmcLayer & { mesh(o?: NmcMeshOptions): NmcMesh }>;
}
