// SPDX-License-Identifier: Apache-2.0
#include "encoder/normal_mesh/unconstrained_vector_mesh.h"

#include <utility>

#include "encoder/core/parallel.h"
#include "encoder/normal_mesh/curve_piercing.h"
#include "encoder/normal_mesh/parameter_prediction.h"

namespace nmc {

std::vector<Vec3> fit_vectors(const ParameterizedSurface& map, const LevelTopology& topology, int level,
                              std::span<const Vec3> positions, std::span<const SurfaceParameter> parameters,
                              const QuadratureOptions& quadrature, const ConjugateGradientOptions& solver) {
  const auto integrals = integrate_faces(map, topology, level, positions, parameters, quadrature);
  std::vector<VertexSystem::FaceMatrix> matrices(topology.face_count);
  std::vector<double> loads[3];
  for (auto& load : loads) load.assign(topology.vertex_count, 0);
  for (std::uint32_t f = 0; f < topology.face_count; ++f) {
    matrices[f] = integrals[f].mass;
    for (std::uint32_t k = 0; k < 3; ++k)
      for (int axis = 0; axis < 3; ++axis)
        loads[axis][topology.face_vertices[3 * f + k]] += integrals[f].load[k][axis];
  }
  const VertexSystem system(topology, matrices);
  std::vector<Vec3> result(topology.vertex_count);
  std::vector<double> solution;
  for (int axis = 0; axis < 3; ++axis) {
    system.solve(loads[axis], solver, solution);
    // A vertex whose faces all have no area is in no integral.
    for (std::uint32_t v = 0; v < topology.vertex_count; ++v)
      result[v][axis] = system.diagonal(v) > 0 ? solution[v] : positions[v][axis];
  }
  return result;
}

std::vector<SurfaceParameter> midpoint_parameters(const ParameterizedSurface& map,
                                                  const SubdivisionHierarchy& hierarchy,
                                                  const std::vector<SurfaceParameter>& base_parameters) {
  std::vector<SurfaceParameter> parameters = base_parameters;
  const std::vector<BaseCurve> curves = base_curves(map, hierarchy.level(0));
  for (int l = 0; l < hierarchy.level_count(); ++l) {
    const LevelTopology& topology = hierarchy.level(l);
    std::vector<SurfaceParameter> odd(topology.edge_count);
    parallel_for(topology.edge_count, [&](std::size_t i) {
      const auto edge = static_cast<std::uint32_t>(i);
      const SurfaceParameter& a = parameters[topology.edge_vertices[2 * edge]];
      if (topology.is_curve(edge)) {
        const BaseCurve& curve = curves[edge >> l];
        const SurfaceParameter& b = parameters[topology.edge_vertices[2 * edge + 1]];
        odd[i] = curve.parameter(map, 0.5 * (curve.share(map, a) + curve.share(map, b)));
        return;
      }
      const EdgeChart e =
          predict_parameter(map, topology, l, edge, parameters, ParameterPrediction::kMidpoint);
      odd[i] = e.valid ? map.from_chart(e.chart, e.midpoint) : a;
    });
    parameters.insert(parameters.end(), odd.begin(), odd.end());
  }
  return parameters;
}

std::vector<Vec3> sample_surface(const ParameterizedSurface& map,
                                 std::span<const SurfaceParameter> parameters) {
  std::vector<Vec3> positions(parameters.size());
  parallel_for(parameters.size(),
               [&](std::size_t i) { positions[i] = map.position(map.locate(parameters[i])); });
  return positions;
}

std::vector<std::vector<Vec3>> unconstrained_vector_mesh(const ParameterizedSurface& map,
                                                         const SubdivisionHierarchy& hierarchy,
                                                         std::span<const SurfaceParameter> parameters,
                                                         const QuadratureOptions& quadrature,
                                                         const ConjugateGradientOptions& solver) {
  const std::vector<Vec3> interpolating = sample_surface(map, parameters);
  std::vector<std::vector<Vec3>> levels;
  for (int l = 0; l <= hierarchy.level_count(); ++l)
    levels.push_back(fit_vectors(map, hierarchy.level(l), l, interpolating, parameters, quadrature, solver));
  return levels;
}

}  // namespace nmc
