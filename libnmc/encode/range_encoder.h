// SPDX-License-Identifier: Apache-2.0
// Binary arithmetic encoder: the mirror image of decode/range_decoder.h (spec 5.1).
#ifndef NMC_ENCODE_RANGE_ENCODER_H_
#define NMC_ENCODE_RANGE_ENCODER_H_

#include <cstdint>

#include "libnmc/common/memory.h"

namespace nmc {

class RangeEncoder {
 public:
  static constexpr bool kDecodes = false;

  explicit RangeEncoder(Array<std::uint8_t>& output) : output_(output) {}

  int code(int bit, std::uint32_t probability_16) {
    const std::uint32_t middle =
        low_ + static_cast<std::uint32_t>((static_cast<std::uint64_t>(high_ - low_) * probability_16) >> 16);
    if (bit)
      high_ = middle;
    else
      low_ = middle + 1;
    while (((low_ ^ high_) & 0xff000000u) == 0) {
      put(static_cast<std::uint8_t>(low_ >> 24));
      low_ <<= 8;
      high_ = (high_ << 8) | 255u;
    }
    return bit;
  }
  /// Ends the payload with as few bytes as tell it from every other: the decoder appends zeros by itself.
  void finish() {
    // The shortest value in [low, high] once followed by zeros.
    for (int bytes = 0; bytes <= 4; ++bytes) {
      const std::uint32_t mask = bytes == 0 ? 0u : 0xffffffffu << (32 - 8 * bytes);
      std::uint64_t value = low_ & mask;
      if (value < low_) value += bytes == 0 ? (std::uint64_t{1} << 32) : (std::uint64_t{1} << (32 - 8 * bytes));
      if (value > high_) continue;
      for (int i = 0; i < bytes; ++i) put(static_cast<std::uint8_t>(value >> (24 - 8 * i)));
      break;
    }
  }
  bool out_of_memory() const { return failed_; }

 private:
  void put(std::uint8_t byte) {
    if (!output_.push_back(byte)) failed_ = true;
  }

  Array<std::uint8_t>& output_;
  std::uint32_t low_ = 0, high_ = 0xffffffffu;
  bool failed_ = false;
};

/// Counts the bits a RangeEncoder would write, for cost estimates.
class BitCounter {
 public:
  static constexpr bool kDecodes = false;
  int code(int bit, std::uint32_t probability_16);
  double bits() const { return static_cast<double>(sum_) / 65536; }

 private:
  std::uint64_t sum_ = 0;
};

}  // namespace nmc

#endif  // NMC_ENCODE_RANGE_ENCODER_H_
