// SPDX-License-Identifier: Apache-2.0
#include "encoder/normal_mesh/variational_normal_mesh.h"

#include <utility>

#include "encoder/core/parallel.h"
#include "libnmc/common/local_frame.h"

namespace nmc {

namespace {

/// A folded neighbourhood can make a row of the matrix vanish; this keeps it solvable and moves nothing else.
constexpr double kRegularization = 1e-9;

/// Area-weighted normals of the base vertices: their lines' directions.
std::vector<Vec3> base_normals(const LevelTopology& topology, const std::vector<Vec3>& positions) {
  TriangleMesh mesh;
  mesh.positions = positions;
  mesh.triangles = level_triangles(topology);
  return vertex_normals(mesh);
}

/// Steps 5 and 6: how far each vertex has to move along its direction.
std::vector<double> solve_along_lines(const ParameterizedSurface& map, const LevelTopology& topology,
                                      int level, const std::vector<Vec3>& positions,
                                      const std::vector<SurfaceParameter>& parameters,
                                      const std::vector<Vec3>& directions, const VariationalOptions& options,
                                      int& iterations) {
  const auto integrals = integrate_faces(map, topology, level, positions, parameters, options.quadrature);
  std::vector<VertexSystem::FaceMatrix> matrices(topology.face_count);
  std::vector<std::array<double, 3>> loads(topology.face_count);
  parallel_for(topology.face_count, [&](std::size_t f) {
    const std::uint32_t* v = topology.face_vertices.data() + 3 * f;
    const FaceIntegrals& sums = integrals[f];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
      matrices[f][k] = sums.mass[k];
      matrices[f][3 + k] = sums.mass[3 + k] * dot(directions[v[i]], directions[v[j]]);
      // The residual before the move: hat_k against R o p - S.
      const Vec3 present = sums.mass[k] * positions[v[k]] + sums.mass[3 + j] * positions[v[i]] +
                           sums.mass[3 + i] * positions[v[j]];
      loads[f][k] = dot(directions[v[k]], sums.load[k] - present);
    }
  });
  std::vector<double> right_hand_side(topology.vertex_count, 0);
  for (std::uint32_t f = 0; f < topology.face_count; ++f)
    for (std::uint32_t k = 0; k < 3; ++k) right_hand_side[topology.face_vertices[3 * f + k]] += loads[f][k];
  VertexSystem system(topology, matrices);
  system.regularize(kRegularization);
  std::vector<double> solution;
  iterations = system.solve(right_hand_side, options.solver, solution);
  return solution;
}

}  // namespace

double VariationalResult::non_normal_share() const {
  std::uint64_t non_normal_count = 0, all = 0;
  for (const LevelStatistics& level : levels) {
    non_normal_count += level.non_normal_count;
    all += level.vertex_count;
  }
  return all > 0 ? static_cast<double>(non_normal_count) / static_cast<double>(all) : 0;
}

VariationalResult variational_normal_mesh(const ParameterizedSurface& map, const SurfaceIndex& index,
                                          const ParameterizedBase& base, const VariationalOptions& options) {
  const int level_count = options.interpolating.level_count;
  VariationalResult result;
  result.hierarchy = SubdivisionHierarchy(base.faces, static_cast<std::uint32_t>(base.positions.size()),
                                          level_count, base.creases);
  result.parameters = base.parameters;
  std::vector<Vec3> positions = base.positions;
  result.directions = base_normals(result.hierarchy.level(0), positions);
  if (options.fit_base) {
    int iterations = 0;
    const std::vector<double> moves =
        solve_along_lines(map, result.hierarchy.level(0), 0, positions, base.parameters, result.directions,
                          options, iterations);
    for (std::size_t v = 0; v < positions.size(); ++v) positions[v] += moves[v] * result.directions[v];
  }
  result.positions.push_back(positions);
  result.coefficients.emplace_back();

  for (int l = 0; l < level_count; ++l) {
    const LevelTopology& coarse = result.hierarchy.level(l);
    const LevelTopology& fine = result.hierarchy.level(l + 1);
    LevelInsertion insertion =
        insert_level(map, index, result.hierarchy, l, positions, result.parameters, options.interpolating);
    std::vector<double> start(fine.vertex_count, 0);  // where the new vertices stand before the solve
    result.directions.resize(fine.vertex_count);
    parallel_for(coarse.edge_count, [&](std::size_t e) {
      result.directions[coarse.vertex_count + e] =
          odd_vertex_normal(coarse, static_cast<std::uint32_t>(e), positions.data());
      if (!insertion.non_normal[e]) start[coarse.vertex_count + e] = insertion.details[e].normal;
    });
    positions.insert(positions.end(), insertion.positions.begin(), insertion.positions.end());
    result.parameters.insert(result.parameters.end(), insertion.parameters.begin(),
                             insertion.parameters.end());

    int iterations = 0;
    std::vector<double> moves = solve_along_lines(map, fine, l + 1, positions, result.parameters,
                                                  result.directions, options, iterations);
    for (std::uint32_t v = 0; v < fine.vertex_count; ++v) {
      positions[v] += moves[v] * result.directions[v];
      moves[v] += start[v];
    }
    result.positions.push_back(positions);
    result.coefficients.push_back(std::move(moves));
    result.non_normal.push_back(std::move(insertion.non_normal));
    result.levels.push_back(insertion.statistics);
    result.solver_iterations.push_back(iterations);
  }
  return result;
}

}  // namespace nmc
