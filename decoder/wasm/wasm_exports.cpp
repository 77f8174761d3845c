// SPDX-License-Identifier: Apache-2.0
// nmc.h for JavaScript: the same calls with numbers and addresses only. Structures become rows of doubles, 64-bit
// hashes two 32-bit words, events and errors one signed number. decoder/js/nmc-decoder.src.mjs is its only user.
#include <cstdint>
#include <cstdlib>

#include "libnmc/common/context_mixing.h"
#include "libnmc/include/nmc/nmc.h"

#define NMC_EXPORT(name) extern "C" __attribute__((export_name(#name)))

namespace {

void put_hash(std::uint64_t hash, std::uint32_t* words) {
  words[0] = static_cast<std::uint32_t>(hash);
  words[1] = static_cast<std::uint32_t>(hash >> 32);
}

}  // namespace

NMC_EXPORT(allocate) void* nmc_wasm_allocate(std::uint32_t size) { return std::malloc(size); }
NMC_EXPORT(release) void nmc_wasm_release(void* pointer) { std::free(pointer); }

/// Null when the limits leave no room for a decoder.
NMC_EXPORT(create) nmc_decoder* nmc_wasm_create(double max_memory, double max_vertices, double max_base_vertices,
                                                double max_levels) {
  nmc::fill_mixing_tables();
  nmc_limits limits = nmc_default_limits();
  if (max_memory > 0) limits.max_memory = static_cast<std::uint64_t>(max_memory);
  if (max_vertices > 0) limits.max_vertices = static_cast<std::uint64_t>(max_vertices);
  if (max_base_vertices > 0) limits.max_base_vertices = static_cast<std::uint32_t>(max_base_vertices);
  if (max_levels > 0) limits.max_levels = static_cast<std::uint32_t>(max_levels);
  nmc_decoder* decoder = nullptr;
  nmc_decoder_create(&decoder, &limits, nullptr);
  return decoder;
}
NMC_EXPORT(destroy) void nmc_wasm_destroy(nmc_decoder* decoder) { nmc_decoder_destroy(&decoder); }
NMC_EXPORT(reset) int nmc_wasm_reset(nmc_decoder* decoder) { return nmc_decoder_reset(decoder); }
NMC_EXPORT(feed) int nmc_wasm_feed(nmc_decoder* decoder, const void* data, std::uint32_t size) {
  return nmc_decoder_feed(decoder, data, size);
}
/// An event, 0 when more input is needed, or an error below zero.
NMC_EXPORT(next) int nmc_wasm_next(nmc_decoder* decoder) {
  nmc_event event = NMC_EVENT_END;
  const nmc_status status = nmc_decoder_next(decoder, &event);
  return status == NMC_OK ? static_cast<int>(event) : status == NMC_NEED_MORE_INPUT ? 0 : static_cast<int>(status);
}
NMC_EXPORT(finish) int nmc_wasm_finish(nmc_decoder* decoder) { return nmc_decoder_finish(decoder); }

/// Offset, chunk type, and the addresses of the section and the message, which end with a zero byte.
NMC_EXPORT(error) int nmc_wasm_error(const nmc_decoder* decoder, double* out) {
  nmc_error_detail detail;
  nmc_decoder_error(decoder, &detail);
  out[0] = static_cast<double>(detail.byte_offset);
  out[1] = detail.chunk_type;
  out[2] = static_cast<double>(reinterpret_cast<std::uintptr_t>(detail.spec_section));
  out[3] = static_cast<double>(reinterpret_cast<std::uintptr_t>(detail.message));
  return detail.status;
}
NMC_EXPORT(info) int nmc_wasm_info(const nmc_decoder* decoder, double* out) {
  nmc_info info;
  const nmc_status status = nmc_decoder_info(decoder, &info);
  if (status != NMC_OK) return status;
  const double fields[] = {static_cast<double>(info.header_size),
                           static_cast<double>(info.stream_size),
                           static_cast<double>(info.layer_count),
                           static_cast<double>(info.level_count),
                           static_cast<double>(info.quality_layer_count),
                           static_cast<double>(info.base_vertex_count),
                           static_cast<double>(info.base_face_count),
                           static_cast<double>(info.input_vertex_count),
                           static_cast<double>(info.input_triangle_count),
                           info.box_min[0],
                           info.box_min[1],
                           info.box_min[2],
                           info.box_max[0],
                           info.box_max[1],
                           info.box_max[2],
                           info.diagonal,
                           info.grid_step,
                           static_cast<double>(info.units),
                           static_cast<double>(info.up_axis),
                           static_cast<double>(info.has_creases),
                           static_cast<double>(info.has_colors),
                           static_cast<double>(info.region_count)};
  for (const double field : fields) *out++ = field;
  return NMC_OK;
}
NMC_EXPORT(layer) int nmc_wasm_layer(const nmc_decoder* decoder, std::uint32_t index, double* out) {
  nmc_layer layer;
  const nmc_status status = nmc_decoder_layer(decoder, index, &layer);
  if (status != NMC_OK) return status;
  out[0] = layer.level;
  out[1] = static_cast<double>(layer.end_offset);
  out[2] = static_cast<double>(layer.face_count);
  out[3] = layer.max_error;
  out[4] = layer.rms_error;
  out[5] = layer.has_error;
  out[6] = layer.region;
  return NMC_OK;
}
NMC_EXPORT(skipLayer) int nmc_wasm_skip_layer(nmc_decoder* decoder) { return nmc_decoder_skip_layer(decoder); }
NMC_EXPORT(readRegions) int nmc_wasm_read_regions(nmc_decoder* decoder, std::uint8_t* regions, std::uint32_t count) {
  return nmc_decoder_read_regions(decoder, regions, count);
}
NMC_EXPORT(selectLayer) int nmc_wasm_select_layer(const nmc_decoder* decoder, int criterion, double value,
                                                  std::uint32_t* index_and_met) {
  int is_met = 0;
  const nmc_status status =
      nmc_decoder_select_layer(decoder, static_cast<nmc_criterion>(criterion), value, index_and_met, &is_met);
  index_and_met[1] = static_cast<std::uint32_t>(is_met);
  return status;
}
NMC_EXPORT(meshSize) int nmc_wasm_mesh_size(const nmc_decoder* decoder, std::uint32_t level, std::uint32_t* counts) {
  return nmc_decoder_mesh_size(decoder, level, counts, counts + 1);
}
NMC_EXPORT(readIndices) int nmc_wasm_read_indices(nmc_decoder* decoder, std::uint32_t level, std::uint32_t* indices,
                                                  std::uint32_t count) {
  return nmc_decoder_read_indices(decoder, level, indices, count);
}
NMC_EXPORT(readPositions) int nmc_wasm_read_positions(nmc_decoder* decoder, std::uint32_t level, float* positions,
                                                      std::uint32_t vertex_count) {
  return nmc_decoder_read_positions(decoder, level, positions, 3 * sizeof(float), vertex_count);
}
NMC_EXPORT(readPositionsDouble) int nmc_wasm_read_positions_double(nmc_decoder* decoder, std::uint32_t level,
                                                                   double* positions, std::uint32_t vertex_count) {
  return nmc_decoder_read_positions_double(decoder, level, positions, 3 * sizeof(double), vertex_count);
}
NMC_EXPORT(readNormals) int nmc_wasm_read_normals(nmc_decoder* decoder, std::uint32_t level, float* normals,
                                                  std::uint32_t vertex_count) {
  return nmc_decoder_read_normals(decoder, level, normals, 3 * sizeof(float), vertex_count);
}
NMC_EXPORT(readColors) int nmc_wasm_read_colors(nmc_decoder* decoder, std::uint32_t level, std::uint8_t* colors,
                                                std::uint32_t vertex_count) {
  return nmc_decoder_read_colors(decoder, level, colors, 4, 4, vertex_count);
}
NMC_EXPORT(readOffsets) int nmc_wasm_read_offsets(nmc_decoder* decoder, std::uint32_t level, float* normal_offsets,
                                                  std::uint8_t* is_off_normal, std::uint32_t vertex_count) {
  return nmc_decoder_read_offsets(decoder, level, normal_offsets, is_off_normal, vertex_count);
}
NMC_EXPORT(stateHash) int nmc_wasm_state_hash(const nmc_decoder* decoder, std::uint32_t* words) {
  std::uint64_t hash = 0;
  const nmc_status status = nmc_decoder_state_hash(decoder, &hash);
  put_hash(hash, words);
  return status;
}
NMC_EXPORT(positionHash) int nmc_wasm_position_hash(nmc_decoder* decoder, std::uint32_t level, std::uint32_t* words) {
  std::uint64_t hash = 0;
  const nmc_status status = nmc_decoder_position_hash(decoder, level, &hash);
  put_hash(hash, words);
  return status;
}
NMC_EXPORT(memoryPeak) double nmc_wasm_memory_peak(const nmc_decoder* decoder) {
  std::uint64_t peak = 0;
  nmc_decoder_memory(decoder, nullptr, &peak);
  return static_cast<double>(peak);
}
