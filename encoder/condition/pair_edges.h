// SPDX-License-Identifier: Apache-2.0
// Decides which triangles continue into which across every edge, also where more than two meet, and orients
// them.
//
// Based on: A. Gueziec, G. Taubin, F. Lazarus, B. Horn. Cutting and stitching: converting sets of polygons to
// manifold surfaces. IEEE TVCG 2001 (stitching chosen per edge); pairing by angle around the edge.
#ifndef NMC_ENCODER_CONDITION_PAIR_EDGES_H_
#define NMC_ENCODER_CONDITION_PAIR_EDGES_H_

#include <cstdint>
#include <vector>

#include "encoder/condition/working_mesh.h"

namespace nmc::conditioning {

struct PairedEdges {
  std::vector<std::uint32_t> pairs;    // the partner of every half-edge, or kNone for an open one
  std::size_t crowded_edges = 0;       // edges with more than two triangles
  std::size_t crowded_edges_open = 0;  // of these, with a triangle left without a partner
  std::size_t cut_edges = 0;           // opened because the surface cannot be oriented across them
  std::size_t non_orientable_pieces = 0;
};

/// Pairs all half-edges and turns triangles of `mesh` so that the two half-edges of every pair run in
/// opposite directions. In this order:
///   1. An edge with two triangles is a pair, and so are two triangles that alone share the stored
///      vertices of a crowded edge (one with more than two): whoever wrote the file joined them.
///   2. Pairs across which the surface cannot be oriented are opened (open_contradictory_pairs), and all
///      are oriented.
///   3. Where the remaining triangles of a crowded edge alternate in orientation, they bound wedges of
///      material, and the two sides of each wedge are paired: solids that touch along an edge come apart.
///      Elsewhere the flattest pairs of agreeing orientation go first: crossing sheets pass through.
///   4. Pairs that do not agree, flattest first, where that only means to turn a whole piece around.
///   5. What is left over is open.
/// A second run on the result changes nothing: it finds all pairs in step 1, and what was left in step 5
/// is left again. Edges with hundreds of open triangles skip the searches for flat pairs. O(n log n).
PairedEdges pair_edges(WorkingMesh& mesh, const EdgeGroups& edges);

}  // namespace nmc::conditioning

#endif  // NMC_ENCODER_CONDITION_PAIR_EDGES_H_
