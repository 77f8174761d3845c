// SPDX-License-Identifier: Apache-2.0
// Union-find whose representative is always the lowest member, so results do not depend on the order of
// unions.
//
// Based on: R. E. Tarjan, J. van Leeuwen. Worst-case analysis of set union algorithms. JACM 1984 (path
// halving).
#ifndef NMC_ENCODER_CONDITION_DISJOINT_SETS_H_
#define NMC_ENCODER_CONDITION_DISJOINT_SETS_H_

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace nmc::conditioning {

/// Sets over 0..count-1. 4 bytes per element; both operations are O(log n) amortized (linking by index
/// instead of by rank is what makes the lowest member the representative).
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0u); }

  /// The lowest member of the set of `element`.
  std::uint32_t find(std::uint32_t element) {
    while (parent_[element] != element) {
      parent_[element] = parent_[parent_[element]];
      element = parent_[element];
    }
    return element;
  }

  /// False when the two were already in one set.
  bool unite(std::uint32_t a, std::uint32_t b) {
    a = find(a);
    b = find(b);
    if (a == b) return false;
    if (a < b)
      parent_[b] = a;
    else
      parent_[a] = b;
    return true;
  }

 private:
  std::vector<std::uint32_t> parent_;  // parent_[i] <= i, hence no cycles and roots are minima
};

}  // namespace nmc::conditioning

#endif  // NMC_ENCODER_CONDITION_DISJOINT_SETS_H_
