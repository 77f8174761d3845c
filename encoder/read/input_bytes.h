// SPDX-License-Identifier: Apache-2.0
// A whole file as one span of bytes: mapped where the system can, read into memory where it cannot (pipes).
#ifndef NMC_ENCODER_READ_INPUT_BYTES_H_
#define NMC_ENCODER_READ_INPUT_BYTES_H_

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace nmc {

/// Read-only; the span lives as long as the object. The file must not be shortened by another program while
/// it is mapped (the system then ends the process, as for every mapped file).
class InputBytes {
 public:
  /// Opens `path`; "-" is standard input. Throws nmc::Error (kInputOutput) with the system's reason.
  static InputBytes open(const std::string& path);

  InputBytes(InputBytes&& other) noexcept;
  InputBytes& operator=(InputBytes&& other) noexcept;
  ~InputBytes();

  std::span<const std::byte> bytes() const;

 private:
  InputBytes() = default;
  void release();

  void* mapping_ = nullptr;
  std::size_t mapping_size_ = 0;
  std::vector<std::byte> copy_;  // used when nothing is mapped
};

}  // namespace nmc

#endif  // NMC_ENCODER_READ_INPUT_BYTES_H_
