// SPDX-License-Identifier: Apache-2.0
// The state machine of a decoder: bytes in, events out (spec 3, 4). The C API of nmc.h is a thin skin over it.
//
// It suspends only between chunks: what is inside a chunk is parsed by plain code over a whole buffer.
#ifndef NMC_DECODE_STREAM_DECODER_H_
#define NMC_DECODE_STREAM_DECODER_H_

#include <cstddef>
#include <cstdint>

#include "libnmc/common/coded_mesh.h"
#include "libnmc/common/format.h"
#include "libnmc/common/memory.h"
#include "libnmc/common/status.h"

namespace nmc {

struct DecoderLimits {
  std::uint32_t maximum_base_vertices = 1u << 20;
  std::uint64_t maximum_vertices = 100'000'000;
  int maximum_levels = kMaximumLevelCount;
  std::uint32_t maximum_chunk_size = kMaximumChunkSize;
};

/// What next() has found. Order: kHeader once, then kLayer once for each row of the layer table, then kEnd once.
enum class DecoderEvent { kNeedMoreInput, kHeader, kLayer, kEnd };

/// Where and why decoding failed.
struct DecoderError {
  std::uint64_t byte_offset = 0;  // of the chunk or header field at fault
  Status status;
};

class StreamDecoder {
 public:
  StreamDecoder(Memory* memory, const DecoderLimits& limits);

  /// Appends bytes; any split of a stream gives the same events. Fails only for want of memory.
  Status feed(const std::uint8_t* data, std::size_t size);

  /// The next event, or kNeedMoreInput. An error is final: the same status returns at every further call, and all
  /// layers that were complete stay readable.
  Status next(DecoderEvent& event);

  /// No more bytes will come: kTruncated when layers of the table are missing.
  Status finish();

  const Header& header() const { return header_; }
  /// Rows of the layer table that are complete; the mesh to show is that of row layers_complete() - 1.
  std::size_t layers_complete() const { return layers_complete_; }
  /// Bytes of the stream up to the end of the last complete layer.
  std::uint64_t layer_end_offset() const { return layer_end_offset_; }
  const CodedMesh& mesh() const { return mesh_; }

  /// Positions of the vertices of `level` in the state of the last complete layer, into the decoder's own array.
  /// Legal from the first kLayer event on, for every level of the header. kLimit when the level would hold more
  /// vertices than the limits or the bytes so far allow (spec 8.2).
  Status update_positions(int level);
  /// Connectivity of `level`, as above.
  Status update_topology(int level);

  const DecoderError& error() const { return error_; }

 private:
  Status fail(Status status, std::uint64_t offset);
  Status check_limits() const;
  Status check_level_size(int level) const;
  Status decode_chunk(ChunkType type, const std::uint8_t* payload, std::size_t size);
  std::uint64_t level_vertex_count(int level) const;

  Memory* memory_;
  DecoderLimits limits_;
  Header header_;
  CodedMesh mesh_;
  Array<std::uint8_t> buffer_;           // bytes not yet consumed start at buffer_[consumed_]
  std::size_t consumed_ = 0;
  std::uint64_t buffer_offset_ = 0;      // stream offset of buffer_[0]
  std::uint64_t layer_end_offset_ = 0;
  std::uint64_t layer_target_ = 0;       // stream offset at which the next row of the table is complete
  std::size_t layers_complete_ = 0;
  bool has_header_ = false, at_end_ = false;
  DecoderError error_;
};

}  // namespace nmc

#endif  // NMC_DECODE_STREAM_DECODER_H_
