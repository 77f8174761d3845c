// SPDX-License-Identifier: Apache-2.0
// The state machine of a decoder: bytes in, events out (spec 3, 4). The C API of nmc.h is a thin skin over
// it.
//
// It suspends only between layers: the chunks of a layer are checked as they arrive and decoded together when
// the last of them is there, so that what can be read is always the state of a whole row of the layer table,
// and a damaged byte anywhere in a layer leaves the layers before it as they are.
#ifndef NMC_DECODE_STREAM_DECODER_H_
#define NMC_DECODE_STREAM_DECODER_H_

#include <cstddef>
#include <cstdint>

#include "libnmc/common/coded_mesh.h"
#include "libnmc/common/format.h"
#include "libnmc/common/memory.h"
#include "libnmc/common/status.h"
#include "libnmc/common/stop_request.h"

namespace nmc {

struct DecoderLimits {
  std::uint32_t maximum_base_vertices = 1u << 20;
  std::uint64_t maximum_vertices = 100'000'000;
  std::uint32_t maximum_levels = kMaximumLevelCount;
  std::uint32_t maximum_chunk_size = kMaximumChunkSize;
  StopRequest stop;
  TaskRunner runner;
};

/// What next() has found. Order: kHeader once, then kLayer once for each row of the layer table, then kEnd
/// once.
enum class DecoderEvent { kNeedMoreInput, kHeader, kLayer, kEnd };

/// Where and why decoding failed.
struct DecoderError {
  std::uint64_t byte_offset = 0;  // of the header or chunk at fault
  std::uint8_t chunk_type = 0;    // of the chunk at fault; 0 when it is none
  Status status;
};

class StreamDecoder {
 public:
  StreamDecoder(Memory* memory, const DecoderLimits& limits);

  /// Appends bytes; any split of a stream gives the same events. Fails for want of memory, with nothing
  /// appended, and after an error.
  Status feed(const std::uint8_t* data, std::size_t size);

  /// The next event, or kNeedMoreInput. An error is final: the same status returns at every further call, and
  /// all layers that were complete stay readable (but see update_positions).
  Status next(DecoderEvent& event);

  /// Goes on behind the next row, which must be a region's and of which no byte may have been fed; else kState.
  Status skip_row();

  /// No more bytes will come: kTruncated when layers of the table are missing, kCorrupt when bytes follow
  /// them.
  Status finish();

  /// Threads for the work that can be shared; those of the limits until then.
  void set_task_runner(const TaskRunner& runner) { limits_.runner = runner; }

  bool has_header() const { return has_header_; }
  const Header& header() const { return header_; }
  std::uint64_t header_size() const { return header_size_; }
  /// Rows of the layer table that are complete; the mesh to show is that of row layers_complete() - 1.
  std::size_t layers_complete() const { return layers_complete_; }
  /// Bytes of the stream up to the end of the last complete layer.
  std::uint64_t layer_end_offset() const { return layer_end_offset_; }
  const CodedMesh& mesh() const { return mesh_; }

  /// Vertices and faces of `level`. Legal from the first kLayer event on, for every level of the header.
  /// kLimit when the level would hold more vertices than the limits or the bytes so far allow (spec 8.2).
  Status level_size(int level, std::uint32_t& vertex_count, std::uint32_t& face_count) const;
  /// Positions of the vertices of `level` in the state of the last complete layer, into mesh().positions().
  /// Legal as level_size. After an error inside a layer whose checksums were right the older state may be
  /// lost, and then this returns that error.
  Status update_positions(int level);
  /// Values of attribute `index` at the vertices of `level`, into mesh().attribute(index). Legal as
  /// level_size; kState while no value of it has come.
  Status update_attribute(int index, int level);
  /// Bytes of the chunks of attribute `index` so far.
  std::uint64_t attribute_size(int index) const { return attribute_size_[index]; }
  /// Three vertex indices per face of `level`, 3 * face_count in all. Legal as level_size.
  Status read_indices(int level, std::uint32_t* indices);

  /// The region of each base face. Legal as level_size; kState where there are none.
  Status read_regions(std::uint8_t* regions);

  const DecoderError& error() const { return error_; }

 private:
  Status fail(Status status, std::uint64_t offset, std::uint8_t chunk_type = 0);
  Status check_limits() const;
  /// Whether a stream of `bytes` bytes may hold that level (spec 8.2).
  Status check_level_size(int level, std::uint64_t bytes) const;
  /// Adds to the values decoded so far, before they are: that bounds the work per byte (spec 8.2).
  Status count_values(std::uint64_t count, std::uint64_t bytes);
  Status check_readable(int level) const;
  Status begin_stream(DecoderEvent& event);
  Status check_arrived_chunks(bool& layer_is_complete);
  Status decode_layer();
  void end_row();
  /// Rows that name a region hold chunks of that region alone (spec 3.3.5).
  bool is_in_its_row(std::uint8_t type, const std::uint8_t* payload, std::size_t size) const;
  Status decode_chunk(ChunkType type, const std::uint8_t* payload, std::size_t size,
                      std::uint64_t end_offset);
  std::uint64_t level_vertex_count(int level) const;

  Memory* memory_;
  DecoderLimits limits_;
  Header header_;
  CodedMesh mesh_;
  Array<std::uint8_t> buffer_;  // bytes from stream offset buffer_offset_ on
  std::size_t consumed_ = 0;    // bytes of buffer_ that are decoded
  std::size_t checked_ = 0;     // bytes of buffer_ in chunks whose framing and checksum are right
  std::uint64_t buffer_offset_ = 0;
  std::uint64_t header_size_ = 0;
  std::uint64_t layer_end_offset_ = 0;
  std::uint64_t value_count_ = 0;   // coefficients and attribute values of all layers
  std::uint64_t layer_target_ = 0;  // stream offset at which the next row of the table is complete
  std::uint64_t attribute_size_[kMaximumAttributeCount] = {};
  std::size_t layers_complete_ = 0;
  bool has_header_ = false, at_end_ = false;
  bool has_bytes_after_end_ = false, mesh_is_lost_ = false;
  DecoderError error_;
};

}  // namespace nmc

#endif  // NMC_DECODE_STREAM_DECODER_H_
