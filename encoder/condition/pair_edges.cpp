// SPDX-License-Identifier: Apache-2.0
#include "encoder/condition/pair_edges.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace nmc::conditioning {

namespace {

/// A triangle around an edge. The edge runs from its lower to its higher vertex.
struct Leaf {
  std::uint32_t half_edge;
  bool forward;      // the half-edge runs from the lower to the higher vertex
  double angle_rad;  // of the triangle around the edge, counter-clockwise seen against the edge, in [0, 2 pi)
};

class CrowdedEdge {
 public:
  CrowdedEdge(const WorkingMesh& mesh, std::vector<std::uint32_t>& opposite)
      : mesh_(mesh), opposite_(opposite) {}

  /// Returns the number of half-edges left open.
  std::size_t pair(std::span<const GroupedHalfEdge> group) {
    collect(group);
    pair_as_stored();
    if (leaves_.size() < 2) return leaves_.size();
    measure_angles(group);
    if (!pair_material_wedges()) pair_flattest_first();
    return leaves_.size();
  }

 private:
  void join(std::uint32_t a, std::uint32_t b) {
    opposite_[a] = b;
    opposite_[b] = a;
  }

  void remove_paired() {
    std::erase_if(leaves_, [&](const Leaf& leaf) { return opposite_[leaf.half_edge] != kNone; });
  }

  void collect(std::span<const GroupedHalfEdge> group) {
    leaves_.clear();
    for (const GroupedHalfEdge& entry : group) {
      const std::uint32_t h = entry.half_edge();
      leaves_.push_back({h, tail_of(mesh_.triangles, h) != entry.higher_vertex(), 0});
    }
  }

  std::uint64_t stored_edge(std::uint32_t h) const {
    const std::uint64_t a = tail_of(mesh_.stored, h), b = head_of(mesh_.stored, h);
    return std::min(a, b) << 32 | std::max(a, b);
  }

  void pair_as_stored() {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> by_edge;
    for (const Leaf& leaf : leaves_) by_edge.push_back({stored_edge(leaf.half_edge), leaf.half_edge});
    std::sort(by_edge.begin(), by_edge.end());
    for (std::size_t i = 0; i < by_edge.size();) {
      std::size_t j = i + 1;
      while (j < by_edge.size() && by_edge[j].first == by_edge[i].first) ++j;
      if (j - i == 2) join(by_edge[i].second, by_edge[i + 1].second);
      i = j;
    }
    remove_paired();
  }

  void measure_angles(std::span<const GroupedHalfEdge> group) {
    const std::uint32_t first = group[0].half_edge();
    const std::uint32_t higher = group[0].higher_vertex();
    const std::uint32_t lower = tail_of(mesh_.triangles, first) == higher ? head_of(mesh_.triangles, first)
                                                                          : tail_of(mesh_.triangles, first);
    const Vec3 origin = mesh_.positions[lower];
    const Vec3 axis = normalized(mesh_.positions[higher] - origin);
    const Vec3 helper = std::abs(axis.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    const Vec3 u = normalized(cross(axis, helper)), v = cross(axis, u);
    for (Leaf& leaf : leaves_) {
      const Vec3 d = mesh_.positions[apex_of(mesh_.triangles, leaf.half_edge)] - origin;
      const double angle = std::atan2(dot(d, v), dot(d, u));
      leaf.angle_rad = angle < 0 ? angle + 2 * std::numbers::pi : angle;
    }
    // Equal angles (overlapping triangles) keep the order of the file.
    std::stable_sort(leaves_.begin(), leaves_.end(),
                     [](const Leaf& a, const Leaf& b) { return a.angle_rad < b.angle_rad; });
  }

  /// The normal of a forward triangle points to growing angles, that of a backward one to falling angles;
  /// material is opposite to the normal. So a wedge of material begins at a backward triangle and ends at the
  /// next forward.
  bool pair_material_wedges() {
    const std::size_t count = leaves_.size();
    if (count % 2 != 0) return false;
    for (std::size_t i = 0; i < count; ++i)
      if (leaves_[i].forward == leaves_[(i + 1) % count].forward) return false;
    for (std::size_t i = 0; i < count; ++i)
      if (!leaves_[i].forward) join(leaves_[i].half_edge, leaves_[(i + 1) % count].half_edge);
    leaves_.clear();
    return true;
  }

  void pair_flattest_first() {
    struct Candidate {
      bool disagrees;
      double bend_rad;
      std::size_t i, j;
    };
    std::vector<Candidate> candidates;
    for (std::size_t i = 0; i < leaves_.size(); ++i)
      for (std::size_t j = i + 1; j < leaves_.size(); ++j)
        candidates.push_back({leaves_[i].forward == leaves_[j].forward,
                              std::abs(std::numbers::pi - (leaves_[j].angle_rad - leaves_[i].angle_rad)), i,
                              j});
    std::stable_sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
      return a.disagrees != b.disagrees ? b.disagrees : a.bend_rad < b.bend_rad;
    });
    for (const Candidate& c : candidates)
      if (opposite_[leaves_[c.i].half_edge] == kNone && opposite_[leaves_[c.j].half_edge] == kNone)
        join(leaves_[c.i].half_edge, leaves_[c.j].half_edge);
    remove_paired();
  }

  const WorkingMesh& mesh_;
  std::vector<std::uint32_t>& opposite_;
  std::vector<Leaf> leaves_;
};

}  // namespace

std::vector<std::uint32_t> pair_edges(WorkingMesh& mesh, const EdgeGroups& edges) {
  std::vector<std::uint32_t> opposite(3 * mesh.triangles.size(), kNone);
  CrowdedEdge crowded(mesh, opposite);
  edges.for_each([&](std::span<const GroupedHalfEdge> group) {
    if (group.size() < 2) return;
    if (group.size() == 2) {
      opposite[group[0].half_edge()] = group[1].half_edge();
      opposite[group[1].half_edge()] = group[0].half_edge();
      return;
    }
    if (mesh.report.non_manifold_edges == 0) {
      const std::uint32_t h = group[0].half_edge();
      mesh.note(fmt::format("the edge between vertices {} and {} has {} triangles", tail_of(mesh.stored, h),
                            head_of(mesh.stored, h), group.size()));
    }
    ++mesh.report.non_manifold_edges;
    mesh.report.non_manifold_edges_open += crowded.pair(group) > 0;
  });
  return opposite;
}

}  // namespace nmc::conditioning
