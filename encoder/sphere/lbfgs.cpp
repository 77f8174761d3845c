// SPDX-License-Identifier: Apache-2.0
#include "encoder/sphere/lbfgs.h"

#include <chrono>
#include <cmath>
#include <deque>

#include "encoder/core/parallel.h"
#include "encoder/sphere/line_search.h"

namespace nmc {

namespace {

struct Correction {
  std::vector<Vec3> step, change;  // of the positions and of the gradient
  double inverse_product = 0;
};

// Symmetric 3 x 3 inverses of the tangential diagonal blocks, stored as two frame vectors and a 2 x 2
// inverse.
struct DiagonalScaling {
  std::vector<TangentFrame> frames;
  std::vector<std::array<double, 3>> inverse;

  void renew(const SphereProblem& problem, const std::vector<Vec3>& positions) {
    frames.resize(positions.size());
    inverse.resize(positions.size());
    parallel_for(positions.size(), [&](std::size_t v) { frames[v] = tangent_frame(positions[v]); });
    std::vector<Tangent2> gradient;
    BlockMatrix hessian;
    problem.hessian(positions, frames, HessianKind::kProjected, gradient, hessian);
    const double floor_value = 1e-6 * hessian.mean_diagonal();
    parallel_for(positions.size(), [&](std::size_t v) {
      const double xx = hessian.diagonal[v][0] + floor_value, xy = hessian.diagonal[v][1];
      const double yy = hessian.diagonal[v][2] + floor_value;
      const double determinant = xx * yy - xy * xy;
      inverse[v] = {yy / determinant, -xy / determinant, xx / determinant};
    });
  }

  void apply(const std::vector<Vec3>& positions, std::vector<Vec3>& field) const {
    parallel_for(field.size(), [&](std::size_t v) {
      const double a = dot(frames[v].u, field[v]), b = dot(frames[v].v, field[v]);
      const auto& m = inverse[v];
      field[v] = project_to_tangent(
          positions[v], (m[0] * a + m[1] * b) * frames[v].u + (m[1] * a + m[2] * b) * frames[v].v);
    });
  }
};

void add_scaled(std::vector<Vec3>& a, double scale, const std::vector<Vec3>& b) {
  parallel_for(a.size(), [&](std::size_t v) { a[v] += scale * b[v]; });
}

}  // namespace

OptimizationResult minimize_lbfgs(const SphereProblem& problem, std::vector<Vec3>& positions,
                                  const OptimizationOptions& options, const LbfgsOptions& lbfgs) {
  const auto start_time = std::chrono::steady_clock::now();
  OptimizationResult result;
  std::vector<Vec3> gradient;
  result.energy = problem.gradient(positions, gradient);
  long evaluations = 1;
  std::deque<Correction> memory;
  DiagonalScaling scaling;
  constexpr int kScalingInterval = 20;
  int small_steps = 0;
  bool restarted = false;
  while (true) {
    result.gradient_norm = norm(gradient);
    if (options.observer) {
      const double seconds =
          std::chrono::duration<double>(std::chrono::steady_clock::now() - start_time).count();
      if (!options.observer({result.iterations, seconds, result.energy, result.gradient_norm, evaluations},
                            positions))
        break;
    }
    if (result.gradient_norm <= options.gradient_tolerance) {
      result.converged = true;
      break;
    }
    if (result.iterations >= options.maximum_iterations || small_steps >= 2) break;
    if (lbfgs.block_jacobi && result.iterations % kScalingInterval == 0) {
      scaling.renew(problem, positions);
      ++evaluations;
    }

    // The two-loop recursion.
    std::vector<Vec3> direction = gradient;
    std::vector<double> alphas(memory.size());
    for (std::size_t i = memory.size(); i-- > 0;) {
      alphas[i] = memory[i].inverse_product * dot(memory[i].step, direction);
      add_scaled(direction, -alphas[i], memory[i].change);
    }
    if (lbfgs.block_jacobi) {
      scaling.apply(positions, direction);
    } else if (!memory.empty()) {
      const Correction& last = memory.back();
      const double scale = 1 / (last.inverse_product * dot(last.change, last.change));
      parallel_for(direction.size(), [&](std::size_t v) { direction[v] *= scale; });
    }
    for (std::size_t i = 0; i < memory.size(); ++i) {
      const double beta = memory[i].inverse_product * dot(memory[i].change, direction);
      add_scaled(direction, alphas[i] - beta, memory[i].step);
    }
    parallel_for(direction.size(), [&](std::size_t v) { direction[v] = -direction[v]; });

    const double first_length =
        memory.empty() && !lbfgs.block_jacobi ? std::min(1.0, 1 / result.gradient_norm) : 1;
    LineSearchResult search = wolfe_line_search(problem, positions, result.energy, gradient, direction,
                                                first_length, 0.9, options.forbid_flips, evaluations);
    if (!search.success) {
      // Stale curvature is the usual reason; without any left there is no way down.
      if (restarted || memory.empty()) break;
      memory.clear();
      restarted = true;
      continue;
    }
    restarted = false;

    Correction correction;
    correction.step = direction;
    parallel_for(direction.size(), [&](std::size_t v) { correction.step[v] *= search.length; });
    transport(search.positions, correction.step);
    std::vector<Vec3> old_gradient = gradient;
    transport(search.positions, old_gradient);
    correction.change = search.gradient;
    add_scaled(correction.change, -1, old_gradient);
    for (Correction& older : memory) {
      transport(search.positions, older.step);
      transport(search.positions, older.change);
    }
    const double product = dot(correction.step, correction.change);
    if (product > 1e-12 * dot(correction.change, correction.change)) {
      correction.inverse_product = 1 / product;
      memory.push_back(std::move(correction));
      if (static_cast<int>(memory.size()) > lbfgs.memory) memory.pop_front();
    }
    small_steps = result.energy - search.energy < options.relative_decrease * std::abs(result.energy)
                      ? small_steps + 1
                      : 0;
    positions.swap(search.positions);
    gradient.swap(search.gradient);
    result.energy = search.energy;
    ++result.iterations;
  }
  return result;
}

}  // namespace nmc
