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

/// An umbrella that passes the same edge twice, at both ends of the edge, would make four triangles meet on
/// one pair of vertices. Opened, such an umbrella falls apart into chains that begin and end on that edge,
/// one triangle each; a chain closes with its own end, and since a chain runs around its vertex in one
/// direction, the two ends run in opposite directions along the edge. Joining them leaves the umbrellas as
/// they are, so one round suffices.
bool exchange_pairs_of_doubled_edges(std::vector<std::uint32_t>& opposite) {
  std::vector<Triangle> corners = umbrella_corners(opposite);
  std::vector<std::uint32_t> doubled;
  EdgeGroups(corners, opposite.size()).for_each([&](std::span<const GroupedHalfEdge> group) {
    const std::uint32_t h = group[0].half_edge();
    if (group.size() == 1 || (group.size() == 2 && opposite[h] == group[1].half_edge())) return;
    for (const GroupedHalfEdge& entry : group) doubled.push_back(entry.half_edge());
  });
  if (doubled.empty()) return false;
  for (const std::uint32_t h : doubled) opposite[h] = kNone;
  corners = umbrella_corners(opposite);
  EdgeGroups(corners, opposite.size()).for_each([&](std::span<const GroupedHalfEdge> group) {
    if (group.size() != 2) return;
    const std::uint32_t a = group[0].half_edge(), b = group[1].half_edge();
    if (tail_of(corners, a) == tail_of(corners, b)) return;
    opposite[a] = b;
    opposite[b] = a;
  });
  return true;
}

}  // namespace

SplitVertices split_vertices(WorkingMesh& mesh, std::vector<std::uint32_t>& opposite) {
  if (mesh.report.non_manifold_edges > 0 || mesh.report.cut_edges > 0)
    exchange_pairs_of_doubled_edges(opposite);
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
  std::vector<std::uint8_t> met(input_vertex_count, 0);  // welded vertices whose splitting was counted
  for (std::uint32_t h = 0; h < opposite.size(); ++h) {
    if (umbrellas[h / 3][h % 3] != h || umbrella_vertex[h] != kNone) continue;
    const std::uint32_t stored = mesh.stored[h / 3][h % 3];
    umbrella_vertex[h] = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.push_back(mesh.positions[stored]);
    split.source.push_back(stored);
    if (mesh.report.split_vertices++ == 0) mesh.note(fmt::format("vertex {} joins several sheets", stored));
    const std::uint32_t welded = tail_of(mesh.triangles, h);
    mesh.report.non_manifold_vertices += !met[welded];
    met[welded] = 1;
  }
  split.welded.assign(mesh.positions.size(), kNone);
  for (std::uint32_t h = 0; h < opposite.size(); ++h) {
    std::uint32_t& vertex = mesh.triangles[h / 3][h % 3];
    const std::uint32_t renamed = umbrella_vertex[umbrellas[h / 3][h % 3]];
    split.welded[renamed] = vertex;
    vertex = renamed;
  }
  return split;
}

}  // namespace nmc::conditioning
