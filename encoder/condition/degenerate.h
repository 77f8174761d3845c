// SPDX-License-Identifier: Apache-2.0
// Triangles that are no triangles, and triangles that are there twice.
#ifndef NMC_ENCODER_CONDITION_DEGENERATE_H_
#define NMC_ENCODER_CONDITION_DEGENERATE_H_

#include "encoder/condition/working_mesh.h"

namespace nmc::conditioning {

/// Drops triangles that repeat a vertex. O(n).
void drop_degenerate(WorkingMesh& mesh);

/// Drops triangles whose three corners are those of an earlier triangle, in either orientation, except where
/// that would open a surface that the file stores closed: two solids that touch in a face, each with its own
/// vertices, both keep that face. A closed surface that is there twice as a whole loses its later copy.
/// Returns the number dropped; `edges` is out of date when that is not zero. O(n).
std::size_t drop_duplicates(WorkingMesh& mesh, const EdgeGroups& edges);

}  // namespace nmc::conditioning

#endif  // NMC_ENCODER_CONDITION_DEGENERATE_H_
