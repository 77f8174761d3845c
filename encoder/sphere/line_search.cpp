// SPDX-License-Identifier: Apache-2.0
#include "encoder/sphere/line_search.h"

#include <cmath>
#include <limits>

#include "encoder/core/parallel.h"

namespace nmc {

void transport(const std::vector<Vec3>& to, std::vector<Vec3>& field) {
  parallel_for(field.size(), [&](std::size_t v) { field[v] = project_to_tangent(to[v], field[v]); });
}

LineSearchResult wolfe_line_search(const SphereProblem& problem, const std::vector<Vec3>& positions,
                                   double energy, const std::vector<Vec3>& gradient,
                                   const std::vector<Vec3>& direction, double first_length, double curvature,
                                   bool forbid_flips, long& evaluations) {
  constexpr double kSufficientDecrease = 1e-4;
  const double slope = dot(gradient, direction);
  LineSearchResult result;
  if (!(slope < 0)) return result;

  const auto evaluate = [&](double length) {
    result.length = length;
    result.positions.resize(positions.size());
    parallel_for(positions.size(),
                 [&](std::size_t v) { result.positions[v] = retract(positions[v], length * direction[v]); });
    ++evaluations;
    result.energy = problem.gradient(result.positions, result.gradient);
    if (forbid_flips &&
        (problem.flipped_count(result.positions) > 0 || problem.covering_degree(result.positions) != 1))
      result.energy = std::numeric_limits<double>::infinity();
  };
  // Bisection between the best length that is too short and the best that is too long: robust against the
  // poles of the energy, where interpolation is not.
  double low = 0, high = std::numeric_limits<double>::infinity();
  double length = first_length;
  constexpr int kTrials = 30;
  for (int trial = 0; trial < kTrials; ++trial) {
    evaluate(length);
    // The last digits of the energy are noise: there the slope alone decides.
    const double noise = 1e-13 * std::abs(energy);
    if (!(result.energy <= energy + kSufficientDecrease * length * slope + noise)) {
      high = length;
    } else {
      // The derivative of the retraction at this point: the projected direction, shortened by |x + length d|.
      const double new_slope = parallel_sum<double>(positions.size(), [&](std::size_t v) {
        return dot(result.gradient[v], direction[v]) / norm(positions[v] + length * direction[v]);
      });
      if (std::abs(new_slope) <= -curvature * slope) {
        result.success = true;
        return result;
      }
      if (new_slope > 0) {
        high = length;
      } else {
        low = length;
      }
    }
    length = std::isinf(high) ? 2 * length : (low + high) / 2;
  }
  // A point of sufficient decrease is still progress.
  if (low > 0) {
    evaluate(low);
    result.success = std::isfinite(result.energy);
  }
  return result;
}

}  // namespace nmc
