// SPDX-License-Identifier: Apache-2.0
#include "encoder/sphere/trust_region_newton.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "encoder/core/parallel.h"

namespace nmc {

namespace {

using TangentField = std::vector<Tangent2>;

void add_scaled(TangentField& a, double scale, const TangentField& b) {
  parallel_for(a.size(), [&](std::size_t i) {
    a[i][0] += scale * b[i][0];
    a[i][1] += scale * b[i][1];
  });
}

// The norm that shapes the trust region, and its inverse as a preconditioner: 2 x 2 blocks, positive
// definite.
class BlockNorm {
 public:
  BlockNorm(const BlockMatrix& matrix, bool is_identity) {
    blocks_.assign(matrix.diagonal.size(), {1, 0, 1});
    if (is_identity) return;
    const double scale = matrix.mean_diagonal();
    for (std::size_t v = 0; v < blocks_.size(); ++v) {
      auto [xx, xy, yy] = matrix.diagonal[v];
      // Eigenvalues below a thousandth of the mean are raised to it: the norm has to stay equivalent to a
      // plain one.
      const double mean = (xx + yy) / 2, radius = std::hypot((xx - yy) / 2, xy);
      const double raise = std::max(0.0, 1e-3 * scale - (mean - radius));
      blocks_[v] = {(xx + raise) / scale, xy / scale, (yy + raise) / scale};
    }
  }

  TangentField apply(const TangentField& a) const {
    TangentField result(a.size());
    parallel_for(a.size(), [&](std::size_t i) {
      const auto& b = blocks_[i];
      result[i] = {b[0] * a[i][0] + b[1] * a[i][1], b[1] * a[i][0] + b[2] * a[i][1]};
    });
    return result;
  }
  TangentField apply_inverse(const TangentField& a) const {
    TangentField result(a.size());
    parallel_for(a.size(), [&](std::size_t i) {
      const auto& b = blocks_[i];
      const double determinant = b[0] * b[2] - b[1] * b[1];
      result[i] = {(b[2] * a[i][0] - b[1] * a[i][1]) / determinant,
                   (b[0] * a[i][1] - b[1] * a[i][0]) / determinant};
    });
    return result;
  }

 private:
  std::vector<std::array<double, 3>> blocks_;
};

struct TruncatedSolution {
  TangentField step;
  bool on_boundary = false;
};

// Steihaug and Toint: conjugate gradients until the residual is small, the curvature negative, or the border
// of the region reached. Norms and scalar products are those of `metric`.
TruncatedSolution solve_in_region(const VertexGraph& graph, const BlockMatrix& hessian,
                                  const BlockNorm& metric, const TangentField& gradient, double radius,
                                  double relative_residual, long& products) {
  TruncatedSolution solution;
  solution.step.assign(gradient.size(), {0, 0});
  TangentField residual = gradient;
  TangentField preconditioned = metric.apply_inverse(residual);
  TangentField direction(gradient.size(), {0, 0});
  add_scaled(direction, -1, preconditioned);
  double energy_product = dot(residual, preconditioned);
  const double stop = relative_residual * relative_residual * dot(gradient, gradient);
  TangentField image;
  const int limit = 2 * static_cast<int>(std::min<std::size_t>(gradient.size(), 5000)) + 10;
  for (int iteration = 0; iteration < limit; ++iteration) {
    hessian.multiply(graph, direction, image);
    ++products;
    const double curvature = dot(direction, image);
    const double alpha = energy_product / curvature;
    const TangentField metric_direction = metric.apply(direction);
    const double dd = dot(direction, metric_direction), sd = dot(solution.step, metric_direction);
    const double ss = dot(solution.step, metric.apply(solution.step));
    if (!(curvature > 0) || ss + 2 * alpha * sd + alpha * alpha * dd >= radius * radius) {
      const double tau = (-sd + std::sqrt(std::max(0.0, sd * sd + dd * (radius * radius - ss)))) / dd;
      add_scaled(solution.step, tau, direction);
      solution.on_boundary = true;
      return solution;
    }
    add_scaled(solution.step, alpha, direction);
    add_scaled(residual, alpha, image);
    if (dot(residual, residual) <= stop) return solution;
    preconditioned = metric.apply_inverse(residual);
    const double next_product = dot(residual, preconditioned);
    const double beta = next_product / energy_product;
    energy_product = next_product;
    parallel_for(direction.size(), [&](std::size_t i) {
      for (int k = 0; k < 2; ++k) direction[i][k] = beta * direction[i][k] - preconditioned[i][k];
    });
  }
  return solution;
}

}  // namespace

OptimizationResult minimize_trust_region(const SphereProblem& problem, std::vector<Vec3>& positions,
                                         const OptimizationOptions& options,
                                         const TrustRegionOptions& trust_region) {
  const auto start_time = std::chrono::steady_clock::now();
  const std::size_t count = positions.size();
  std::vector<TangentFrame> frames(count);
  TangentField gradient, image;
  BlockMatrix hessian, projected;
  std::vector<Vec3> candidate(count);
  OptimizationResult result;
  const double largest_radius = std::sqrt(static_cast<double>(count));
  double radius = trust_region.initial_radius > 0 ? trust_region.initial_radius : 0.1 * largest_radius;
  long evaluations = 0;
  bool is_new = true;
  int small_steps = 0, refusals = 0;
  while (true) {
    if (is_new) {
      parallel_for(count, [&](std::size_t v) { frames[v] = tangent_frame(positions[v]); });
      result.energy = problem.hessian(positions, frames, HessianKind::kExact, gradient, hessian);
      if (trust_region.block_jacobi) {
        TangentField unused;
        problem.hessian(positions, frames, HessianKind::kProjected, unused, projected);
      }
      ++evaluations;
      result.gradient_norm = std::sqrt(dot(gradient, gradient));
      if (options.observer) {
        const double seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start_time).count();
        if (!options.observer({result.iterations, seconds, result.energy, result.gradient_norm, evaluations},
                              positions))
          break;
      }
    }
    if (result.gradient_norm <= options.gradient_tolerance) {
      result.converged = true;
      break;
    }
    if (result.iterations >= options.maximum_iterations || small_steps >= 2 || refusals > 40) break;

    const double eta =
        trust_region.forcing > 0 ? trust_region.forcing : std::min(0.5, std::sqrt(result.gradient_norm));
    const BlockNorm metric(trust_region.block_jacobi ? projected : hessian, !trust_region.block_jacobi);
    const TruncatedSolution solution =
        solve_in_region(problem.graph(), hessian, metric, gradient, radius, eta, evaluations);
    hessian.multiply(problem.graph(), solution.step, image);
    const double predicted = -dot(gradient, solution.step) - 0.5 * dot(solution.step, image);
    parallel_for(count, [&](std::size_t v) {
      candidate[v] =
          retract(positions[v], solution.step[v][0] * frames[v].u + solution.step[v][1] * frames[v].v);
    });
    double energy = problem.energy(candidate);
    ++evaluations;
    if (options.forbid_flips &&
        (problem.flipped_count(candidate) > 0 || problem.covering_degree(candidate) != 1))
      energy = std::numeric_limits<double>::infinity();
    // In the last digits of the energy its difference is noise, and the model is exact: trust it.
    const bool is_noise = predicted < 1e-12 * std::abs(result.energy) &&
                          std::abs(result.energy - energy) < 1e-11 * std::abs(result.energy);
    const double agreement = is_noise ? 1 : (result.energy - energy) / predicted;

    // Step 4 of Fig. A.5, with the usual constants of [NW99], algorithm 4.1.
    if (!(agreement >= 0.25)) {
      const double step_length = std::sqrt(dot(solution.step, metric.apply(solution.step)));
      radius = 0.25 * std::min(radius, step_length);
    } else if (agreement > 0.75 && solution.on_boundary) {
      radius = std::min(2 * radius, largest_radius);
    }
    is_new = agreement > 1e-4;
    refusals = is_new ? 0 : refusals + 1;
    if (is_new) {
      small_steps =
          result.energy - energy < options.relative_decrease * std::abs(result.energy) ? small_steps + 1 : 0;
      positions = candidate;
      ++result.iterations;
    }
  }
  return result;
}

}  // namespace nmc
