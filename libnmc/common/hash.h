// SPDX-License-Identifier: Apache-2.0
// The 64-bit hash of the conformance oracles (spec 9): FNV-1a over little-endian 32-bit words with a final mix.
#ifndef NMC_COMMON_HASH_H_
#define NMC_COMMON_HASH_H_

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "libnmc/common/vec3.h"

namespace nmc {

class Hash64 {
 public:
  void add_u32(std::uint32_t value) { state_ = (state_ ^ value) * 0x100000001b3ull; }
  void add_i32(std::int32_t value) { add_u32(static_cast<std::uint32_t>(value)); }
  void add_u64(std::uint64_t value) {
    add_u32(static_cast<std::uint32_t>(value));
    add_u32(static_cast<std::uint32_t>(value >> 32));
  }
  /// The 64 bits of the IEEE 754 number; minus zero counts as plus zero.
  void add_double(double value) {
    value = value + 0.0;
    std::uint64_t bits;
    std::memcpy(&bits, &value, sizeof bits);
    add_u64(bits);
  }
  void add_position(const Vec3& p) {
    add_double(p.x);
    add_double(p.y);
    add_double(p.z);
  }
  std::uint64_t value() const {
    std::uint64_t h = state_;
    h ^= h >> 33;
    h *= 0xff51afd7ed558ccdull;
    h ^= h >> 33;
    h *= 0xc4ceb9fe1a85ec53ull;
    h ^= h >> 33;
    return h;
  }

 private:
  std::uint64_t state_ = 0xcbf29ce484222325ull;
};

}  // namespace nmc

#endif  // NMC_COMMON_HASH_H_
