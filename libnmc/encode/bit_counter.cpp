// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "libnmc/encode/range_encoder.h"

namespace nmc {

namespace {
struct CostTable {
  std::uint32_t cost[4097];  // -log2(i / 4096) in 1/65536 bit
  CostTable() {
    for (int i = 0; i <= 4096; ++i) {
      cost[i] = static_cast<std::uint32_t>(std::lround(-65536 * std::log2((i ? i : 0.5) / 4096.0)));
    }
  }
};
}  // namespace

int BitCounter::code(int bit, std::uint32_t probability_16) {
  static const CostTable table;
  const std::uint32_t p = bit ? probability_16 : 65536 - probability_16;
  const std::uint32_t cell = p >> 4, within = p & 15;
  sum_ += (table.cost[cell] * (16 - within) + table.cost[cell < 4096 ? cell + 1 : 4096] * within) >> 4;
  return bit;
}

}  // namespace nmc
