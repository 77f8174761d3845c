// SPDX-License-Identifier: Apache-2.0
// Removes triangles without area from a manifold without opening holes.
//
// Based on: M. Botsch, L. Kobbelt. A robust procedure to eliminate degenerate faces from triangle meshes. VMV
// 2001 (needles and caps).
#ifndef NMC_ENCODER_CONDITION_SLIVERS_H_
#define NMC_ENCODER_CONDITION_SLIVERS_H_

#include <cstdint>
#include <vector>

#include "encoder/condition/working_mesh.h"

namespace nmc::conditioning {

/// A sliver has an area below 1e-12 of its longest edge squared: its normal is noise even in double
/// precision. Needles (one short edge) lose their short edge where the link condition allows it; caps (an
/// obtuse corner on the longest edge) have the longest edge flipped, or are taken away where that edge is a
/// boundary. What cannot be done without a topological change or a turned neighbour is left and counted.
/// `mesh` and `opposite` must be an oriented manifold and remain one. O(n) when there is none, O(n + slivers
/// * valence) otherwise.
/// Returns the number of slivers treated.
std::size_t remove_slivers(WorkingMesh& mesh, std::vector<std::uint32_t>& opposite,
                           const std::vector<std::uint8_t>& is_seam);

}  // namespace nmc::conditioning

#endif  // NMC_ENCODER_CONDITION_SLIVERS_H_
