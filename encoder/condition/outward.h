// SPDX-License-Identifier: Apache-2.0
// Turns closed components that are inside out.
#ifndef NMC_ENCODER_CONDITION_OUTWARD_H_
#define NMC_ENCODER_CONDITION_OUTWARD_H_

#include <cstdint>
#include <vector>

#include "encoder/condition/working_mesh.h"

namespace nmc::conditioning {

/// A closed component that lies in no other closed one encloses material, so it is turned when its volume is
/// negative. One that lies inside another may be the wall of a cavity or a part in a housing: only its author
/// knows, so it keeps its side relative to the outermost component around it and is turned exactly when that
/// one is. Open components keep their side. Whether one lies inside another is decided by the parity of three
/// rays. Returns the components that were turned, as in find_pieces(). O(n log n).
std::vector<std::uint8_t> turn_outward(WorkingMesh& mesh, std::vector<std::uint32_t>& opposite);

}  // namespace nmc::conditioning

#endif  // NMC_ENCODER_CONDITION_OUTWARD_H_
