// SPDX-License-Identifier: Apache-2.0
// The library beside the reference decoder: both look at the same bytes and must say the same.
#ifndef NMC_TESTS_SUPPORT_REFERENCE_COMPARISON_H_
#define NMC_TESTS_SUPPORT_REFERENCE_COMPARISON_H_

#include <sstream>
#include <string>
#include <vector>

#include "decoder/reference/reference_decoder.h"
#include "tests/support/stream_decoding.h"

namespace nmc::test {

/// The limits of both decoders; the library's bound on memory has no counterpart.
inline nmc_reference::Limits reference_limits(const nmc_limits& limits) {
  nmc_reference::Limits result;
  result.base_vertices = limits.max_base_vertices;
  result.vertices = limits.max_vertices;
  result.levels = limits.max_levels;
  result.chunk_size = limits.max_chunk_size;
  return result;
}

/// The hash of spec 9.3 over the three vertices of each face of `level`; 0 where the level cannot be read.
inline std::uint64_t index_hash(nmc_decoder* decoder, std::uint32_t level) {
  std::uint32_t vertex_count = 0, face_count = 0;
  if (nmc_decoder_mesh_size(decoder, level, &vertex_count, &face_count) != NMC_OK) return 0;
  std::vector<std::uint32_t> indices(std::size_t{3} * face_count);
  if (nmc_decoder_read_indices(decoder, level, indices.data(), indices.size()) != NMC_OK) return 0;
  return nmc_reference::hash_of(indices);
}

/// Empty when library and reference agree about `bytes`; else what each of them says.
inline std::string difference(const std::vector<std::uint8_t>& bytes, const nmc_limits& limits) {
  const nmc_reference::Decoding reference = nmc_reference::decode(bytes, reference_limits(limits));
  nmc_decoder* decoder = nullptr;
  if (nmc_decoder_create(&decoder, &limits, nullptr) != NMC_OK) return "the library has no decoder";
  const Decoding library = decode_with(decoder, bytes);
  bool agrees = static_cast<int>(library.status) == static_cast<int>(reference.code) &&
                library.layers.size() == reference.rows.size();
  if (library.status != NMC_OK) {
    agrees = agrees && library.error.byte_offset == reference.offset &&
             reference.section == library.error.spec_section;
  }
  for (std::size_t i = 0; agrees && i < reference.rows.size(); ++i) {
    const nmc_reference::Row& row = reference.rows[i];
    agrees = library.layers[i].end_offset == row.end_offset && library.layers[i].level == row.level &&
             library.layers[i].state_hash == row.state_hash &&
             library.layers[i].position_hash == row.position_hash &&
             library.layers[i].attribute_hashes == row.attribute_hashes;
  }
  if (agrees && library.status == NMC_OK && !reference.rows.empty()) {
    agrees = index_hash(decoder, reference.rows.back().level) == reference.rows.back().index_hash;
  }
  nmc_decoder_destroy(&decoder);
  if (agrees) return {};
  std::ostringstream text;
  text << "library: " << library << "\nreference: " << nmc_reference::name_of(reference.code) << " at "
       << reference.offset << " section " << reference.section;
  for (const nmc_reference::Row& row : reference.rows) {
    text << "\n    level " << row.level << " end " << row.end_offset << std::hex << " state "
         << row.state_hash << " positions " << row.position_hash << " indices " << row.index_hash << std::dec;
  }
  return text.str();
}

}  // namespace nmc::test

#endif  // NMC_TESTS_SUPPORT_REFERENCE_COMPARISON_H_
