// SPDX-License-Identifier: Apache-2.0
// Half-edges of a plain triangle list, and all triangles around every edge, manifold or not.
//
// Half-edge h = 3 * triangle + corner runs from that corner to the next one of its triangle. The same number
// also names the corner it starts at. A half-edge library such as OpenMesh cannot hold what this room
// receives (edges with any number of triangles, any orientation), and on 3 M triangles these arrays take 36
// bytes per triangle where OpenMesh takes about 200.
#ifndef NMC_ENCODER_CONDITION_HALF_EDGES_H_
#define NMC_ENCODER_CONDITION_HALF_EDGES_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "encoder/core/triangle_mesh.h"

namespace nmc::conditioning {

inline constexpr std::uint32_t kNone = 0xffffffffu;

inline std::uint32_t triangle_of(std::uint32_t half_edge) { return half_edge / 3; }
inline std::uint32_t next_half_edge(std::uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
inline std::uint32_t previous_half_edge(std::uint32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }
inline std::uint32_t tail_of(const std::vector<Triangle>& triangles, std::uint32_t h) {
  return triangles[h / 3][h % 3];
}
inline std::uint32_t head_of(const std::vector<Triangle>& triangles, std::uint32_t h) {
  return triangles[h / 3][(h + 1) % 3];
}
/// The corner of the half-edge's triangle that is not on the edge.
inline std::uint32_t apex_of(const std::vector<Triangle>& triangles, std::uint32_t h) {
  return triangles[h / 3][(h + 2) % 3];
}

/// One half-edge of an edge group, ordered by the higher vertex of its edge, then by its own number.
struct GroupedHalfEdge {
  std::uint64_t key;  // higher vertex in the upper 32 bits, half-edge in the lower
  std::uint32_t half_edge() const { return static_cast<std::uint32_t>(key); }
  std::uint32_t higher_vertex() const { return static_cast<std::uint32_t>(key >> 32); }
  bool operator<(const GroupedHalfEdge& other) const { return key < other.key; }
};

/// The half-edges of a triangle list grouped by undirected edge. No triangle may repeat a vertex.
/// O(n log d) for n triangles and at most d edges at one vertex; 24 bytes per triangle and 4 per vertex.
class EdgeGroups {
 public:
  EdgeGroups(const std::vector<Triangle>& triangles, std::size_t vertex_count);

  /// Calls body(std::span<const GroupedHalfEdge>) once per edge, ordered by (lower vertex, higher vertex);
  /// the half-edges of a span ascend.
  template <class Body>
  void for_each(const Body& body) const {
    for (std::size_t v = 0; v + 1 < first_.size(); ++v) for_each_at(static_cast<std::uint32_t>(v), body);
  }

  /// The same for the edges whose lower vertex is `v`; may run concurrently for different vertices.
  template <class Body>
  void for_each_at(std::uint32_t v, const Body& body) const {
    const std::size_t end = first_[v + 1];
    for (std::size_t i = first_[v]; i < end;) {
      std::size_t j = i + 1;
      while (j < end && entries_[j].higher_vertex() == entries_[i].higher_vertex()) ++j;
      body(std::span<const GroupedHalfEdge>(&entries_[i], j - i));
      i = j;
    }
  }

 private:
  std::vector<std::uint32_t> first_;
  std::vector<GroupedHalfEdge> entries_;
};

/// For a mesh in which every edge has one or two triangles: the other half-edge of the edge, kNone on a
/// boundary. Edges with more triangles get kNone everywhere.
std::vector<std::uint32_t> opposite_half_edges(const std::vector<Triangle>& triangles,
                                               std::size_t vertex_count);

/// Calls body(half_edge) for every half-edge that starts at the vertex of corner `start`, over the whole
/// umbrella: first with the orientation of the surface until it closes or ends at a boundary, then the other
/// way from `start`. Needs consistently oriented triangles.
template <class Body>
void for_each_in_umbrella(const std::vector<std::uint32_t>& opposite, std::uint32_t start, const Body& body) {
  std::uint32_t h = start;
  do {
    body(h);
    h = opposite[previous_half_edge(h)];
  } while (h != kNone && h != start);
  if (h == start) return;
  for (h = opposite[start]; h != kNone; h = opposite[h]) {
    h = next_half_edge(h);
    body(h);
  }
}

}  // namespace nmc::conditioning

#endif  // NMC_ENCODER_CONDITION_HALF_EDGES_H_
