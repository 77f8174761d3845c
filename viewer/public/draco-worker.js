// SPDX-License-Identifier: Apache-2.0
// Draco for GLTFLoader in a plain worker, without the blob that three.js's own loader makes: works under a strict
// Content-Security-Policy. In: { id, buffer, ids, types }; out: { id, attributes, index } or { id, error }.
importScripts('./draco/draco_wasm_wrapper.js');

let ready = null;
const decoderModule = () => {
  // The wrapper asks for a name that depends on its version; three.js ships the module under this one.
  ready ??= DracoDecoderModule({ locateFile: () => new URL('./draco/draco_decoder.wasm', location.href).href });
  return ready;
};

function decode(draco, bytes, ids, types) {
  const decoder = new draco.Decoder();
  const mesh = new draco.Mesh();
  const begin = performance.now();
  try {
    const status = decoder.DecodeArrayToMesh(bytes, bytes.byteLength, mesh);
    if (!status.ok()) throw new Error('Draco: ' + status.error_msg());
    const attributes = {};
    for (const name of Object.keys(ids)) {
      const attribute = decoder.GetAttributeByUniqueId(mesh, ids[name]);
      const itemSize = attribute.num_components();
      const Type = self[types[name]];
      const kind = { Float32Array: draco.DT_FLOAT32, Uint8Array: draco.DT_UINT8, Uint16Array: draco.DT_UINT16,
        Int8Array: draco.DT_INT8, Int16Array: draco.DT_INT16, Uint32Array: draco.DT_UINT32 }[types[name]];
      const size = mesh.num_points() * itemSize * Type.BYTES_PER_ELEMENT;
      const at = draco._malloc(size);
      decoder.GetAttributeDataArrayForAllPoints(mesh, attribute, kind, size, at);
      attributes[name] = { array: new Type(draco.HEAPF32.buffer, at, mesh.num_points() * itemSize).slice(), itemSize };
      draco._free(at);
    }
    const size = mesh.num_faces() * 12;
    const at = draco._malloc(size);
    decoder.GetTrianglesUInt32Array(mesh, size, at);
    const index = new Uint32Array(draco.HEAPF32.buffer, at, mesh.num_faces() * 3).slice();
    draco._free(at);
    return { attributes, index, milliseconds: performance.now() - begin };
  } finally {
    draco.destroy(mesh);
    draco.destroy(decoder);
  }
}

onmessage = async ({ data: { id, buffer, ids, types } }) => {
  try {
    const result = decode(await decoderModule(), new Int8Array(buffer), ids, types);
    const buffers = [result.index.buffer, ...Object.values(result.attributes).map(({ array }) => array.buffer)];
    postMessage({ id, ...result }, buffers);
  } catch (error) {
    postMessage({ id, error: error.message });
  }
};
