// SPDX-License-Identifier: Apache-2.0
// Which edges may be collapsed without a change of topology.
//
// Based on: Dey, Edelsbrunner, Guha, Nekhayev, "Topology preserving edge contraction" (1999).
#ifndef NMC_ENCODER_DOMAIN_LINK_CONDITION_H_
#define NMC_ENCODER_DOMAIN_LINK_CONDITION_H_

#include <algorithm>
#include <cstdint>
#include <vector>

#include "encoder/domain/corner_table.h"

namespace nmc {

/// Marks the rings of one vertex after the other; 4 bytes per vertex slot of the table.
class LinkCondition {
 public:
  explicit LinkCondition(const CornerTable& table) : mark_(table.vertex_slot_count(), 0) {}

  /// The links of v and u share exactly the two vertices opposite the edge: the result is a simplicial complex of the same
  /// topology. (In closed surfaces with every valence above 3 or more than four vertices this is sufficient; callers
  /// exclude the tetrahedron by its valences.) O(valences).
  bool holds(const CornerTable& table, std::uint32_t v, std::uint32_t u) {
    if (++stamp_ == 0) {
      std::fill(mark_.begin(), mark_.end(), 0u);
      stamp_ = 1;
    }
    CornerTable::Corner c = table.corner_at(v), d = c;
    do {
      mark_[table.vertex(CornerTable::next(d))] = stamp_;
      d = table.rotate(d);
    } while (d != c);
    int common = 0;
    c = d = table.corner_at(u);
    do {
      common += mark_[table.vertex(CornerTable::next(d))] == stamp_;
      d = table.rotate(d);
    } while (d != c);
    return common == 2;
  }

 private:
  std::vector<std::uint32_t> mark_;
  std::uint32_t stamp_ = 0;
};

}  // namespace nmc

#endif  // NMC_ENCODER_DOMAIN_LINK_CONDITION_H_
