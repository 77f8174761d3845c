// SPDX-License-Identifier: Apache-2.0
#include "encoder/normal_mesh/vertex_system.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "encoder/core/parallel.h"

namespace nmc {

VertexSystem::VertexSystem(const LevelTopology& topology, const std::vector<FaceMatrix>& matrices) {
  diagonal_.assign(topology.vertex_count, 0);
  std::vector<double> of_edge(topology.edge_count, 0);
  for (std::uint32_t f = 0; f < topology.face_count; ++f) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      diagonal_[topology.face_vertices[3 * f + k]] += matrices[f][k];
      of_edge[topology.face_edges[3 * f + k]] += matrices[f][3 + k];
    }
  }
  first_.assign(topology.vertex_count + 1, 0);
  for (std::uint32_t i = 0; i < 2 * topology.edge_count; ++i) ++first_[topology.edge_vertices[i] + 1];
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  neighbors_.resize(std::size_t{2} * topology.edge_count);
  entries_.resize(neighbors_.size());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::uint32_t e = 0; e < topology.edge_count; ++e) {
    for (std::uint32_t end = 0; end < 2; ++end) {
      const std::uint32_t slot = next[topology.edge_vertices[2 * e + end]]++;
      neighbors_[slot] = topology.edge_vertices[2 * e + 1 - end];
      entries_[slot] = of_edge[e];
    }
  }
}

void VertexSystem::regularize(double share) {
  if (diagonal_.empty()) return;
  const double added = share * *std::max_element(diagonal_.begin(), diagonal_.end());
  for (double& d : diagonal_) d += added;
}

void VertexSystem::multiply(const std::vector<double>& x, std::vector<double>& result) const {
  result.resize(diagonal_.size());
  parallel_for(diagonal_.size(), [&](std::size_t i) {
    double sum = diagonal_[i] * x[i];
    for (std::uint32_t j = first_[i]; j < first_[i + 1]; ++j) sum += entries_[j] * x[neighbors_[j]];
    result[i] = sum;
  });
}

int VertexSystem::solve(const std::vector<double>& b, const ConjugateGradientOptions& options,
                        std::vector<double>& x) const {
  const std::size_t n = diagonal_.size();
  x.assign(n, 0);
  std::vector<double> residual = b, direction(n), image(n);
  const auto scaled = [this](std::size_t i, double value) {
    return diagonal_[i] > 0 ? value / diagonal_[i] : 0.0;
  };
  const auto energy = [&] {
    return parallel_sum<double>(n, [&](std::size_t i) { return residual[i] * scaled(i, residual[i]); });
  };
  parallel_for(n, [&](std::size_t i) { direction[i] = scaled(i, residual[i]); });
  double rho = energy();
  const double target = options.tolerance * options.tolerance * rho;
  int iteration = 0;
  for (; iteration < options.iteration_limit && rho > target; ++iteration) {
    multiply(direction, image);
    const double curvature = parallel_sum<double>(n, [&](std::size_t i) { return direction[i] * image[i]; });
    if (!(curvature > 0)) break;
    const double step = rho / curvature;
    parallel_for(n, [&](std::size_t i) {
      x[i] += step * direction[i];
      residual[i] -= step * image[i];
    });
    const double next_rho = energy();
    const double ratio = next_rho / rho;
    rho = next_rho;
    parallel_for(n, [&](std::size_t i) { direction[i] = scaled(i, residual[i]) + ratio * direction[i]; });
  }
  return iteration;
}

}  // namespace nmc
