// SPDX-License-Identifier: Apache-2.0
// Turns triangles so that neighbours agree, and opens edges across which that cannot be done.
#ifndef NMC_ENCODER_CONDITION_ORIENT_H_
#define NMC_ENCODER_CONDITION_ORIENT_H_

#include <cstdint>
#include <vector>

#include "encoder/condition/working_mesh.h"

namespace nmc::conditioning {

/// Afterwards every pair in `opposite` runs in opposite directions. Per connected piece the side that the
/// larger area has in the input wins. On a non-orientable piece the pairs on which a breadth-first walk from
/// its lowest triangle meets itself with the wrong side are opened; they form curves that cut the piece into
/// an orientable one. The walk does not depend on how triangles are stored, so doing it again opens the same
/// edges. O(n).
void orient(WorkingMesh& mesh, std::vector<std::uint32_t>& opposite);

/// Reverses the triangles with turn[t] != 0 in place: corners, stored corners and pairs.
void turn_triangles(WorkingMesh& mesh, std::vector<std::uint32_t>& opposite,
                    const std::vector<std::uint8_t>& turn);

}  // namespace nmc::conditioning

#endif  // NMC_ENCODER_CONDITION_ORIENT_H_
