// SPDX-License-Identifier: Apache-2.0
// CRC-32C (Castagnoli), as of RFC 3720 appendix B.4 (spec 2.3).
#ifndef NMC_COMMON_CHECKSUM_H_
#define NMC_COMMON_CHECKSUM_H_

#include <cstddef>
#include <cstdint>

namespace nmc {

/// Continues a checksum over `size` more bytes; start with 0.
inline std::uint32_t crc32c(const std::uint8_t* data, std::size_t size, std::uint32_t checksum = 0) {
  struct Table {
    std::uint32_t entry[256];
  };
  static constexpr Table kTable = [] {
    Table table{};
    for (std::uint32_t i = 0; i < 256; ++i) {
      std::uint32_t c = i;
      for (int k = 0; k < 8; ++k) c = (c >> 1) ^ (c & 1u ? 0x82f63b78u : 0u);
      table.entry[i] = c;
    }
    return table;
  }();
  checksum = ~checksum;
  for (std::size_t i = 0; i < size; ++i) checksum = (checksum >> 8) ^ kTable.entry[(checksum ^ data[i]) & 255u];
  return ~checksum;
}

}  // namespace nmc

#endif  // NMC_COMMON_CHECKSUM_H_
