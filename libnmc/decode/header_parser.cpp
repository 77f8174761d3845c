// SPDX-License-Identifier: Apache-2.0
#include "libnmc/decode/header_parser.h"

#include "libnmc/common/byte_reader.h"
#include "libnmc/common/checksum.h"

namespace nmc {

namespace {
constexpr std::size_t kPrefixSize = 5;  // signature and version
constexpr std::size_t kChecksumSize = 4;
/// Spec 10.1.
Status parse_attribute(ByteReader& reader, int level_count, AttributeDescriptor& attribute) {
  attribute.kind = reader.read_u8();
  NMC_CHECK_STREAM(attribute.kind != 0, "10.1", "an attribute has no kind");
  attribute.component_count = reader.read_u8();
  NMC_CHECK_STREAM(attribute.component_count >= 1 && attribute.component_count <= kMaximumComponentCount, "10.1",
                   "the number of components of an attribute is out of range");
  attribute.bit_count = reader.read_u8();
  NMC_CHECK_STREAM(attribute.bit_count >= 1 && attribute.bit_count <= kMaximumAttributeBits, "10.1",
                   "the number of bits of an attribute is out of range");
  const std::uint8_t flags = reader.read_u8();
  NMC_CHECK_STREAM((flags & 0xfeu) == 0, "10.1", "a reserved flag of an attribute is set");
  attribute.is_decorrelated = (flags & 1u) != 0;
  NMC_CHECK_STREAM(
      (!attribute.is_decorrelated && !attribute.is_color()) || attribute.component_count >= 3, "10.1",
      "a colour has less than three components");
  attribute.finest_level = reader.read_u8();
  NMC_CHECK_STREAM(attribute.finest_level <= level_count, "10.1", "an attribute has too many levels");
  for (int l = 0; l <= attribute.finest_level; ++l) {
    AttributeLevel& level = attribute.levels[l];
    for (int c = 0; c < attribute.component_count; ++c) {
      level.step[c] = reader.read_u8();
      NMC_CHECK_STREAM(level.step[c] > 0, "10.1", "a step of an attribute is zero");
    }
    if (l == 0) continue;
    const std::uint8_t shares = reader.read_u8();
    level.opposite_share = (shares & 15) + kLowestOppositeShare;
    level.near_share = shares >> 4;
  }
  return ok_status();
}

}  // namespace

Status measure_header(const std::uint8_t* data, std::size_t size, std::size_t& total_size) {
  for (std::size_t i = 0; i < size && i < 4; ++i) {
    if (data[i] != kSignature[i]) return NMC_ERROR(kNotNmc, "3.1", "this is not an nmc stream");
  }
  if (size > 4 && data[4] != kFormatVersion) {
    return NMC_ERROR(kVersion, "3.1", "the stream has a version that this decoder does not know");
  }
  if (size <= kPrefixSize) return NMC_ERROR(kNeedMoreInput, nullptr, nullptr);
  ByteReader reader(data + kPrefixSize, size - kPrefixSize);
  const std::uint64_t header_size = reader.read_varint();
  if (reader.overrun() && size < kPrefixSize + 10) return NMC_ERROR(kNeedMoreInput, nullptr, nullptr);
  NMC_CHECK_STREAM(!reader.malformed() && !reader.overrun(), "2.2", "the size of the header is misspelt");
  if (header_size > kMaximumHeaderSize) return NMC_ERROR(kLimit, "8", "the header is too large");
  total_size = kPrefixSize + reader.position() + static_cast<std::size_t>(header_size) + kChecksumSize;
  return ok_status();
}

Status parse_header(const std::uint8_t* data, std::size_t total_size, Header& header) {
  ByteReader size_reader(data + kPrefixSize, total_size - kPrefixSize);
  const std::uint64_t header_size = size_reader.read_varint();
  const std::size_t start = kPrefixSize + size_reader.position();
  {
    ByteReader checksum(data + total_size - kChecksumSize, kChecksumSize);
    if (checksum.read_u32() != crc32c(data, total_size - kChecksumSize)) {
      return NMC_ERROR(kChecksum, "3.3", "the checksum of the header is wrong");
    }
  }
  ByteReader reader(data + start, static_cast<std::size_t>(header_size));
  const std::uint8_t flags = reader.read_u8();
  NMC_CHECK_STREAM((flags & 0xe0u) == 0, "3.3.1", "a reserved flag is set");
  header.has_creases = (flags & 1u) != 0;
  const bool has_attributes = (flags & 2u) != 0;
  const bool has_tensions = (flags & 4u) != 0;
  const bool has_layers = (flags & 8u) != 0;
  const bool has_regions = (flags & 16u) != 0;
  const std::uint8_t frame = reader.read_u8();
  NMC_CHECK_STREAM((frame & 15u) <= static_cast<unsigned>(Units::kKilometre) && (frame >> 4) <= 2u, "3.3.2",
                   "unknown units or up axis");
  header.units = static_cast<Units>(frame & 15u);
  header.up_axis = static_cast<UpAxis>(frame >> 4);

  const std::uint64_t mantissa = reader.read_varint();
  const std::int64_t exponent = reader.read_signed_varint();
  NMC_CHECK_STREAM(mantissa > 0 && mantissa < (1u << 24) && exponent >= -160 && exponent <= 100, "3.3.3",
                   "the grid step is out of range");
  header.step_mantissa = static_cast<std::uint32_t>(mantissa);
  header.step_exponent = static_cast<int>(exponent);
  for (std::int64_t& o : header.origin) {
    o = reader.read_signed_varint();
    NMC_CHECK_STREAM(o >= -kMaximumOrigin && o <= kMaximumOrigin, "3.3.3", "the origin is out of range");
  }
  for (std::uint64_t& e : header.extent) {
    e = reader.read_varint();
    NMC_CHECK_STREAM(e <= static_cast<std::uint64_t>(kMaximumOrigin), "3.3.3", "the box is out of range");
  }
  header.input_vertex_count = reader.read_varint();
  header.input_triangle_count = reader.read_varint();
  const std::uint64_t vertex_count = reader.read_varint(), face_count = reader.read_varint();
  NMC_CHECK_STREAM(vertex_count >= 3 && vertex_count < kNone / 4 && face_count >= 1 &&
                       face_count < kNone / 4 && vertex_count <= 3 * face_count &&
                       face_count <= 2 * vertex_count + kNone / 8,
                   "3.3.4", "the size of the base mesh is out of range");
  header.base_vertex_count = static_cast<std::uint32_t>(vertex_count);
  header.base_face_count = static_cast<std::uint32_t>(face_count);
  const std::uint8_t level_count = reader.read_u8();
  NMC_CHECK_STREAM(level_count <= kMaximumLevelCount, "3.3.4", "too many levels");
  header.level_count = level_count;
  header.quality_layer_count = 1;
  if (has_layers) {
    header.quality_layer_count = reader.read_u8();
    NMC_CHECK_STREAM(header.quality_layer_count >= 2 && header.quality_layer_count <= kMaximumLayerCount,
                     "3.3.4", "the number of quality layers is out of range");
    std::uint64_t product = 1;
    for (int k = 1; k < header.quality_layer_count; ++k) {
      header.layer_ratio[k] = reader.read_u8();
      NMC_CHECK_STREAM(header.layer_ratio[k] >= 1 && header.layer_ratio[k] <= 16, "3.3.4",
                       "the ratio of two quality layers is out of range");
      product *= header.layer_ratio[k];
      NMC_CHECK_STREAM(product <= (1u << 20), "3.3.4", "the quality layers span too much");
    }
  }
  if (has_regions) {
    header.region_count = reader.read_u8();
    header.region_level = reader.read_u8();
    header.region_level_count = reader.read_u8();
    NMC_CHECK_STREAM(header.region_count - 1 < kMaximumRegionCount && header.region_count <= face_count &&
                         header.region_level > 0 && header.region_level_count > 0 &&
                         header.region_level + header.region_level_count <= level_count,
                     "3.3.4", "the regions or their levels are out of range");
  }
  if (level_count > 0) header.tangential_code = reader.read_u8();
  for (int l = 0; l < level_count; ++l) header.step_code[l] = reader.read_u8();
  for (int l = 0; l < level_count; ++l) {
    header.tension_code[l] = has_tensions ? reader.read_u8() : std::uint8_t{4};
    NMC_CHECK_STREAM(header.tension_code[l] <= 8, "3.3.4", "a tension is out of range");
  }
  header.attribute_count = 0;
  if (has_attributes) {
    header.attribute_count = reader.read_u8();
    NMC_CHECK_STREAM(header.attribute_count >= 1 && header.attribute_count <= kMaximumAttributeCount, "10.1",
                     "the number of attributes is out of range");
    for (int i = 0; i < header.attribute_count; ++i)
      NMC_TRY(parse_attribute(reader, level_count, header.attributes[i]));
  }
  const std::uint64_t layer_count = reader.read_varint();
  NMC_CHECK_STREAM(layer_count >= 1 && layer_count <= kMaximumTableSize, "3.3.5",
                   "the length of the layer table is out of range");
  if (!header.layers.resize(static_cast<std::size_t>(layer_count))) return no_memory();
  for (LayerEntry& entry : header.layers) {
    entry.size = reader.read_varint();
    entry.level = reader.read_u8();
    entry.rms_error = reader.read_u16();
    entry.max_error = reader.read_u16();
    entry.region = has_regions ? reader.read_u8() : std::uint8_t{0};
    NMC_CHECK_STREAM(entry.size > 0 && entry.size < (std::uint64_t{1} << 40) && entry.level <= level_count &&
                         entry.region <= header.region_count,
                     "3.3.5", "a row of the layer table is out of range");
  }
  NMC_CHECK_STREAM(!reader.overrun(), "3.3", "the header ends too early");
  NMC_CHECK_STREAM(!reader.malformed(), "2.2", "a number in the header is misspelt");
  NMC_CHECK_STREAM(reader.remaining() == 0, "3.3", "the header has bytes too many");
  return ok_status();
}

}  // namespace nmc
