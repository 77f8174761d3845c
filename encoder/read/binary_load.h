// SPDX-License-Identifier: Apache-2.0
// Unaligned loads of numbers in a given byte order.
#ifndef NMC_ENCODER_READ_BINARY_LOAD_H_
#define NMC_ENCODER_READ_BINARY_LOAD_H_

#include <bit>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace nmc {

/// The value of type T (an arithmetic type of 1, 2, 4 or 8 bytes) stored at `at` in byte order `order`.
template <class T>
T load(const char* at, std::endian order) {
  using Bits = std::conditional_t<
      sizeof(T) == 1, std::uint8_t,
      std::conditional_t<sizeof(T) == 2, std::uint16_t,
                         std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>>>;
  Bits bits;
  std::memcpy(&bits, at, sizeof bits);
  if (order != std::endian::native) {
    if constexpr (sizeof(T) == 2) bits = __builtin_bswap16(bits);
    if constexpr (sizeof(T) == 4) bits = __builtin_bswap32(bits);
    if constexpr (sizeof(T) == 8) bits = __builtin_bswap64(bits);
  }
  return std::bit_cast<T>(bits);
}

}  // namespace nmc

#endif  // NMC_ENCODER_READ_BINARY_LOAD_H_
