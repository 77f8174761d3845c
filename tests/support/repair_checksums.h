// SPDX-License-Identifier: Apache-2.0
// Writes the right checksums into a changed stream, as a hostile writer would, so that what is inside is
// reached.
#ifndef NMC_TESTS_SUPPORT_REPAIR_CHECKSUMS_H_
#define NMC_TESTS_SUPPORT_REPAIR_CHECKSUMS_H_

#include <cstddef>
#include <cstdint>

#include "libnmc/common/byte_reader.h"
#include "libnmc/common/checksum.h"

namespace nmc::test {

/// Repairs the header's checksum and that of every chunk whose frame lies within the bytes.
inline void repair_checksums(std::uint8_t* bytes, std::size_t total_size) {
  const auto repair = [&](std::size_t begin, std::size_t end) {  // checksum at end - 4
    const std::uint32_t checksum = crc32c(bytes + begin, end - begin - 4);
    for (int k = 0; k < 4; ++k) bytes[end - 4 + k] = static_cast<std::uint8_t>(checksum >> (8 * k));
  };
  if (total_size < 10) return;
  ByteReader reader(bytes + 5, total_size - 5);
  const std::uint64_t header_size = reader.read_varint();
  if (header_size > total_size) return;
  std::size_t position = 5 + reader.position() + static_cast<std::size_t>(header_size) + 4;
  if (position > total_size) return;
  repair(0, position);
  while (position + 6 <= total_size) {
    ByteReader chunk(bytes + position + 1, total_size - position - 1);
    const std::uint64_t payload = chunk.read_varint();
    if (payload > total_size) return;
    const std::size_t end = position + 1 + chunk.position() + static_cast<std::size_t>(payload) + 4;
    if (end > total_size) return;
    repair(position, end);
    position = end;
  }
}

}  // namespace nmc::test

#endif  // NMC_TESTS_SUPPORT_REPAIR_CHECKSUMS_H_
