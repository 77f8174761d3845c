// SPDX-License-Identifier: Apache-2.0
#include "libnmc/decode/stream_decoder.h"

#include <cstring>

#include "libnmc/common/byte_reader.h"
#include "libnmc/common/checksum.h"
#include "libnmc/decode/header_parser.h"
#include "libnmc/decode/range_decoder.h"

namespace nmc {

// In coefficient_decoder.cpp.
extern template Status CoefficientModel::code_level<RangeDecoder>(RangeDecoder&, Memory*, int,
                                                                  const LevelTopology*, const LevelTopology&,
                                                                  const std::int32_t*,
                                                                  const LevelCoefficients*,
                                                                  LevelCoefficients&, const std::uint32_t*);

namespace {

constexpr std::size_t kChecksumSize = 4;
constexpr std::size_t kLargestChunkHead = 11;  // type and a varint of at most ten bytes

struct ChunkFrame {
  std::uint8_t type = 0;
  std::uint64_t payload_size = 0;
  std::size_t head_size = 0;
};

/// Type and size of the chunk at `data`; kNeedMoreInput when they have not all arrived.
Status read_chunk_frame(const std::uint8_t* data, std::size_t size, ChunkFrame& frame) {
  ByteReader reader(data, size);
  frame.type = reader.read_u8();
  frame.payload_size = reader.read_varint();
  frame.head_size = reader.position();
  if (reader.overrun() && size < kLargestChunkHead) return NMC_ERROR(kNeedMoreInput, nullptr, nullptr);
  NMC_CHECK_STREAM(!reader.malformed() && !reader.overrun(), "2.2", "the size of a chunk is misspelt");
  return ok_status();
}

}  // namespace

StreamDecoder::StreamDecoder(Memory* memory, const DecoderLimits& limits)
    : memory_(memory), limits_(limits), header_(memory), mesh_(memory, &header_), buffer_(memory) {}

Status StreamDecoder::feed(const std::uint8_t* data, std::size_t size) {
  if (!error_.status.ok()) return error_.status;
  if (size == 0) return ok_status();
  if (at_end_) {
    has_bytes_after_end_ = true;
    return ok_status();
  }
  if (consumed_ > 0) {
    std::memmove(buffer_.data(), buffer_.data() + consumed_, buffer_.size() - consumed_);
    buffer_offset_ += consumed_;
    checked_ -= consumed_;
    buffer_.truncate(buffer_.size() - consumed_);
    consumed_ = 0;
  }
  if (!buffer_.append(data, size)) {
    if (memory_ && memory_->limit_reached())
      return NMC_ERROR(kLimit, "8", "the limit on memory is reached");
    return no_memory();
  }
  return ok_status();
}

Status StreamDecoder::fail(Status status, std::uint64_t offset, std::uint8_t chunk_type) {
  if (status.code() == StatusCode::kNoMemory && memory_ && memory_->limit_reached()) {
    status = NMC_ERROR(kLimit, "8", "the limit on memory is reached");
  }
  error_ = {offset, chunk_type, status};
  return status;
}

Status StreamDecoder::check_limits() const {
  if (header_.base_vertex_count > limits_.maximum_base_vertices ||
      static_cast<std::uint32_t>(header_.level_count) > limits_.maximum_levels ||
      header_.base_vertex_count > limits_.maximum_vertices) {
    return NMC_ERROR(kLimit, "8", "the stream is larger than the limits allow");
  }
  return ok_status();
}

std::uint64_t StreamDecoder::level_vertex_count(int level) const {
  // Each step adds E vertices and makes E' = 2 E + 3 F, F' = 4 F; 14 levels of 2^30 faces stay below 2^60.
  std::uint64_t v = header_.base_vertex_count, f = header_.base_face_count;
  std::uint64_t e = mesh_.has_base() ? mesh_.topology(0).edge_count : 3 * f;
  for (int l = 0; l < level; ++l) {
    v += e;
    e = 2 * e + 3 * f;
    f *= 4;
  }
  return v;
}

Status StreamDecoder::check_level_size(int level, std::uint64_t bytes) const {
  const std::uint64_t vertex_count = level_vertex_count(level);
  if (vertex_count > limits_.maximum_vertices || vertex_count > kMaximumVertexCount) {
    return NMC_ERROR(kLimit, "8", "the level has more vertices than the limits allow");
  }
  if (level > 0 && vertex_count > kFreeVertices + kVerticesPerByte * bytes) {
    return NMC_ERROR(kLimit, "8.2", "the level has more vertices than so few bytes may describe");
  }
  return ok_status();
}

Status StreamDecoder::count_values(std::uint64_t count, std::uint64_t bytes) {
  value_count_ += count;
  if (value_count_ > kFreeValues + kValuesPerByte * bytes) {
    return NMC_ERROR(kLimit, "8.2", "the stream has more values than so few bytes may describe");
  }
  return ok_status();
}

Status StreamDecoder::next(DecoderEvent& event) {
  event = DecoderEvent::kNeedMoreInput;
  if (!error_.status.ok()) return error_.status;
  if (at_end_) return ok_status();
  if (!has_header_) return begin_stream(event);
  if (layers_complete_ < header_.layers.size()) {
    bool layer_is_complete = false;
    NMC_TRY(check_arrived_chunks(layer_is_complete));
    if (!layer_is_complete) return ok_status();
    NMC_TRY(decode_layer());
    end_row();
    event = DecoderEvent::kLayer;
    return ok_status();
  }
  at_end_ = true;
  has_bytes_after_end_ = consumed_ < buffer_.size();
  buffer_.release();
  consumed_ = checked_ = 0;
  buffer_offset_ = layer_end_offset_;
  event = DecoderEvent::kEnd;
  return ok_status();
}

void StreamDecoder::end_row() {
  layer_end_offset_ = layer_target_;
  ++layers_complete_;
  if (layers_complete_ < header_.layers.size()) layer_target_ += header_.layers[layers_complete_].size;
}

NMC_SELDOM Status StreamDecoder::skip_row() {
  if (!error_.status.ok()) return error_.status;
  if (layers_complete_ == header_.layers.size() || header_.layers[layers_complete_].region == 0 ||
      consumed_ < buffer_.size()) {
    return NMC_ERROR(kState, nullptr, "the next row cannot be left out");
  }
  buffer_.clear();
  consumed_ = checked_ = 0;
  buffer_offset_ = layer_target_;
  end_row();
  return ok_status();
}

NMC_SELDOM Status StreamDecoder::begin_stream(DecoderEvent& event) {
  std::size_t total_size = 0;
  const Status measured = measure_header(buffer_.data(), buffer_.size(), total_size);
  if (measured.code() == StatusCode::kNeedMoreInput) return ok_status();
  if (!measured.ok()) return fail(measured, 0);
  if (buffer_.size() < total_size) return ok_status();
  const Status parsed = parse_header(buffer_.data(), total_size, header_);
  if (!parsed.ok()) return fail(parsed, 0);
  has_header_ = true;
  header_size_ = layer_end_offset_ = total_size;
  consumed_ = checked_ = total_size;
  layer_target_ = total_size + header_.layers[0].size;
  const Status limited = check_limits();
  if (!limited.ok()) return fail(limited, 0);
  event = DecoderEvent::kHeader;
  return ok_status();
}

Status StreamDecoder::check_arrived_chunks(bool& layer_is_complete) {
  while (buffer_offset_ + checked_ < layer_target_) {
    const std::uint64_t offset = buffer_offset_ + checked_;
    const std::uint8_t* data = buffer_.data() + checked_;
    const std::size_t size = buffer_.size() - checked_;
    if (size == 0) return ok_status();
    ChunkFrame frame;
    const Status framed = read_chunk_frame(data, size, frame);
    if (framed.code() == StatusCode::kNeedMoreInput) return ok_status();
    if (!framed.ok()) return fail(framed, offset, frame.type);
    if (frame.payload_size > kMaximumChunkSize || frame.payload_size > limits_.maximum_chunk_size) {
      return fail(NMC_ERROR(kLimit, "8", "a chunk is too large"), offset, frame.type);
    }
    // At most 2^30 + 15: no overflow where size_t has 32 bits.
    const std::size_t chunk_size =
        frame.head_size + static_cast<std::size_t>(frame.payload_size) + kChecksumSize;
    if (offset + chunk_size > layer_target_) {
      return fail(NMC_ERROR(kCorrupt, "3.3.5", "a chunk reaches beyond its layer"), offset, frame.type);
    }
    if (size < chunk_size) return ok_status();
    ByteReader checksum(data + chunk_size - kChecksumSize, kChecksumSize);
    if (checksum.read_u32() != crc32c(data, chunk_size - kChecksumSize)) {
      return fail(NMC_ERROR(kChecksum, "3.2", "the checksum of a chunk is wrong"), offset, frame.type);
    }
    checked_ += chunk_size;
  }
  layer_is_complete = true;
  return ok_status();
}

Status StreamDecoder::decode_layer() {
  mesh_.begin_layer();
  while (buffer_offset_ + consumed_ < layer_target_) {
    const std::uint64_t offset = buffer_offset_ + consumed_;
    const std::uint8_t* data = buffer_.data() + consumed_;
    ChunkFrame frame;
    NMC_TRY(read_chunk_frame(data, buffer_.size() - consumed_, frame));
    const auto payload_size = static_cast<std::size_t>(frame.payload_size);
    const bool is_in_place = is_in_its_row(frame.type, data + frame.head_size, payload_size);
    const Status decoded =
        !is_in_place
            ? NMC_ERROR(kCorrupt, "3.3.5", "a chunk lies in the row of another region")
            : decode_chunk(static_cast<ChunkType>(frame.type), data + frame.head_size, payload_size,
                     offset + frame.head_size + payload_size + kChecksumSize);
    if (!decoded.ok()) {
      mesh_is_lost_ = !mesh_.roll_back_layer();
      return fail(decoded, offset, frame.type);
    }
    const std::size_t chunk_size = frame.head_size + payload_size + kChecksumSize;
    if (static_cast<ChunkType>(frame.type) == ChunkType::kAttribute)
      attribute_size_[data[frame.head_size]] += chunk_size;
    consumed_ += chunk_size;
  }
  if (!mesh_.has_base()) {
    return fail(NMC_ERROR(kCorrupt, "4.3", "the first layer has no base mesh"), layer_end_offset_);
  }
  return ok_status();
}

NMC_SELDOM bool StreamDecoder::is_in_its_row(std::uint8_t type, const std::uint8_t* payload, std::size_t size) const {
  const std::uint8_t region = header_.layers[layers_complete_].region;
  if (region == 0 || (type & kAncillaryBit) != 0) return true;
  ByteReader reader(payload, size);
  return static_cast<ChunkType>(type) == ChunkType::kRegion &&
         reader.read_varint() / static_cast<std::uint64_t>(header_.quality_layer_count) + 1 == region;
}

NMC_SELDOM Status StreamDecoder::finish() {
  if (!error_.status.ok()) return error_.status;
  if (has_bytes_after_end_) {
    return fail(NMC_ERROR(kCorrupt, "3.2", "bytes follow the last layer"), layer_end_offset_);
  }
  if (has_header_ && layers_complete_ == header_.layers.size()) return ok_status();
  return fail(NMC_ERROR(kTruncated, "3.2", "the stream ends early"), buffer_offset_ + buffer_.size());
}

NMC_SELDOM Status StreamDecoder::decode_chunk(ChunkType type, const std::uint8_t* payload, std::size_t size,
                                   std::uint64_t end_offset) {
  // A payload that ends too early is said to, whatever the zeros read in its place meant (spec 5.1).
  const auto outcome = [](const RangeDecoder& coder, const Status& status) {
    return coder.overrun() || status.ok() ? coder.check() : status;
  };
  switch (type) {
    case ChunkType::kBaseMesh: {
      // An impossible count is refused before anything is allocated.
      if (header_.base_face_count > kFreeBaseFaces + kBaseFacesPerByte * static_cast<std::uint64_t>(size)) {
        return NMC_ERROR(kLimit, "8.2", "the base mesh has more faces than so few bytes may describe");
      }
      RangeDecoder coder(payload, size, limits_.stop);
      return outcome(coder, mesh_.code_base(coder, nullptr, nullptr, nullptr, nullptr, nullptr));
    }
    case ChunkType::kBaseCorrection: {
      NMC_CHECK_STREAM(size >= 1, "4.7", "the chunk is too short");
      RangeDecoder coder(payload + 1, size - 1, limits_.stop);
      return outcome(coder, mesh_.code_base_correction(coder, payload[0], nullptr));
    }
    case ChunkType::kGeometry: {
      NMC_CHECK_STREAM(size >= 3, "5.3", "the chunk is too short");
      const int layer = payload[0], first_level = payload[1], level_count = payload[2];
      NMC_CHECK_STREAM(level_count >= 1 && first_level + level_count <= header_.level_count, "5.3",
                       "a level that the header does not announce");
      NMC_CHECK_STREAM(mesh_.has_base(), "4.3", "coefficients come before the base mesh");
      RangeDecoder coder(payload + 3, size - 3, limits_.stop);
      for (int level = first_level; level < first_level + level_count; ++level) {
        NMC_TRY(check_level_size(level + 1, end_offset));
        NMC_TRY(count_values(level_vertex_count(level + 1) - level_vertex_count(level), end_offset));
        NMC_TRY(outcome(coder, mesh_.code_level(coder, layer, level, nullptr)));
      }
      return ok_status();
    }
    case ChunkType::kRegion: {
      ByteReader reader(payload, size);
      const auto layer_count = static_cast<std::uint64_t>(header_.quality_layer_count);
      const std::uint64_t place = reader.read_varint();
      NMC_CHECK_STREAM(!reader.overrun() && !reader.malformed() && place / layer_count < header_.region_count, "5.4",
                       "a region that the header does not announce");
      CodedMesh::RegionCoder coding(memory_);
      NMC_TRY(mesh_.begin_region(static_cast<int>(place % layer_count), static_cast<int>(place / layer_count), coding));
      RangeDecoder coder(payload + reader.position(), size - reader.position(), limits_.stop);
      for (int i = 0; i < header_.region_level_count; ++i) {
        const int level = header_.region_level + i;
        std::uint64_t value_count = 0;
        NMC_TRY(check_level_size(level + 1, end_offset));
        NMC_TRY(mesh_.begin_region_level(level, coding, value_count));
        NMC_TRY(count_values(value_count, end_offset));
        NMC_TRY(outcome(coder, mesh_.code_region_level(coder, coding, nullptr)));
      }
      mesh_.end_region(coding);
      return ok_status();
    }
    case ChunkType::kAttribute: {
      NMC_CHECK_STREAM(size >= 3, "10.3", "the chunk is too short");
      const int attribute = payload[0], first_level = payload[1], level_count = payload[2];
      NMC_CHECK_STREAM(level_count >= 1 && first_level + level_count <= header_.level_count + 1, "10.3",
                       "a level that the header does not announce");
      NMC_CHECK_STREAM(mesh_.has_base(), "10.3", "an attribute comes before the base mesh");
      RangeDecoder coder(payload + 3, size - 3, limits_.stop);
      const auto no_choice = [](auto...) {};
      for (int level = first_level; level < first_level + level_count; ++level) {
        NMC_TRY(check_level_size(level, end_offset));
        if (attribute < header_.attribute_count) {
          const std::uint64_t known = level > 0 ? level_vertex_count(level - 1) : 0;
          const int component_count = header_.attributes[attribute].component_count;
          NMC_TRY(count_values(
              (level_vertex_count(level) - known) * static_cast<std::uint64_t>(component_count), end_offset));
        }
        NMC_TRY(outcome(coder, mesh_.code_attribute(coder, attribute, level, no_choice)));
      }
      return ok_status();
    }
    default:
      if (static_cast<std::uint8_t>(type) & kAncillaryBit) return ok_status();
      return NMC_ERROR(kFeature, "3.2", "the stream uses a feature that this decoder does not know");
  }
}

Status StreamDecoder::check_readable(int level) const {
  if (mesh_is_lost_) return error_.status;
  if (layers_complete_ == 0) return NMC_ERROR(kState, nullptr, "no layer is complete yet");
  if (level < 0 || level > header_.level_count) {
    return NMC_ERROR(kArgument, nullptr, "the stream has no such level");
  }
  return check_level_size(level, layer_end_offset_);
}

Status StreamDecoder::level_size(int level, std::uint32_t& vertex_count, std::uint32_t& face_count) const {
  NMC_TRY(check_readable(level));
  vertex_count = static_cast<std::uint32_t>(level_vertex_count(level));
  face_count = header_.base_face_count << (2 * level);
  return ok_status();
}

Status StreamDecoder::update_positions(int level) {
  NMC_TRY(check_readable(level));
  return mesh_.update_positions(level, limits_.stop, limits_.runner);
}

Status StreamDecoder::update_attribute(int index, int level) {
  NMC_TRY(check_readable(level));
  if (index < 0 || index >= header_.attribute_count) {
    return NMC_ERROR(kArgument, nullptr, "the stream has no such attribute");
  }
  return mesh_.update_attribute(index, level, limits_.stop);
}

NMC_SELDOM Status StreamDecoder::read_regions(std::uint8_t* regions) {
  NMC_TRY(check_readable(0));
  NMC_TRY(mesh_.ensure_partition());
  for (const std::uint32_t region : mesh_.partition().region_of_face) *regions++ = static_cast<std::uint8_t>(region);
  return ok_status();
}

Status StreamDecoder::read_indices(int level, std::uint32_t* indices) {
  NMC_TRY(check_readable(level));
  if (level == 0) {
    std::memcpy(indices, mesh_.topology(0).face_vertices.data(),
                mesh_.topology(0).face_vertices.size() * sizeof(std::uint32_t));
    return ok_status();
  }
  NMC_TRY(mesh_.ensure_topology(level - 1, false));
  split_faces(mesh_.topology(level - 1), indices);
  return ok_status();
}

}  // namespace nmc
