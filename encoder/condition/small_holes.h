// SPDX-License-Identifier: Apache-2.0
// Fills small holes with the triangulation that bends least.
//
// Based on: P. Liepa. Filling holes in meshes. SGP 2003, §3 (minimum-weight triangulation; no refinement or
// fairing, because the holes filled here are smaller than what the codec resolves).
#ifndef NMC_ENCODER_CONDITION_SMALL_HOLES_H_
#define NMC_ENCODER_CONDITION_SMALL_HOLES_H_

#include <cstdint>
#include <vector>

#include "encoder/condition/working_mesh.h"

namespace nmc::conditioning {

/// Fills every boundary loop that `options` calls small; new triangles are appended with source kFilledHole.
/// A loop is left open when every triangulation of it would repeat an edge of the mesh or hold a sliver.
/// `mesh` and `opposite` must be an oriented manifold and remain one. O(n + sum of edges^3 over the loops
/// filled).
void fill_small_holes(WorkingMesh& mesh, std::vector<std::uint32_t>& opposite,
                      const std::vector<std::uint8_t>& is_seam, const ConditionOptions& options);

}  // namespace nmc::conditioning

#endif  // NMC_ENCODER_CONDITION_SMALL_HOLES_H_
