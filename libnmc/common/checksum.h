// SPDX-License-Identifier: Apache-2.0
// CRC-32C (Castagnoli), as of RFC 3720 appendix B.4 (spec 2.3).
#ifndef NMC_COMMON_CHECKSUM_H_
#define NMC_COMMON_CHECKSUM_H_

#include <cstddef>
#include <cstdint>

namespace nmc {

/// Continues a checksum over `size` more bytes; start with 0.
inline std::uint32_t crc32c(const std::uint8_t* data, std::size_t size, std::uint32_t checksum = 0) {
  // Linear in the byte: the entry of i + j, where i is a power of two above j, is the sum of both.
  std::uint32_t table[256];
  table[0] = 0;
  std::uint32_t entry = 1;
  for (std::size_t i = 128; i > 0; i /= 2) {
    entry = (entry >> 1) ^ (entry & 1u ? 0x82f63b78u : 0u);
    for (std::size_t j = 0; j < 256; j += 2 * i) table[i + j] = entry ^ table[j];
  }
  checksum = ~checksum;
  for (std::size_t i = 0; i < size; ++i) checksum = (checksum >> 8) ^ table[(checksum ^ data[i]) & 255u];
  return ~checksum;
}

}  // namespace nmc

#endif  // NMC_COMMON_CHECKSUM_H_
