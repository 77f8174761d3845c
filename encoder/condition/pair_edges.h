// SPDX-License-Identifier: Apache-2.0
// Decides which triangles continue into which across every edge, also where more than two meet.
//
// Based on: A. Gueziec, G. Taubin, F. Lazarus, B. Horn. Cutting and stitching: converting sets of polygons to
// manifold surfaces. IEEE TVCG 2001 (stitching chosen per edge); pairing by angle around the edge.
#ifndef NMC_ENCODER_CONDITION_PAIR_EDGES_H_
#define NMC_ENCODER_CONDITION_PAIR_EDGES_H_

#include <cstdint>
#include <vector>

#include "encoder/condition/working_mesh.h"

namespace nmc::conditioning {

/// The partner of every half-edge, or kNone for an open one. Edges with two triangles are pairs. Around an
/// edge with more, in this order:
///   1. triangles that alone share the edge's stored vertices in the file stay together;
///   2. where the rest alternates in orientation around the edge, it bounds wedges of material, and the two
///   sides of
///      each wedge are paired: solids that touch along an edge come apart;
///   3. otherwise the flattest pairs go first, those of agreeing orientation before the others: crossing
///   sheets
///      pass through each other;
///   4. what is left over is open.
/// O(n + sum of k^2 over edges with k > 2 triangles).
std::vector<std::uint32_t> pair_edges(WorkingMesh& mesh, const EdgeGroups& edges);

}  // namespace nmc::conditioning

#endif  // NMC_ENCODER_CONDITION_PAIR_EDGES_H_
