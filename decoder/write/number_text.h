// SPDX-License-Identifier: Apache-2.0
// Values to bytes: text in any locale with the fewest digits that read back exactly, and little-endian
// binary.
#ifndef NMC_DECODER_WRITE_NUMBER_TEXT_H_
#define NMC_DECODER_WRITE_NUMBER_TEXT_H_

#include <bit>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <string>

#include "decoder/write/mesh_writer.h"
#include "decoder/write/output_file.h"

namespace nmc {

/// Appends a float, double or integer.
template <class Number>
void append_number(std::string& text, Number value) {
  char digits[40];
  const std::to_chars_result result = std::to_chars(digits, digits + sizeof digits, value);
  text.append(digits, result.ptr);
}

/// Appends coordinate `i` of the mesh in its own precision.
inline void append_coordinate(std::string& text, const MeshView& mesh, std::size_t i) {
  if (mesh.is_double()) {
    append_number(text, mesh.positions_double[i]);
  } else {
    append_number(text, mesh.positions_single[i]);
  }
}

/// Appends the low `sizeof(Bits)` bytes of an unsigned integer, least significant first, on any machine.
template <class Bits>
void append_little_endian(std::string& bytes, Bits bits) {
  for (std::size_t k = 0; k < sizeof bits; ++k)
    bytes.push_back(static_cast<char>(static_cast<std::uint8_t>(bits >> (8 * k))));
}
inline void append_little_endian(std::string& bytes, float value) {
  append_little_endian(bytes, std::bit_cast<std::uint32_t>(value));
}
inline void append_little_endian(std::string& bytes, double value) {
  append_little_endian(bytes, std::bit_cast<std::uint64_t>(value));
}

/// Collects output and hands it to the file in large pieces.
class BlockWriter {
 public:
  explicit BlockWriter(OutputFile& file) : file_(file) { block_.reserve(kBlockSize + 1024); }
  ~BlockWriter() { flush(); }
  BlockWriter(const BlockWriter&) = delete;
  BlockWriter& operator=(const BlockWriter&) = delete;

  std::string& block() { return block_; }

  /// Called between records, so that a record never waits for space.
  void flush_if_full() {
    if (block_.size() >= kBlockSize) flush();
  }

  void flush() {
    file_.write(block_);
    block_.clear();
  }

 private:
  static constexpr std::size_t kBlockSize = std::size_t{1} << 16;

  OutputFile& file_;
  std::string block_;
};

}  // namespace nmc

#endif  // NMC_DECODER_WRITE_NUMBER_TEXT_H_
