// SPDX-License-Identifier: Apache-2.0
// Gives every umbrella of triangles its own vertex.
//
// Based on: J. Rossignac, D. Cardoze. Matchmaker: manifold boundary representations for non-manifold shapes.
// ACM Solid Modeling 1999 (vertices follow from the matching of edges).
#ifndef NMC_ENCODER_CONDITION_SPLIT_VERTICES_H_
#define NMC_ENCODER_CONDITION_SPLIT_VERTICES_H_

#include <cstdint>
#include <vector>

#include "encoder/condition/working_mesh.h"

namespace nmc::conditioning {

/// All have one entry per vertex of the split mesh.
struct SplitVertices {
  std::vector<std::uint32_t> source;  // vertex of the input
  std::vector<std::uint32_t>
      welded;  // what the vertex was called before the split, when sheets still shared it
  std::vector<std::uint8_t> is_seam;  // another vertex has the same welded name: sheets touch here
};

/// Renames the corners of `mesh.triangles` so that two corners share a vertex exactly when pairs connect
/// them. An umbrella takes the first stored vertex of its corners that no earlier umbrella took, so what the
/// file kept apart stays apart under its own numbers; the others get copies appended to `mesh.positions`.
/// Where one umbrella would cross the same edge twice, which no indexed mesh can express, the pairs of that
/// edge are exchanged; that can happen only with `has_crowded_edges`. Triangles must be oriented. O(n).
SplitVertices split_vertices(WorkingMesh& mesh, std::vector<std::uint32_t>& opposite, bool has_crowded_edges);

}  // namespace nmc::conditioning

#endif  // NMC_ENCODER_CONDITION_SPLIT_VERTICES_H_
