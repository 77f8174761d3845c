// SPDX-License-Identifier: Apache-2.0
#include "encoder/condition/split_vertices.h"

#include <fmt/format.h>

#include <numeric>

#include "encoder/condition/disjoint_sets.h"

namespace nmc::conditioning {

namespace {

/// The triangles with every corner named after the lowest corner of its umbrella.
std::vector<Triangle> umbrella_corners(const std::vector<std::uint32_t>& opposite) {
  DisjointSets umbrellas(opposite.size());
  for (std::uint32_t h = 0; h < opposite.size(); ++h) {
    if (opposite[h] == kNone || opposite[h] < h) continue;
    // The two half-edges of a pair run in opposite directions: the tail of one is the head of the other.
    umbrellas.unite(h, next_half_edge(opposite[h]));
    umbrellas.unite(next_half_edge(h), opposite[h]);
  }
  std::vector<Triangle> corners(opposite.size() / 3);
  for (std::uint32_t h = 0; h < opposite.size(); ++h) corners[h / 3][h % 3] = umbrellas.find(h);
  return corners;
}

/// An umbrella that passes the same edge twice, at both ends of the edge, would make more than two triangles
/// meet on one pair of vertices. Going around a vertex with the orientation, an umbrella always crosses an
/// edge from the triangle that ends there to the one that starts there; so exchanging the partners of the two
/// crossings splits it into two umbrellas, at both ends of the edge, and keeps every pair oriented. Each
/// exchange raises the number of umbrellas, hence the loop ends.
class DoubledEdges {
 public:
  explicit DoubledEdges(std::vector<std::uint32_t>& opposite) : opposite_(opposite) {}

  void separate() {
    const std::vector<Triangle> corners = umbrella_corners(opposite_);
    EdgeGroups(corners, opposite_.size()).for_each([&](std::span<const GroupedHalfEdge> group) {
      if (group.size() == 1 || (group.size() == 2 && opposite_[group[0].half_edge()] == group[1].half_edge()))
        return;
      // Half-edges that run one way and those that run the other way; an umbrella meets one of each per
      // crossing.
      std::vector<std::uint32_t> forward, backward;
      for (const GroupedHalfEdge& entry : group) {
        const std::uint32_t h = entry.half_edge();
        (tail_of(corners, h) == tail_of(corners, group[0].half_edge()) ? forward : backward).push_back(h);
      }
      for (const std::vector<std::uint32_t>* list : {&forward, &backward})
        for (std::size_t i = 0; i < list->size(); ++i)
          for (std::size_t j = i + 1; j < list->size(); ++j) exchange_if_doubled((*list)[i], (*list)[j]);
      for (const std::uint32_t a : forward)
        for (const std::uint32_t b : backward) join_if_doubled(a, b);
    });
  }

 private:
  bool share_umbrella(std::uint32_t corner_a, std::uint32_t corner_b) const {
    bool found = false;
    for_each_in_umbrella(opposite_, corner_a,
                         [&](std::uint32_t corner) { found = found || corner == corner_b; });
    return found;
  }

  void exchange_if_doubled(std::uint32_t a, std::uint32_t b) {
    if (!share_umbrella(a, b) || !share_umbrella(next_half_edge(a), next_half_edge(b))) return;
    const std::uint32_t partner_a = opposite_[a], partner_b = opposite_[b];
    opposite_[a] = partner_b;
    opposite_[b] = partner_a;
    if (partner_a != kNone) opposite_[partner_a] = b;
    if (partner_b != kNone) opposite_[partner_b] = a;
  }

  /// Two open half-edges on one pair of vertices are the ends of one chain; it closes.
  void join_if_doubled(std::uint32_t a, std::uint32_t b) {
    if (opposite_[a] != kNone || opposite_[b] != kNone) return;
    if (!share_umbrella(a, next_half_edge(b)) || !share_umbrella(next_half_edge(a), b)) return;
    opposite_[a] = b;
    opposite_[b] = a;
  }

  std::vector<std::uint32_t>& opposite_;
};

}  // namespace

SplitVertices split_vertices(WorkingMesh& mesh, std::vector<std::uint32_t>& opposite,
                             bool has_crowded_edges) {
  if (has_crowded_edges) DoubledEdges(opposite).separate();
  const std::vector<Triangle> umbrellas = umbrella_corners(opposite);
  const std::size_t input_vertex_count = mesh.positions.size();

  std::vector<std::uint32_t> umbrella_vertex(opposite.size(),
                                             kNone);  // at the lowest corner of each umbrella
  std::vector<std::uint8_t> taken(input_vertex_count, 0);
  for (std::uint32_t h = 0; h < opposite.size(); ++h) {
    std::uint32_t& vertex = umbrella_vertex[umbrellas[h / 3][h % 3]];
    const std::uint32_t stored = mesh.stored[h / 3][h % 3];
    if (vertex != kNone || taken[stored]) continue;
    vertex = stored;
    taken[stored] = 1;
  }
  SplitVertices split;
  split.source.resize(input_vertex_count);
  std::iota(split.source.begin(), split.source.end(), 0u);
  for (std::uint32_t h = 0; h < opposite.size(); ++h) {
    if (umbrellas[h / 3][h % 3] != h || umbrella_vertex[h] != kNone) continue;
    const std::uint32_t stored = mesh.stored[h / 3][h % 3];
    umbrella_vertex[h] = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.push_back(mesh.positions[stored]);
    split.source.push_back(stored);
    mesh.note(Defect::kManySheets, [&] { return fmt::format("vertex {} joins several sheets", stored); });
  }
  split.welded.assign(mesh.positions.size(), kNone);
  std::vector<std::uint32_t> copies(input_vertex_count, 0);
  for (std::uint32_t h = 0; h < opposite.size(); ++h) {
    std::uint32_t& vertex = mesh.triangles[h / 3][h % 3];
    const std::uint32_t renamed = umbrella_vertex[umbrellas[h / 3][h % 3]];
    copies[vertex] += split.welded[renamed] == kNone;
    split.welded[renamed] = vertex;
    vertex = renamed;
  }
  split.is_seam.resize(mesh.positions.size());
  for (std::size_t v = 0; v < split.is_seam.size(); ++v)
    split.is_seam[v] = split.welded[v] != kNone && copies[split.welded[v]] > 1;
  return split;
}

}  // namespace nmc::conditioning
