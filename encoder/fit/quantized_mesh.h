// SPDX-License-Identifier: Apache-2.0
// A normal mesh as integers, exactly as it is coded.
#ifndef NMC_ENCODER_FIT_QUANTIZED_MESH_H_
#define NMC_ENCODER_FIT_QUANTIZED_MESH_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "encoder/core/subdivision_hierarchy.h"
#include "libnmc/common/reconstruct.h"
#include "libnmc/common/vec3.h"

namespace nmc {

/// Base vertices lie at base_origin + base_step * coordinates. Connectivity is that of a SubdivisionHierarchy
/// with the same base mesh.
struct QuantizedMesh {
  Vec3 base_origin;
  double base_step = 1;
  std::vector<std::array<std::int32_t, 3>> base_coordinates;
  std::vector<LevelQuantizer> quantizers;                      // [l]
  std::vector<std::vector<std::int32_t>> normal;               // [l][e]: one per edge of level l
  std::vector<std::vector<TangentialCoefficient>> tangential;  // [l]: increasing edges, never both zero
  /// Levels that the decoder adds with zero coefficients.
  int smoothing_level_count = 0;

  int level_count() const { return static_cast<int>(normal.size()); }
  std::size_t nonzero_count() const;
};

/// Adds to the tangential part of `edge` in the list of its level, which stays in order. O(length of the list).
void change_tangential(std::uint32_t edge, std::int32_t along, std::int32_t across,
                       std::vector<TangentialCoefficient>& list);

/// Positions of the vertices of level `level`, the same bits as the decoder's. `hierarchy` must have that
/// many levels; levels beyond the coded ones are predicted with tension 1. O(vertices), parallel.
std::vector<Vec3> reconstruct(const QuantizedMesh& mesh, const SubdivisionHierarchy& hierarchy, int level);

}  // namespace nmc

#endif  // NMC_ENCODER_FIT_QUANTIZED_MESH_H_
