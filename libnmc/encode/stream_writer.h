// SPDX-License-Identifier: Apache-2.0
// Writes streams: integers in, bytes out (spec 3, 4). No decisions are taken here.
#ifndef NMC_ENCODE_STREAM_WRITER_H_
#define NMC_ENCODE_STREAM_WRITER_H_

#include <cstdint>

#include "libnmc/common/coded_mesh.h"
#include "libnmc/common/format.h"
#include "libnmc/common/memory.h"
#include "libnmc/common/status.h"

namespace nmc {

/// Builds the chunks of a stream one after the other; write_stream() then puts the header, whose table needs their
/// sizes, before them. The header's counts, steps and layers must be set before the first chunk.
///
///   StreamWriter writer(header);
///   writer.add_base(...); writer.add_levels(0, 0, 2, ...); writer.end_layer(level, rms, max);
///   writer.add_levels(0, 2, 1, ...);                       writer.end_layer(...);
///   writer.write_stream(bytes);
class StreamWriter {
 public:
  explicit StreamWriter(Header& header, Memory* memory = nullptr);

  /// The base mesh: `coordinates` on the grid of quality layer 0, 3 per vertex, and faces in the caller's numbering;
  /// `creases` one byte per edge of level 0 in the STREAM's numbering, or null. `old_index[i]` is the caller's number
  /// of the stream's vertex i; mesh() then has the stream's faces. The share of parallelograms in the prediction is
  /// found by trial.
  Status add_base(const std::uint32_t* face_vertices, const std::int32_t* coordinates, const std::uint8_t* creases,
                  Array<std::uint32_t>& old_index);
  /// Base coordinates of quality layer `layer`, in the stream's numbering.
  Status add_base_correction(int layer, const std::int32_t* coordinates);
  /// One chunk with levels [first_level, first_level + level_count) of quality layer `layer`. `levels[i]` belongs to
  /// level first_level + i.
  Status add_levels(int layer, int first_level, int level_count, const LevelCoefficients* const* levels);
  /// One chunk with the levels of the header's regions for one of these, of quality layer `layer`. `levels[i]` are those
  /// of the whole.
  Status add_region(int layer, int region, const LevelCoefficients* const* levels);
  /// One chunk with levels [first_level, first_level + level_count) of an attribute, level 0 standing for the base
  /// vertices. `corrections[i]`: component_count numbers for each vertex that level first_level + i adds.
  Status add_attribute(int attribute, int first_level, int level_count, const std::int32_t* const* corrections);
  /// An ancillary or foreign chunk, as it is.
  Status add_chunk(std::uint8_t type, const std::uint8_t* payload, std::size_t size);

  /// Ends a row of the layer table: the state to be shown at `level`. Errors may be set later in header().layers.
  /// `region` is that of the row's chunks, which then are of this region alone; -1: none.
  Status end_layer(int level, std::uint16_t rms_error, std::uint16_t max_error, int region = -1);

  /// What a decoder of the chunks so far holds.
  CodedMesh& mesh() { return mesh_; }
  const Array<std::uint8_t>& chunks() const { return chunks_; }

  /// Signature, header, chunks.
  Status write_stream(Array<std::uint8_t>& bytes) const;

 private:
  Memory* memory_;
  Header& header_;
  CodedMesh mesh_;
  Array<std::uint8_t> chunks_;
  std::size_t layer_start_ = 0;
};

/// Signature, version, header and checksum alone.
Status write_header(const Header& header, Array<std::uint8_t>& bytes);

/// Vertex order and faces that the stream's base mesh will have, before anything is coded: level 0 of the stream is
/// built from `new_faces`, and the caller's vertex old_index[i] is its vertex i.
Status order_base_mesh(const std::uint32_t* face_vertices, std::uint32_t face_count, std::uint32_t vertex_count,
                       Memory* memory, Array<std::uint32_t>& old_index, Array<std::uint32_t>& new_faces);

}  // namespace nmc

#endif  // NMC_ENCODE_STREAM_WRITER_H_
