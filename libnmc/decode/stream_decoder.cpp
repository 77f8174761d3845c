// SPDX-License-Identifier: Apache-2.0
#include "libnmc/decode/stream_decoder.h"

#include "libnmc/common/byte_reader.h"
#include "libnmc/common/checksum.h"
#include "libnmc/decode/header_parser.h"
#include "libnmc/decode/range_decoder.h"

namespace nmc {

StreamDecoder::StreamDecoder(Memory* memory, const DecoderLimits& limits)
    : memory_(memory), limits_(limits), header_(memory), mesh_(memory, &header_), buffer_(memory) {}

Status StreamDecoder::feed(const std::uint8_t* data, std::size_t size) {
  if (at_end_ || size == 0) return ok_status();
  if (consumed_ > 0) {
    std::memmove(buffer_.data(), buffer_.data() + consumed_, buffer_.size() - consumed_);
    buffer_offset_ += consumed_;
    if (!buffer_.resize(buffer_.size() - consumed_)) return no_memory();
    consumed_ = 0;
  }
  const std::size_t old_size = buffer_.size();
  if (!buffer_.resize(old_size + size)) return no_memory();
  std::memcpy(buffer_.data() + old_size, data, size);
  return ok_status();
}

Status StreamDecoder::fail(Status status, std::uint64_t offset) {
  if (status.code == StatusCode::kNoMemory && memory_ && memory_->limit_reached()) {
    status = {StatusCode::kLimit, "8", "the limit on memory is reached"};
  }
  error_ = {offset, status};
  return status;
}

Status StreamDecoder::check_limits() const {
  if (header_.base_vertex_count > limits_.maximum_base_vertices || header_.level_count > limits_.maximum_levels) {
    return {StatusCode::kLimit, "8", "the stream is larger than the limits allow"};
  }
  return ok_status();
}

std::uint64_t StreamDecoder::level_vertex_count(int level) const {
  // Level 0: V, E <= 3 F. Each step adds E vertices and makes E' = 2 E + 3 F, F' = 4 F; 14 levels of 2^30 faces
  // stay below 2^60.
  std::uint64_t v = header_.base_vertex_count, f = header_.base_face_count;
  std::uint64_t e = mesh_.has_base() ? mesh_.topology(0).edge_count : 3 * f;
  for (int l = 0; l < level; ++l) {
    v += e;
    e = 2 * e + 3 * f;
    f *= 4;
  }
  return v;
}

Status StreamDecoder::check_level_size(int level) const {
  const std::uint64_t vertex_count = level_vertex_count(level);
  if (vertex_count > limits_.maximum_vertices) {
    return {StatusCode::kLimit, "8", "the level has more vertices than the limits allow"};
  }
  const std::uint64_t bytes = buffer_offset_ + buffer_.size();
  if (level > 0 && vertex_count > kFreeVertices + kVerticesPerByte * bytes) {
    return {StatusCode::kLimit, "8.2", "the level has more vertices than so few bytes may describe"};
  }
  return ok_status();
}

Status StreamDecoder::next(DecoderEvent& event) {
  event = DecoderEvent::kNeedMoreInput;
  if (!error_.status.ok()) return error_.status;
  if (at_end_) return ok_status();
  if (!has_header_) {
    std::size_t total_size = 0;
    const Status measured = measure_header(buffer_.data(), buffer_.size(), total_size);
    if (measured.code == StatusCode::kNeedMoreInput) return ok_status();
    if (!measured.ok()) return fail(measured, 0);
    if (buffer_.size() < total_size) return ok_status();
    const Status parsed = parse_header(buffer_.data(), total_size, header_);
    if (!parsed.ok()) return fail(parsed, 0);
    const Status limited = check_limits();
    if (!limited.ok()) return fail(limited, 0);
    consumed_ = total_size;
    has_header_ = true;
    layer_end_offset_ = total_size;
    layer_target_ = total_size + header_.layers[0].size;
    event = DecoderEvent::kHeader;
    return ok_status();
  }
  while (layers_complete_ < header_.layers.size()) {
    const std::uint64_t chunk_offset = buffer_offset_ + consumed_;
    const std::uint8_t* data = buffer_.data() + consumed_;
    const std::size_t size = buffer_.size() - consumed_;
    if (size == 0) return ok_status();
    ByteReader reader(data, size);
    const std::uint8_t type = reader.read_u8();
    const std::uint64_t payload_size = reader.read_varint();
    if (reader.overrun() && size < 11) return ok_status();
    if (reader.malformed() || reader.overrun()) {
      return fail(corrupt("2.2", "the size of a chunk is misspelt"), chunk_offset);
    }
    if (payload_size > limits_.maximum_chunk_size) {
      return fail({StatusCode::kLimit, "8", "a chunk is too large"}, chunk_offset);
    }
    const std::size_t chunk_size = reader.position() + static_cast<std::size_t>(payload_size) + 4;
    if (chunk_offset + chunk_size > layer_target_) {
      return fail(corrupt("3.3.5", "a chunk reaches beyond its layer"), chunk_offset);
    }
    if (size < chunk_size) return ok_status();
    ByteReader checksum(data + chunk_size - 4, 4);
    if (checksum.read_u32() != crc32c(data, chunk_size - 4)) {
      return fail({StatusCode::kChecksum, "3.2", "the checksum of a chunk is wrong"}, chunk_offset);
    }
    const Status decoded = decode_chunk(static_cast<ChunkType>(type), reader.current(),
                                        static_cast<std::size_t>(payload_size));
    if (!decoded.ok()) return fail(decoded, chunk_offset);
    consumed_ += chunk_size;
    if (buffer_offset_ + consumed_ < layer_target_) continue;
    if (!mesh_.has_base()) return fail(corrupt("4.3", "the first layer has no base mesh"), chunk_offset);
    layer_end_offset_ = layer_target_;
    ++layers_complete_;
    if (layers_complete_ < header_.layers.size()) layer_target_ += header_.layers[layers_complete_].size;
    event = DecoderEvent::kLayer;
    return ok_status();
  }
  at_end_ = true;
  event = DecoderEvent::kEnd;
  return ok_status();
}

Status StreamDecoder::finish() {
  if (!error_.status.ok()) return error_.status;
  if (at_end_ || (has_header_ && layers_complete_ == header_.layers.size())) return ok_status();
  return fail({StatusCode::kTruncated, "3.2", "the stream ends early"}, buffer_offset_ + buffer_.size());
}

Status StreamDecoder::decode_chunk(ChunkType type, const std::uint8_t* payload, std::size_t size) {
  switch (type) {
    case ChunkType::kBaseMesh: {
      // Every face costs well over 1/32 of a bit: an impossible count is refused before anything is allocated.
      if (header_.base_face_count > 2048 + 256 * static_cast<std::uint64_t>(size)) {
        return {StatusCode::kLimit, "8.2", "the base mesh has more faces than so few bytes may describe"};
      }
      RangeDecoder coder(payload, size);
      NMC_TRY(mesh_.code_base(coder, nullptr, nullptr, nullptr, nullptr, nullptr));
      NMC_CHECK_STREAM(!coder.overrun(), "5.1", "the base mesh needs more bytes than it has");
      return ok_status();
    }
    case ChunkType::kBaseCorrection: {
      NMC_CHECK_STREAM(size >= 1, "4.6", "the chunk is too short");
      RangeDecoder coder(payload + 1, size - 1);
      NMC_TRY(mesh_.code_base_correction(coder, payload[0], nullptr));
      NMC_CHECK_STREAM(!coder.overrun(), "5.1", "a chunk needs more bytes than it has");
      return ok_status();
    }
    case ChunkType::kGeometry: {
      NMC_CHECK_STREAM(size >= 3, "5.3", "the chunk is too short");
      const int layer = payload[0], first_level = payload[1], level_count = payload[2];
      NMC_CHECK_STREAM(level_count >= 1 && first_level + level_count <= header_.level_count, "5.3",
                       "a level that the header does not announce");
      RangeDecoder coder(payload + 3, size - 3);
      for (int level = first_level; level < first_level + level_count; ++level) {
        NMC_TRY(check_level_size(level + 1));
        NMC_TRY(mesh_.code_level(coder, layer, level, nullptr));
        NMC_CHECK_STREAM(!coder.overrun(), "5.1", "a chunk needs more bytes than it has");
      }
      return ok_status();
    }
    default:
      if (static_cast<std::uint8_t>(type) & kAncillaryBit) return ok_status();
      return {StatusCode::kFeature, "3.2", "the stream uses a feature that this decoder does not know"};
  }
}

Status StreamDecoder::update_positions(int level) {
  if (layers_complete_ == 0 || level < 0 || level > header_.level_count) {
    return {StatusCode::kState, nullptr, "the level is not there yet"};
  }
  NMC_TRY(check_level_size(level));
  return mesh_.update_positions(level);
}

Status StreamDecoder::update_topology(int level) {
  if (layers_complete_ == 0 || level < 0 || level > header_.level_count) {
    return {StatusCode::kState, nullptr, "the level is not there yet"};
  }
  NMC_TRY(check_level_size(level));
  return mesh_.ensure_topology(level, true);
}

}  // namespace nmc
