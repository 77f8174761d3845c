// SPDX-License-Identifier: Apache-2.0
#include "encoder/fit/hierarchy_comparison.h"

#include <utility>

#include "encoder/core/parallel.h"
#include "libnmc/common/local_frame.h"

namespace nmc {

namespace {

constexpr int kIterations = 60;

/// Samples on a level as samples on the next coarser one: the inverse of samples_on_next_level().
std::vector<SurfaceSample> samples_on_coarser_level(std::vector<SurfaceSample> samples) {
  parallel_for(samples.size(), [&](std::size_t i) {
    SurfaceSample& s = samples[i];
    const std::uint32_t child = s.face % 4;
    s.face /= 4;
    for (std::uint32_t k = 0; k < 3; ++k) {
      float& b = s.barycentric[k];
      b = child == 3 ? 0.5f * (1 - b) : child == k ? 0.5f * (1 + b) : 0.5f * b;
    }
  });
  return samples;
}

/// Re-projects and minimises again.
void follow(const GlobalFitOptions& options, const InputSurface* input, const LevelTopology& finest,
            const std::vector<Vec3>& directions, std::vector<SurfaceSample> samples,
            std::vector<Vec3>& positions) {
  QuadraticEnergy energy(finest);
  energy.assemble(samples, positions, options.energy);
  minimize_along_lines(energy, directions, kIterations, positions);
  for (int i = 0; input && i < options.reprojection_count; ++i) {
    reproject_samples(*input, finest, positions, options.reprojection, samples);
    energy.assemble(samples, positions, options.energy);
    minimize_along_lines(energy, directions, kIterations, positions);
  }
}

/// Where no point of its line would do, a vertex becomes non-normal: its own least squares would carry it
/// across the line by a fifth of an edge. Returns how many there are.
std::size_t free_misplaced_vertices(const QuadraticEnergy& energy, const std::vector<Vec3>& positions,
                                    std::vector<Vec3>& directions) {
  std::vector<Vec3> gradient;
  energy.gradient(positions, gradient);
  std::size_t count = 0;
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (squared_norm(directions[v]) == 0) continue;
    const SymmetricMatrix3& block = energy.diagonal_blocks()[v];
    const Vec3 across = gradient[v] - dot(directions[v], gradient[v]) * directions[v];
    const double length = norm(across);
    if (!(length > 0)) continue;
    const double stiffness = dot(across, block * across) / (length * length);
    double edge_sum = 0, edge_count = 0;
    for (std::uint32_t k = energy.neighbor_begin()[v]; k < energy.neighbor_begin()[v + 1]; ++k) {
      edge_sum += distance(positions[v], positions[energy.neighbors()[k].vertex]);
      edge_count += 1;
    }
    if (length * edge_count <= 0.2 * stiffness * edge_sum) continue;
    directions[v] = {};
    ++count;
  }

  return count;
}

}  // namespace

double minimize_along_lines(const QuadraticEnergy& energy, const std::vector<Vec3>& directions,
                            int maximum_iterations, std::vector<Vec3>& positions) {
  const std::size_t count = positions.size();
  // A change is a vector per vertex, kept on its line by projecting the residual.
  const auto project = [&](std::vector<Vec3>& v) {
    parallel_for(count, [&](std::size_t i) {
      if (squared_norm(directions[i]) > 0) v[i] = dot(directions[i], v[i]) * directions[i];
    });
  };
  const auto inner = [&](const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
    return parallel_sum<double>(count, [&](std::size_t i) { return dot(a[i], b[i]); });
  };
  std::vector<double> inverse(count);
  parallel_for(count, [&](std::size_t i) {
    const SymmetricMatrix3& block = energy.diagonal_blocks()[i];
    const double h = squared_norm(directions[i]) > 0 ? dot(directions[i], block * directions[i])
                                                     : (double{block.xx} + block.yy + block.zz) / 3;
    inverse[i] = h > 0 ? 1 / h : 0;
  });
  std::vector<Vec3> residual, z(count), direction, product;
  energy.gradient(positions, residual);
  for (Vec3& r : residual) r = -r;
  project(residual);
  const auto precondition = [&] {
    parallel_for(count, [&](std::size_t i) { z[i] = inverse[i] * residual[i]; });
  };
  precondition();
  direction = z;
  double rz = inner(residual, z);
  const double target = 1e-6 * rz;
  for (int iteration = 0; iteration < maximum_iterations && rz > target; ++iteration) {
    energy.multiply(direction, product);
    project(product);
    const double curvature = inner(direction, product);
    if (!(curvature > 0)) break;
    const double step = rz / curvature;
    parallel_for(count, [&](std::size_t i) {
      positions[i] += step * direction[i];
      residual[i] -= step * product[i];
    });
    precondition();
    const double next = inner(residual, z);
    const double ratio = next / rz;
    rz = next;
    parallel_for(count, [&](std::size_t i) { direction[i] = z[i] + ratio * direction[i]; });
  }
  return energy.value(positions);
}

std::vector<Vec3> variational_normal_mesh(const NormalMesh& mesh, const std::vector<SurfaceSample>& samples,
                                          const QuadraticEnergyOptions& options,
                                          std::vector<Vec3>& directions) {
  const int level_count = mesh.level_count();
  std::vector<std::vector<SurfaceSample>> by_level(static_cast<std::size_t>(level_count) + 1);
  by_level.back() = samples;
  for (std::size_t l = by_level.size() - 1; l > 0; --l)
    by_level[l - 1] = samples_on_coarser_level(by_level[l]);
  std::vector<Vec3> positions = mesh.base_positions;
  directions.assign(positions.size(), Vec3{});
  for (int l = 0;; ++l) {
    const LevelTopology& topology = mesh.hierarchy.level(l);
    QuadraticEnergy energy(topology);
    energy.assemble(by_level[static_cast<std::size_t>(l)], positions, options);
    minimize_along_lines(energy, directions, kIterations, positions);
    if (free_misplaced_vertices(energy, positions, directions) > 0)
      minimize_along_lines(energy, directions, kIterations, positions);
    if (l == level_count) return positions;
    const std::size_t vertex_count = topology.vertex_count;
    positions.resize(vertex_count + topology.edge_count);
    directions.resize(positions.size());
    parallel_for(topology.edge_count, [&](std::size_t e) {
      const auto edge = static_cast<std::uint32_t>(e);
      positions[vertex_count + e] =
          predict_odd_vertex(topology, mesh.hierarchy.ring_weights(), edge, {}, positions.data());
      const bool is_normal = !mesh.non_normal[static_cast<std::size_t>(l)][e] && !topology.is_curve(edge);
      directions[vertex_count + e] = is_normal ? odd_vertex_normal(topology, edge, positions.data()) : Vec3{};
    });
  }
}

HierarchyComparison compare_hierarchies(const GlobalFitOptions& options, const InputSurface* input,
                                        const std::vector<SurfaceSample>& samples, NormalMesh& mesh) {
  HierarchyComparison result;
  const int level_count = mesh.level_count();
  const LevelTopology& finest = mesh.hierarchy.level(level_count);
  result.interpolating = reconstruct(mesh, level_count);
  std::vector<Vec3> lines;
  result.variational = variational_normal_mesh(mesh, samples, options.energy, lines);
  follow(options, input, finest, lines, samples, result.variational);
  result.vectors = result.interpolating;
  follow(options, input, finest, std::vector<Vec3>(result.vectors.size()), samples, result.vectors);
  std::vector<SurfaceSample> fit_samples = samples;
  GlobalFitOptions fit = options;
  fit.reach_multiple = 0;
  global_fit(fit, input, fit_samples, mesh);
  result.fit = reconstruct(mesh, level_count);
  return result;
}

}  // namespace nmc
