// SPDX-License-Identifier: Apache-2.0
// The frame in which the detail of an odd vertex is written (spec 6.3).
#ifndef NMC_COMMON_LOCAL_FRAME_H_
#define NMC_COMMON_LOCAL_FRAME_H_

#include "libnmc/common/subdivision.h"
#include "libnmc/common/vec3.h"

namespace nmc {

/// Orthonormal. `along` points from the edge's first to its second vertex; `across` = normal x along points into the
/// left face. On a boundary edge `across` is the conormal.
struct LocalFrame {
  Vec3 normal, along, across;
};

/// Normal of the odd vertex of `edge`: that of the quad (a, d, b, c) around the edge, of the one face on a boundary;
/// (0, 0, 1) where it vanishes. Bits are normative.
inline Vec3 odd_vertex_normal(const LevelTopology& topology, std::uint32_t edge, const Vec3* x) {
  const Vec3& a = x[topology.edge_vertices[2 * edge]];
  const Vec3& b = x[topology.edge_vertices[2 * edge + 1]];
  const std::uint32_t left = topology.edge_faces[2 * edge], right = topology.edge_faces[2 * edge + 1];
  const Vec3& c = x[topology.opposite_vertex(edge, left)];
  const Vec3 down = right == kNone ? a : x[topology.opposite_vertex(edge, right)];
  return normalized(cross(b - a, c - down));
}

inline LocalFrame odd_vertex_frame(const LevelTopology& topology, std::uint32_t edge, const Vec3* x) {
  LocalFrame frame;
  frame.normal = odd_vertex_normal(topology, edge, x);
  const Vec3 direction = x[topology.edge_vertices[2 * edge + 1]] - x[topology.edge_vertices[2 * edge]];
  frame.along = normalized(direction, {1, 0, 0});
  frame.across = cross(frame.normal, frame.along);
  return frame;
}

}  // namespace nmc

#endif  // NMC_COMMON_LOCAL_FRAME_H_
