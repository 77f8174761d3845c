// SPDX-License-Identifier: Apache-2.0
// Bounds-checked little-endian reads. Reading past the end gives zeros and sets a flag that stays set, so a parser
// may read a whole structure and check once.
#ifndef NMC_COMMON_BYTE_READER_H_
#define NMC_COMMON_BYTE_READER_H_

#include <cstddef>
#include <cstdint>

namespace nmc {

class ByteReader {
 public:
  ByteReader(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}

  std::uint8_t read_u8() {
    if (position_ >= size_) {
      overrun_ = true;
      return 0;
    }
    return data_[position_++];
  }
  std::uint16_t read_u16() {
    const std::uint16_t low = read_u8();
    return static_cast<std::uint16_t>(low | (read_u8() << 8));
  }
  std::uint32_t read_u32() {
    const std::uint32_t low = read_u16();
    const std::uint32_t high = read_u16();
    return low | (high << 16);
  }
  /// LEB128: seven bits a byte, low first. A number of more than 64 bits, or with a superfluous last byte, sets the
  /// malformed flag: every number has exactly one spelling (spec 2.2).
  std::uint64_t read_varint() {
    std::uint64_t value = 0;
    for (int shift = 0; shift < 64; shift += 7) {
      const std::uint8_t byte = read_u8();
      if (shift == 63 && byte > 1) malformed_ = true;
      if (shift > 0 && byte == 0) malformed_ = true;
      value |= static_cast<std::uint64_t>(byte & 127u) << shift;
      if (!(byte & 128u)) return value;
    }
    malformed_ = true;
    return 0;
  }
  /// Zigzag: 0, -1, 1, -2, 2, ... as 0, 1, 2, 3, 4, ...
  std::int64_t read_signed_varint() {
    const std::uint64_t u = read_varint();
    return static_cast<std::int64_t>(u >> 1) ^ -static_cast<std::int64_t>(u & 1);
  }
  const std::uint8_t* current() const { return data_ + position_; }
  std::size_t position() const { return position_; }
  std::size_t remaining() const { return size_ - position_; }
  void skip(std::size_t count) {
    if (count > remaining()) {
      overrun_ = true;
      position_ = size_;
    } else {
      position_ += count;
    }
  }
  bool overrun() const { return overrun_; }
  bool malformed() const { return malformed_; }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
  std::size_t position_ = 0;
  bool overrun_ = false;
  bool malformed_ = false;
};

}  // namespace nmc

#endif  // NMC_COMMON_BYTE_READER_H_
