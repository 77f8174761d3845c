// SPDX-License-Identifier: Apache-2.0
// Headers written field by field, right or wrong, with a checksum that fits.
#ifndef NMC_TESTS_SUPPORT_HEADER_BYTES_H_
#define NMC_TESTS_SUPPORT_HEADER_BYTES_H_

#include <cstdint>
#include <string>
#include <vector>

#include "libnmc/common/checksum.h"

namespace nmc::test {

using Bytes = std::vector<std::uint8_t>;

inline void put_varint(Bytes& bytes, std::uint64_t value) {
  while (value >= 128) {
    bytes.push_back(static_cast<std::uint8_t>(value | 128));
    value >>= 7;
  }
  bytes.push_back(static_cast<std::uint8_t>(value));
}
inline void put_signed(Bytes& bytes, std::int64_t value) {
  put_varint(bytes, (static_cast<std::uint64_t>(value) << 1) ^ static_cast<std::uint64_t>(value >> 63));
}
inline void put_u16(Bytes& bytes, std::uint32_t value) {
  bytes.push_back(static_cast<std::uint8_t>(value));
  bytes.push_back(static_cast<std::uint8_t>(value >> 8));
}
inline void put_u32(Bytes& bytes, std::uint32_t value) {
  put_u16(bytes, value & 65535u);
  put_u16(bytes, value >> 16);
}
inline Bytes with_checksum(Bytes bytes) {
  put_u32(bytes, crc32c(bytes.data(), bytes.size()));
  return bytes;
}

/// The fields of a header as numbers: each may be set beyond its range (spec 3.3).
struct HeaderFields {
  Bytes signature = {0x8e, 'N', 'M', 'C'};
  std::uint8_t version = 1;
  std::uint8_t flags = 0;
  std::uint8_t frame = 0;
  std::uint64_t step_mantissa = 1;
  std::int64_t step_exponent = -10;
  std::int64_t origin[3] = {0, 0, 0};
  std::uint64_t extent[3] = {100, 100, 100};
  std::uint64_t input_vertex_count = 4, input_triangle_count = 4;
  std::uint64_t base_vertex_count = 4, base_face_count = 4;
  std::uint8_t level_count = 2;
  std::uint8_t quality_layer_count = 1;  // written when flag 8 is set
  Bytes ratios;
  Bytes regions = {2, 1, 1};  // written when flag 16 is set
  std::uint8_t tangential_code = 64;
  Bytes step_codes = {64, 64};
  Bytes tensions;  // written when flag 4 is set
  // Written when flag 2 is set: one colour of eight bits with values for levels 0 and 1.
  Bytes attributes = {1, 1, 3, 8, 1, 1, 4, 4, 4, 4, 8, 8, 0x46};
  struct Row {
    std::uint64_t size = 10;
    std::uint8_t level = 0;
    std::uint16_t rms = 100, max = 100;
    std::uint8_t region = 0;  // written when flag 16 is set
  };
  std::vector<Row> rows = {Row{}};
  std::uint64_t row_count = 1;
  Bytes extra;  // behind the last field

  Bytes fields() const {
    Bytes b = {flags, frame};
    put_varint(b, step_mantissa);
    put_signed(b, step_exponent);
    for (const std::int64_t o : origin) put_signed(b, o);
    for (const std::uint64_t e : extent) put_varint(b, e);
    put_varint(b, input_vertex_count);
    put_varint(b, input_triangle_count);
    put_varint(b, base_vertex_count);
    put_varint(b, base_face_count);
    b.push_back(level_count);
    if (flags & 8) {
      b.push_back(quality_layer_count);
      b.insert(b.end(), ratios.begin(), ratios.end());
    }
    if (flags & 16) b.insert(b.end(), regions.begin(), regions.end());
    if (level_count > 0) b.push_back(tangential_code);
    b.insert(b.end(), step_codes.begin(), step_codes.end());
    if (flags & 4) b.insert(b.end(), tensions.begin(), tensions.end());
    if (flags & 2) b.insert(b.end(), attributes.begin(), attributes.end());
    put_varint(b, row_count);
    for (const Row& row : rows) {
      put_varint(b, row.size);
      b.push_back(row.level);
      put_u16(b, row.rms);
      put_u16(b, row.max);
      if (flags & 16) b.push_back(row.region);
    }
    b.insert(b.end(), extra.begin(), extra.end());
    return b;
  }
  Bytes bytes() const {
    Bytes b = signature;
    b.push_back(version);
    const Bytes f = fields();
    put_varint(b, f.size());
    b.insert(b.end(), f.begin(), f.end());
    return with_checksum(std::move(b));
  }
};

inline Bytes chunk(std::uint8_t type, const Bytes& payload) {
  Bytes b = {type};
  put_varint(b, payload.size());
  b.insert(b.end(), payload.begin(), payload.end());
  return with_checksum(std::move(b));
}

}  // namespace nmc::test

#endif  // NMC_TESTS_SUPPORT_HEADER_BYTES_H_
