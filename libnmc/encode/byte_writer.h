// SPDX-License-Identifier: Apache-2.0
// Little-endian writes: the mirror image of common/byte_reader.h.
#ifndef NMC_ENCODE_BYTE_WRITER_H_
#define NMC_ENCODE_BYTE_WRITER_H_

#include <cstddef>
#include <cstdint>

#include "libnmc/common/memory.h"

namespace nmc {

class ByteWriter {
 public:
  explicit ByteWriter(Array<std::uint8_t>& output) : output_(output) {}
  void write_u8(std::uint8_t value) { failed_ |= !output_.push_back(value); }
  void write_u16(std::uint16_t value) {
    write_u8(static_cast<std::uint8_t>(value & 255u));
    write_u8(static_cast<std::uint8_t>(value >> 8));
  }
  void write_u32(std::uint32_t value) {
    write_u16(static_cast<std::uint16_t>(value & 65535u));
    write_u16(static_cast<std::uint16_t>(value >> 16));
  }
  void write_varint(std::uint64_t value) {
    while (value >= 128) {
      write_u8(static_cast<std::uint8_t>((value & 127u) | 128u));
      value >>= 7;
    }
    write_u8(static_cast<std::uint8_t>(value));
  }
  void write_signed_varint(std::int64_t value) {
    write_varint((static_cast<std::uint64_t>(value) << 1) ^ static_cast<std::uint64_t>(value >> 63));
  }
  void write_bytes(const std::uint8_t* data, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) write_u8(data[i]);
  }
  bool out_of_memory() const { return failed_; }

 private:
  Array<std::uint8_t>& output_;
  bool failed_ = false;
};

}  // namespace nmc

#endif  // NMC_ENCODE_BYTE_WRITER_H_
