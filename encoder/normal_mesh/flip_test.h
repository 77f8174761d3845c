// SPDX-License-Identifier: Apache-2.0
// Keeps the reparameterization free of folds: Figure 2.5, step 3, "reject if a new triangle is flipped".
#ifndef NMC_ENCODER_NORMAL_MESH_FLIP_TEST_H_
#define NMC_ENCODER_NORMAL_MESH_FLIP_TEST_H_

#include <cstdint>
#include <span>
#include <vector>

#include "encoder/normal_mesh/parameterized_surface.h"

namespace nmc {

/// Where the parameter of an odd vertex comes from. Later ones are safer.
enum class OddVertexSource : std::uint8_t { kPierced, kPredicted, kMidpoint };

struct OddVertexChoice {
  SurfaceParameter parameter;
  OddVertexSource source = OddVertexSource::kMidpoint;
  SurfaceParameter predicted, midpoint;  // what to fall back to
};

struct FlipTestResult {
  std::uint32_t demoted_count = 0;      // vertices that fell back
  std::uint32_t folded_face_count = 0;  // parents without positive area: nothing to keep for them
};

/// Demotes choices (one per edge) until every child face has at least `least_child_area` of its parent's area
/// in the domain. Of a face that fails, the vertex that lies farthest from its edge's midpoint is demoted one
/// step. A face whose three vertices are all midpoints cannot fail: its children are four quarters.
/// Deterministic: each round judges all faces on the same state. Parallel over faces.
FlipTestResult resolve_flips(const ParameterizedSurface& map, const LevelTopology& topology, int level,
                             std::span<const SurfaceParameter> parameters, double least_child_area,
                             std::vector<OddVertexChoice>& choices);

}  // namespace nmc

#endif  // NMC_ENCODER_NORMAL_MESH_FLIP_TEST_H_
