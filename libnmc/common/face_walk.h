// SPDX-License-Identifier: Apache-2.0
// From face to face without comparing vertices: what lies where follows from which side of its face an edge
// is, and on which side of the edge the face.
//
// A face holds the edge opposite to its corner k from corner k + 1, the tail, to corner k + 2, the head: an
// edge whose left face it is forwards, another one backwards. The two faces of an edge run along it in
// opposite directions.
#ifndef NMC_COMMON_FACE_WALK_H_
#define NMC_COMMON_FACE_WALK_H_

#include <cstdint>

#include "libnmc/common/subdivision.h"

namespace nmc {

/// Corners of a face, 0 ... 2, counter-clockwise: two bits each out of a list, since nothing predicts a
/// branch.
inline std::uint32_t next_corner(std::uint32_t corner) { return (0x09u >> (2 * corner)) & 3u; }
inline std::uint32_t previous_corner(std::uint32_t corner) { return (0x12u >> (2 * corner)) & 3u; }

/// Which side of `face` is `edge`, by its opposite corner. The edge must belong to the face.
inline std::uint32_t side_of(const LevelTopology& topology, std::uint32_t edge, std::uint32_t face) {
  const std::uint32_t* edges = topology.face_edges.data() + std::size_t{3} * face;
  return (edges[1] == edge ? 1u : 0u) + (edges[2] == edge ? 2u : 0u);
}

/// One face of an edge, with what it holds at both ends of that edge: [0] at the first vertex.
struct EdgeSide {
  std::uint32_t face;       // kNone on a boundary; nothing else is set then
  std::uint32_t opposite;   // the corner opposite to the edge
  std::uint32_t corner[2];  // the corner at that end
  std::uint32_t other[2];   // the other edge of the face at that end
};

/// `side` 0 is the left face, in which the first vertex is the tail, 1 the right one, in which the second is.
inline EdgeSide edge_side(const LevelTopology& topology, std::uint32_t edge, std::uint32_t side) {
  EdgeSide result{topology.edge_faces[2 * edge + side], 0, {}, {}};
  if (result.face == kNone) return result;
  const std::uint32_t* edges = topology.face_edges.data() + std::size_t{3} * result.face;
  result.opposite = side_of(topology, edge, result.face);
  result.corner[side] = next_corner(result.opposite);
  result.corner[1 - side] = previous_corner(result.opposite);
  result.other[side] = edges[result.corner[1 - side]];
  result.other[1 - side] = edges[result.corner[side]];
  return result;
}

/// The face beyond an edge of a face; tail and head are those of the face that one comes from.
struct FaceBeyond {
  std::uint32_t face;                            // kNone: there is none; nothing else is set then
  std::uint32_t corner_at_tail, corner_at_head;  // the corners of that face at the ends of the edge,
  std::uint32_t edge_at_tail, edge_at_head;      // and its other edges there
};

inline FaceBeyond face_beyond(const LevelTopology& topology, std::uint32_t edge, std::uint32_t face) {
  FaceBeyond result{topology.face_across(edge, face), 0, 0, 0, 0};
  if (result.face == kNone) return result;
  const std::uint32_t* edges = topology.face_edges.data() + std::size_t{3} * result.face;
  const std::uint32_t side = side_of(topology, edge, result.face);
  result.corner_at_head = next_corner(side);
  result.corner_at_tail = previous_corner(side);
  result.edge_at_tail = edges[result.corner_at_head];
  result.edge_at_head = edges[result.corner_at_tail];
  return result;
}

/// The halves of the edges of a split face: that of `edge` at its tail in `face`, and that at its head.
inline std::uint32_t half_at_tail(const LevelTopology& topology, std::uint32_t edge, std::uint32_t face) {
  return 2 * edge + (topology.edge_faces[2 * edge] == face ? 0u : 1u);
}
inline std::uint32_t half_at_head(const LevelTopology& topology, std::uint32_t edge, std::uint32_t face) {
  return half_at_tail(topology, edge, face) ^ 1u;
}

}  // namespace nmc

#endif  // NMC_COMMON_FACE_WALK_H_
