// SPDX-License-Identifier: Apache-2.0
#include "encoder/condition/half_edges.h"

#include <algorithm>

#include "encoder/core/parallel.h"

namespace nmc::conditioning {

EdgeGroups::EdgeGroups(const std::vector<Triangle>& triangles, std::size_t vertex_count)
    : first_(vertex_count + 2, 0), entries_(3 * triangles.size()) {
  // Counting sort by lower vertex. first_ is shifted by one while filling, so that no second cursor array is
  // needed: after the fill, first_[v + 1] has advanced to the end of bucket v, which is the start of v + 1.
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k) ++first_[std::min(t[k], t[(k + 1) % 3]) + 2];
  for (std::size_t v = 2; v < first_.size(); ++v) first_[v] += first_[v - 1];
  std::uint32_t half_edge = 0;
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k, ++half_edge) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      const std::uint64_t higher = std::max(a, b);
      entries_[first_[std::min(a, b) + 1]++] = {higher << 32 | half_edge};
    }
  first_.pop_back();
  parallel_for(vertex_count, [&](std::size_t v) {
    std::sort(entries_.begin() + first_[v], entries_.begin() + first_[v + 1]);
  });
}

std::vector<std::uint32_t> opposite_half_edges(const std::vector<Triangle>& triangles,
                                               std::size_t vertex_count) {
  std::vector<std::uint32_t> opposite(3 * triangles.size(), kNone);
  EdgeGroups(triangles, vertex_count).for_each([&](std::span<const GroupedHalfEdge> group) {
    if (group.size() != 2) return;
    opposite[group[0].half_edge()] = group[1].half_edge();
    opposite[group[1].half_edge()] = group[0].half_edge();
  });
  return opposite;
}

}  // namespace nmc::conditioning
