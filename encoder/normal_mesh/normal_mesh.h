// SPDX-License-Identifier: Apache-2.0
// A normal mesh with real coefficients: what the encoder builds, fits and quantizes.
#ifndef NMC_ENCODER_NORMAL_MESH_NORMAL_MESH_H_
#define NMC_ENCODER_NORMAL_MESH_NORMAL_MESH_H_

#include <cstdint>
#include <vector>

#include "encoder/core/subdivision_hierarchy.h"
#include "encoder/core/triangle_mesh.h"

namespace nmc {

/// Detail of the odd vertex of one edge, in the frame of libnmc/common/local_frame.h. A normal vertex has
/// only the first component; on a boundary or crease the second, `across`, is free too.
struct OddVertexDetail {
  double normal = 0, across = 0, along = 0;
};

struct NormalMesh {
  std::vector<Vec3> base_positions;
  SubdivisionHierarchy hierarchy;                     // levels 0 ... L
  std::vector<std::vector<OddVertexDetail>> details;  // [l][e]: odd vertex of edge e of level l, l < L
  std::vector<std::vector<std::uint8_t>> non_normal;  // [l][e]: 1 where piercing found nothing
  std::vector<double> tension;  // [l]: share of the butterfly's correction; empty: all 1

  int level_count() const { return hierarchy.level_count(); }
};

/// Positions of the vertices of level `level` (all coarser ones come first, in the numbering of
/// libnmc/common/subdivision.h), by the decoder's own rules. O(vertices), parallel.
std::vector<Vec3> reconstruct(const NormalMesh& mesh, int level);

/// The odd vertices of one level from the positions of the coarser vertices: positions[0, V) in, [V, V + E)
/// out.
void reconstruct_level(const NormalMesh& mesh, int level, std::vector<Vec3>& positions);

}  // namespace nmc

#endif  // NMC_ENCODER_NORMAL_MESH_NORMAL_MESH_H_
