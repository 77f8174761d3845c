// SPDX-License-Identifier: Apache-2.0
// Where in the domain an odd vertex is expected, before anything is pierced.
//
// Based on: Friedel, section 2.3 (parametric midpoint); the same butterfly stencil that predicts positions,
// applied to unfolded parameters, follows the reparameterization to the next order.
#ifndef NMC_ENCODER_NORMAL_MESH_PARAMETER_PREDICTION_H_
#define NMC_ENCODER_NORMAL_MESH_PARAMETER_PREDICTION_H_

#include <cstdint>
#include <span>

#include "encoder/core/subdivision_hierarchy.h"
#include "encoder/normal_mesh/parameterized_surface.h"

namespace nmc {

enum class ParameterPrediction { kMidpoint, kButterfly };

/// An edge of the normal mesh in the domain.
struct EdgeChart {
  bool valid = false;  // false: the ends are too far apart to be laid out together
  LocalChart chart;
  ChartPoint a, b;       // the ends
  ChartPoint midpoint;   // of the two
  ChartPoint predicted;  // the midpoint, or the butterfly's answer where it can be trusted
  double half_length = 0;
};

/// `parameters` are those of the vertices of `topology`, which is that of `level`. The butterfly is used only
/// where every triangle of its stencil unfolds counter-clockwise in one chart (so not around cones) and its
/// answer stays within half of half_length of the midpoint. O(1).
EdgeChart predict_parameter(const ParameterizedSurface& map, const LevelTopology& topology, int level,
                            std::uint32_t edge, std::span<const SurfaceParameter> parameters,
                            ParameterPrediction prediction);

}  // namespace nmc

#endif  // NMC_ENCODER_NORMAL_MESH_PARAMETER_PREDICTION_H_
