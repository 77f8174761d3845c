// SPDX-License-Identifier: Apache-2.0
#include "encoder/sphere/nonlinear_cg.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "encoder/core/parallel.h"
#include "encoder/sphere/line_search.h"

namespace nmc {

OptimizationResult minimize_nonlinear_cg(const SphereProblem& problem, std::vector<Vec3>& positions,
                                         const OptimizationOptions& options, ConjugateGradientRule rule) {
  const auto start_time = std::chrono::steady_clock::now();
  const bool is_steepest = rule == ConjugateGradientRule::kSteepestDescent;
  OptimizationResult result;
  std::vector<Vec3> gradient;
  result.energy = problem.gradient(positions, gradient);
  long evaluations = 1;
  std::vector<Vec3> direction(positions.size());
  double previous_length = 0, previous_slope = 0;
  int small_steps = 0;
  bool restart = true, just_restarted = false;
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

    if (restart || !(dot(gradient, direction) < 0)) {
      parallel_for(direction.size(), [&](std::size_t v) { direction[v] = -gradient[v]; });
      restart = false;
      just_restarted = true;
    }
    // The first trial predicts the same decrease as the last step brought.
    const double slope = dot(gradient, direction);
    const double first_length = previous_length > 0 ? previous_length * previous_slope / slope
                                                    : std::min(1.0, 1 / result.gradient_norm);
    LineSearchResult search =
        wolfe_line_search(problem, positions, result.energy, gradient, direction, first_length,
                          is_steepest ? 0.5 : 0.1, options.forbid_flips, evaluations);
    if (!search.success) {
      if (just_restarted) break;
      restart = true;
      continue;
    }
    just_restarted = false;
    previous_length = search.length;
    previous_slope = slope;

    std::vector<Vec3> old_gradient = gradient;
    transport(search.positions, old_gradient);
    const double old_square = result.gradient_norm * result.gradient_norm;
    const double new_square = dot(search.gradient, search.gradient);
    double factor = 0;
    switch (rule) {
      case ConjugateGradientRule::kPolakRibiere:
      case ConjugateGradientRule::kPolakRibierePlus:
        factor = (new_square - dot(search.gradient, old_gradient)) / old_square;
        if (rule == ConjugateGradientRule::kPolakRibierePlus) factor = std::max(0.0, factor);
        break;
      case ConjugateGradientRule::kFletcherReeves:
        factor = new_square / old_square;
        break;
      case ConjugateGradientRule::kSteepestDescent:
        break;
    }
    transport(search.positions, direction);
    parallel_for(direction.size(),
                 [&](std::size_t v) { direction[v] = factor * direction[v] - search.gradient[v]; });
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
