// SPDX-License-Identifier: Apache-2.0
// Fill-reducing elimination order for matrices on a mesh of the sphere.
//
// Based on: A. George, "Nested Dissection of a Regular Finite Element Mesh", SIAM J. Numer. Anal. 10, 1973,
// with planes through the vertices' own positions as separators.
#ifndef NMC_ENCODER_SPHERE_NESTED_DISSECTION_H_
#define NMC_ENCODER_SPHERE_NESTED_DISSECTION_H_

#include <cstdint>
#include <vector>

#include "encoder/sphere/sphere_problem.h"

namespace nmc {

/// One set of vertices eliminated together. Nodes are stored children before parents; the last one is the
/// root.
struct DissectionNode {
  std::vector<std::uint32_t> vertices;
  std::int32_t child[2] = {-1, -1};
  std::int32_t parent = -1;
};

/// Every vertex is in exactly one node, and neighbors are in nodes of which one is an ancestor of (or equal
/// to) the other. `positions` only steer the cuts. O(n log n), deterministic.
std::vector<DissectionNode> nested_dissection(const VertexGraph& graph, const std::vector<Vec3>& positions,
                                              std::uint32_t leaf_vertex_count = 24);

}  // namespace nmc

#endif  // NMC_ENCODER_SPHERE_NESTED_DISSECTION_H_
