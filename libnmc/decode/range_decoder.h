// SPDX-License-Identifier: Apache-2.0
// Binary arithmetic decoder with 16-bit probabilities (spec 5.1).
#ifndef NMC_DECODE_RANGE_DECODER_H_
#define NMC_DECODE_RANGE_DECODER_H_

#include <cstddef>
#include <cstdint>

#include "libnmc/common/status.h"
#include "libnmc/common/stop_request.h"

// An empty statement that the compiler may not carry out in both branches at once.
#if defined(__GNUC__)
#define NMC_KEEP_BRANCH __asm__ volatile("")
#else
#define NMC_KEEP_BRANCH static_cast<void>(0)
#endif

namespace nmc {

/// Reads one entropy-coded payload. Past its end it reads zeros, which a valid payload needs up to four
/// times; more is an error that `overrun()` tells after the payload.
class RangeDecoder {
 public:
  static constexpr bool kDecodes = true;

  RangeDecoder(const std::uint8_t* data, std::size_t size, StopRequest stop = {})
      : data_(data), size_(size), stop_(stop) {
    for (int i = 0; i < 4; ++i) value_ = (value_ << 8) | next_byte();
  }

  /// The next decision, a one with probability `probability_16` / 65536 (1 ... 65535). The first argument is
  /// ignored: encoders pass the bit there.
  int code(int, std::uint32_t probability_16) {
    const std::uint32_t middle =
        low_ + static_cast<std::uint32_t>((static_cast<std::uint64_t>(high_ - low_) * probability_16) >> 16);
    // A branch, and kept one: where a surface is quiet it is predicted, and the next decision need not wait
    // for this one.
    int bit = 0;
    if (value_ <= middle) {
      NMC_KEEP_BRANCH;
      high_ = middle;
      bit = 1;
    } else {
      NMC_KEEP_BRANCH;
      low_ = middle + 1;
    }
    while (((low_ ^ high_) & 0xff000000u) == 0) {
      low_ <<= 8;
      high_ = (high_ << 8) | 255u;
      value_ = (value_ << 8) | next_byte();
    }
    return bit;
  }
  /// The payload ended too early for the decisions read from it.
  bool overrun() const { return excess_ > 4; }
  /// Not ok when the payload has ended too early or the caller wants to stop. To be asked now and then, and
  /// after the last decision.
  Status check() const {
    NMC_CHECK_STREAM(!overrun(), "5.1", "a chunk needs more bytes than it has");
    return stop_.check();
  }
  /// Every byte of the payload was looked at.
  bool consumed() const { return position_ == size_; }

 private:
  std::uint32_t next_byte() {
    if (position_ < size_) return data_[position_++];
    ++excess_;
    return 0;
  }

  const std::uint8_t* data_;
  std::size_t size_;
  StopRequest stop_;
  std::size_t position_ = 0;
  std::uint64_t excess_ = 0;
  std::uint32_t low_ = 0, high_ = 0xffffffffu, value_ = 0;
};

}  // namespace nmc

#endif  // NMC_DECODE_RANGE_DECODER_H_
