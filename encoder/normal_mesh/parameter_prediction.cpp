// SPDX-License-Identifier: Apache-2.0
#include "encoder/normal_mesh/parameter_prediction.h"

#include <cmath>

#include "libnmc/common/butterfly.h"

namespace nmc {

namespace {

bool is_regular(const LevelTopology& topology, std::uint32_t vertex) {
  return vertex >= topology.base_vertex_count;
}

/// The butterfly's answer minus the midpoint; false where the stencil cannot be laid out without a fold.
bool butterfly_correction(const ParameterizedSurface& map, const LevelTopology& topology, std::uint32_t edge,
                          std::span<const SurfaceParameter> parameters, const EdgeChart& e,
                          ChartPoint& correction) {
  using butterfly_internal::wing;
  const std::uint32_t a = topology.edge_vertices[2 * edge], b = topology.edge_vertices[2 * edge + 1];
  // A base vertex is a cone: the plane picture of its ring is not the butterfly's.
  if (!is_regular(topology, a) || !is_regular(topology, b)) return false;
  ChartPoint sum = e.a + e.b;
  for (int side = 0; side < 2; ++side) {
    const std::uint32_t face = topology.edge_faces[2 * edge + side];
    if (face == kNone) return false;
    const ChartPoint near[2] = {side == 0 ? e.a : e.b, side == 0 ? e.b : e.a};
    const std::uint32_t ids[2] = {side == 0 ? a : b, side == 0 ? b : a};
    ChartPoint c;
    const std::uint32_t tip = topology.opposite_vertex(edge, face);
    if (!map.to_chart(e.chart, parameters[tip], c)) return false;
    if (!(face_ratio(near[0], near[1], c) > 0)) return false;
    sum = sum + 0.25 * c;
    for (int end = 0; end < 2; ++end) {
      const std::uint32_t g = wing(topology, face, ids[1 - end]);
      if (g == kNone) return false;
      ChartPoint w;
      if (!map.to_chart(e.chart, parameters[g], w)) return false;
      const bool turns_left = end == 0 ? face_ratio(near[0], c, w) > 0 : face_ratio(c, near[1], w) > 0;
      if (!turns_left) return false;
      sum = sum - 0.125 * w;
    }
  }
  correction = 0.5 * sum - e.midpoint;
  return true;
}

}  // namespace

EdgeChart predict_parameter(const ParameterizedSurface& map, const LevelTopology& topology, int level,
                            std::uint32_t edge, std::span<const SurfaceParameter> parameters,
                            ParameterPrediction prediction) {
  EdgeChart e;
  const SurfaceParameter ends[2] = {parameters[topology.edge_vertices[2 * edge]],
                                    parameters[topology.edge_vertices[2 * edge + 1]]};
  ChartPoint at[2];
  if (!map.make_chart(topology.edge_faces[2 * edge] >> (2 * level), ends, e.chart, at)) return e;
  e.valid = true;
  e.a = at[0];
  e.b = at[1];
  e.midpoint = 0.5 * (e.a + e.b);
  e.half_length = 0.5 * std::sqrt(squared_length(e.b - e.a));
  e.predicted = e.midpoint;
  ChartPoint correction;
  if (prediction == ParameterPrediction::kButterfly &&
      butterfly_correction(map, topology, edge, parameters, e, correction) &&
      squared_length(correction) <= 0.25 * e.half_length * e.half_length) {
    e.predicted = e.midpoint + correction;
  }
  return e;
}

}  // namespace nmc
