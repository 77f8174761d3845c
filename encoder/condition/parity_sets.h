// SPDX-License-Identifier: Apache-2.0
// Union-find in which every element knows whether it is on the same side as its representative.
//
// Based on: the weighted union-find of R. E. Tarjan. Applications of path compression on balanced trees. JACM
// 1979, with weights in the group of two elements.
#ifndef NMC_ENCODER_CONDITION_PARITY_SETS_H_
#define NMC_ENCODER_CONDITION_PARITY_SETS_H_

#include <cstddef>
#include <cstdint>
#include <vector>

namespace nmc::conditioning {

/// Sets over 0..count-1 (count below 2^31), each split into two sides. 4 bytes per element, O(log n)
/// amortized.
class ParitySets {
 public:
  struct Place {
    std::uint32_t root;  // the lowest member of the set
    std::uint32_t side;  // 0: the root's side, 1: the other one
  };

  explicit ParitySets(std::size_t count) : links_(count) {
    for (std::uint32_t i = 0; i < count; ++i) links_[i] = i << 1;
  }

  Place find(std::uint32_t element) {
    std::uint32_t side = 0;
    while (parent(element) != element) {
      const std::uint32_t above = parent(element);
      if (parent(above) != above) links_[element] = links_[above] ^ (links_[element] & 1u);
      side ^= links_[element] & 1u;
      element = parent(element);
    }
    return {element, side};
  }

  /// Puts a and b into one set, on the same side when `other_side` is 0. False, with nothing changed, when
  /// they are in one set already and not so.
  bool unite(std::uint32_t a, std::uint32_t b, std::uint32_t other_side) {
    const Place place_a = find(a), place_b = find(b);
    const std::uint32_t side = place_a.side ^ place_b.side ^ other_side;
    if (place_a.root == place_b.root) return side == 0;
    if (place_a.root < place_b.root)
      links_[place_b.root] = place_a.root << 1 | side;
    else
      links_[place_a.root] = place_b.root << 1 | side;
    return true;
  }

 private:
  std::uint32_t parent(std::uint32_t element) const { return links_[element] >> 1; }
  std::vector<std::uint32_t> links_;  // parent << 1 | side relative to the parent; parents are not larger
};

}  // namespace nmc::conditioning

#endif  // NMC_ENCODER_CONDITION_PARITY_SETS_H_
