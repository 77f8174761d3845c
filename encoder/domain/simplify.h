// SPDX-License-Identifier: Apache-2.0
// Fewer triangles for the same surface, with nothing but the surface in mind.
//
// The collapses of maps_collapse.h keep input vertices and valences that a smooth map needs. Where a base mesh is
// nearly all that is coded, as on machine parts whose planes a few large triangles cover, that costs too many
// vertices. Here every collapse puts the merged vertex where the planes around it want it.
//
// Based on: Lindstrom, Turk, "Fast and memory efficient polygonal simplification" (1998), volume and boundary terms,
// without memory of the original; Hoppe, "New quadric metric" (1999), which found that it loses nothing.
#ifndef NMC_ENCODER_DOMAIN_SIMPLIFY_H_
#define NMC_ENCODER_DOMAIN_SIMPLIFY_H_

#include <vector>

#include "encoder/core/progress.h"
#include "encoder/core/triangle_mesh.h"
#include "encoder/domain/maps_collapse.h"

namespace nmc {

/// `mesh`, an oriented manifold, with as many vertices as asked, for each of `vertex_counts`, in their order: all of
/// one run. Topology and boundary loops stay; a count that cannot be reached gets the fewest vertices that can.
/// O(n log n), about 15 us per vertex removed. Deterministic.
std::vector<TriangleMesh> simplify(const TriangleMesh& mesh, const std::vector<int>& vertex_counts,
                                   const Progress& progress = {});

/// The surface of a run of collapses at one of its base sizes, vertices where the input has them.
TriangleMesh mesh_of_base(const CollapseHistory& history, std::size_t base_index);

}  // namespace nmc

#endif  // NMC_ENCODER_DOMAIN_SIMPLIFY_H_
