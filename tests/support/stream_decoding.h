// SPDX-License-Identifier: Apache-2.0
// Decodes a whole stream through nmc.h and writes down all there is to see, for comparison.
#ifndef NMC_TESTS_SUPPORT_STREAM_DECODING_H_
#define NMC_TESTS_SUPPORT_STREAM_DECODING_H_

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <ostream>
#include <span>
#include <string>
#include <vector>

#include "libnmc/include/nmc/nmc.h"

namespace nmc::test {

struct DecodedLayer {
  std::uint32_t index = 0, level = 0;
  std::uint64_t end_offset = 0, state_hash = 0, position_hash = 0;
  std::vector<std::uint64_t> attribute_hashes = {};  // 0 for attributes that have not come
  bool operator==(const DecodedLayer&) const = default;
};

struct Decoding {
  nmc_status status = NMC_OK;  // of next(), or else of finish()
  nmc_error_detail error{};
  bool has_header = false, has_ended = false;
  std::vector<DecodedLayer> layers;
  std::uint64_t peak_memory = 0;

  bool operator==(const Decoding& other) const {
    return status == other.status && error.byte_offset == other.error.byte_offset &&
           error.chunk_type == other.error.chunk_type &&
           std::string(error.spec_section) == other.error.spec_section && has_header == other.has_header &&
           has_ended == other.has_ended && layers == other.layers;
  }
};

inline std::ostream& operator<<(std::ostream& out, const DecodedLayer& layer) {
  return out << "row " << layer.index << " level " << layer.level << " end " << layer.end_offset << std::hex
             << " state " << layer.state_hash << " positions " << layer.position_hash << std::dec
             << (layer.attribute_hashes.empty() ? "" : " and attributes");
}

inline std::ostream& operator<<(std::ostream& out, const Decoding& decoding) {
  out << nmc_status_name(decoding.status) << " at " << decoding.error.byte_offset << " section "
      << decoding.error.spec_section << " (" << decoding.error.message << ")"
      << (decoding.has_header ? " header" : "") << (decoding.has_ended ? " end" : "");
  for (const DecodedLayer& layer : decoding.layers) out << "\n    " << layer;
  return out;
}

/// Whether the mesh of `level` is one that a viewer may draw: indices in range, coordinates finite. Reads
/// everything that can be read.
inline bool mesh_is_sound(nmc_decoder* decoder, std::uint32_t level) {
  std::uint32_t vertex_count = 0, face_count = 0;
  if (nmc_decoder_mesh_size(decoder, level, &vertex_count, &face_count) != NMC_OK) return true;
  std::vector<std::uint32_t> indices(std::size_t{3} * face_count);
  std::vector<float> positions(std::size_t{3} * vertex_count), normals(positions.size());
  const nmc_status read[3] = {nmc_decoder_read_indices(decoder, level, indices.data(), indices.size()),
                              nmc_decoder_read_positions(decoder, level, positions.data(), 12, vertex_count),
                              nmc_decoder_read_normals(decoder, level, normals.data(), 12, vertex_count)};
  std::vector<std::uint8_t> colors(std::size_t{4} * vertex_count);
  std::vector<std::uint16_t> values(std::size_t{4} * vertex_count);
  const nmc_status colored = nmc_decoder_read_colors(decoder, level, colors.data(), 4, 4, vertex_count);
  if (colored == NMC_ERR_CORRUPT || colored == NMC_ERR_ARGUMENT) return false;
  nmc_attribute attribute{};
  for (std::uint32_t i = 0; nmc_decoder_attribute(decoder, i, &attribute) == NMC_OK; ++i) {
    if (nmc_decoder_read_attribute(decoder, i, level, values.data(), 8, vertex_count) != NMC_OK) continue;
    for (std::size_t v = 0; v < vertex_count; ++v) {
      for (std::size_t c = 0; c < attribute.component_count; ++c)
        if (values[4 * v + c] >> attribute.bit_count != 0) return false;
    }
  }
  for (const nmc_status status : read) {
    if (status == NMC_ERR_LIMIT || status == NMC_ERR_NO_MEMORY) return true;
    if (status != NMC_OK) return false;
  }
  const auto is_finite = [](float x) { return x - x == 0; };
  return std::all_of(indices.begin(), indices.end(), [&](std::uint32_t i) { return i < vertex_count; }) &&
         std::all_of(positions.begin(), positions.end(), is_finite) &&
         std::all_of(normals.begin(), normals.end(), is_finite);
}

/// The last complete row and the hashes of what it holds.
inline DecodedLayer current_row(nmc_decoder* decoder) {
  nmc_layer row{};
  DecodedLayer layer;
  nmc_decoder_current_layer(decoder, &row);
  layer.index = row.index;
  layer.level = row.level;
  layer.end_offset = row.end_offset;
  nmc_decoder_state_hash(decoder, &layer.state_hash);
  nmc_decoder_position_hash(decoder, row.level, &layer.position_hash);
  nmc_attribute attribute{};
  for (std::uint32_t i = 0; nmc_decoder_attribute(decoder, i, &attribute) == NMC_OK; ++i) {
    layer.attribute_hashes.push_back(0);
    nmc_decoder_attribute_hash(decoder, i, row.level, &layer.attribute_hashes.back());
  }
  return layer;
}

/// Works through all events that the bytes so far give.
inline nmc_status drain(nmc_decoder* decoder, Decoding& decoding, bool reads_meshes = true) {
  nmc_event event{};
  nmc_status status = NMC_OK;
  while ((status = nmc_decoder_next(decoder, &event)) == NMC_OK) {
    if (event == NMC_EVENT_HEADER) decoding.has_header = true;
    if (event == NMC_EVENT_END) decoding.has_ended = true;
    if (event != NMC_EVENT_LAYER || !reads_meshes) continue;
    decoding.layers.push_back(current_row(decoder));
  }
  return status;
}

/// Feeds `bytes` in pieces of the given sizes (the last size repeats) from copies of exactly that size, so
/// that an address sanitizer sees every read beyond a piece.
inline Decoding decode_with(nmc_decoder* decoder, std::span<const std::uint8_t> bytes,
                            const std::vector<std::size_t>& piece_sizes = {~std::size_t{0}}) {
  Decoding decoding;
  std::size_t position = 0, piece = 0;
  decoding.status = drain(decoder, decoding);
  while (decoding.status == NMC_NEED_MORE_INPUT && position < bytes.size()) {
    const std::size_t wanted = piece_sizes[std::min(piece++, piece_sizes.size() - 1)];
    const std::size_t size = std::min(wanted, bytes.size() - position);
    const auto copy = std::make_unique<std::uint8_t[]>(size);
    std::memcpy(copy.get(), bytes.data() + position, size);
    position += size;
    decoding.status = nmc_decoder_feed(decoder, copy.get(), size);
    if (decoding.status == NMC_OK) decoding.status = drain(decoder, decoding);
  }
  if (decoding.status == NMC_NEED_MORE_INPUT) decoding.status = nmc_decoder_finish(decoder);
  nmc_decoder_error(decoder, &decoding.error);
  nmc_decoder_memory(decoder, nullptr, &decoding.peak_memory);
  return decoding;
}

inline Decoding decode(std::span<const std::uint8_t> bytes,
                       const std::vector<std::size_t>& piece_sizes = {~std::size_t{0}},
                       const nmc_limits* limits = nullptr) {
  nmc_decoder* decoder = nullptr;
  Decoding decoding;
  decoding.status = nmc_decoder_create(&decoder, limits, nullptr);
  if (decoding.status != NMC_OK) return decoding;
  decoding = decode_with(decoder, bytes, piece_sizes);
  nmc_decoder_destroy(&decoder);
  return decoding;
}

}  // namespace nmc::test

#endif  // NMC_TESTS_SUPPORT_STREAM_DECODING_H_
