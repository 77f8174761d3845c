// SPDX-License-Identifier: Apache-2.0
// Closes cracks where a vertex of one triangle lies inside an edge of its neighbour.
//
// Based on: G. Barequet, S. Kumar. Repairing CAD models. IEEE Visualization 1997 (the edge-vertex case only).
#ifndef NMC_ENCODER_CONDITION_T_JUNCTIONS_H_
#define NMC_ENCODER_CONDITION_T_JUNCTIONS_H_

#include "encoder/condition/working_mesh.h"

namespace nmc::conditioning {

/// Splits open edges at the vertices of other open edges that lie within `radius` of their inside, where that
/// gives at least one of the parts a partner: a mere contact is left alone. Nothing moves. Returns the number
/// of vertices inserted into edges; `edges` is out of date when that is not zero. Expected O(n) for n open
/// edges.
std::size_t close_t_junctions(WorkingMesh& mesh, const EdgeGroups& edges, double radius);

}  // namespace nmc::conditioning

#endif  // NMC_ENCODER_CONDITION_T_JUNCTIONS_H_
