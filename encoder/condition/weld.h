// SPDX-License-Identifier: Apache-2.0
// Finds vertices that are the same point, exactly or nearly.
//
// Based on: M. Teschner et al. Optimized spatial hashing for collision detection of deformable objects. VMV
// 2003.
#ifndef NMC_ENCODER_CONDITION_WELD_H_
#define NMC_ENCODER_CONDITION_WELD_H_

#include <cstdint>
#include <vector>

#include "encoder/condition/working_mesh.h"

namespace nmc::conditioning {

/// For each vertex with used[v] the lowest used vertex with equal coordinates (-0 equals +0), for others
/// itself. Expected O(n); 16 bytes per vertex.
std::vector<std::uint32_t> equal_vertices(const std::vector<Vec3>& positions,
                                          const std::vector<std::uint8_t>& used);

/// Welds vertices of open edges that are at most `radius` apart, each to the nearest earlier one. Interior
/// vertices are never welded: two walls closer than `radius` stay two walls. A weld that would collapse a
/// triangle is undone unless all its edges are shorter than 4 * radius. Returns for each vertex what it was
/// welded into (itself if not), or nothing when there was nothing to weld; triangles that now repeat a vertex
/// remain for the caller to drop. Expected O(n).
std::vector<std::uint32_t> weld_nearby(WorkingMesh& mesh, const EdgeGroups& edges, double radius);

/// The largest radius that is safe for the mesh: the smaller of `radius` and a tenth of the 0.1 % quantile of
/// the edge lengths. O(n).
double limited_weld_radius(const WorkingMesh& mesh, const EdgeGroups& edges, double radius);

}  // namespace nmc::conditioning

#endif  // NMC_ENCODER_CONDITION_WELD_H_
