// SPDX-License-Identifier: Apache-2.0
// Strong Wolfe line search along a curve of the sphere product, for the first-order solvers.
//
// Based on: J. Nocedal, S. Wright, "Numerical Optimization", algorithms 3.5 and 3.6.
#ifndef NMC_ENCODER_SPHERE_LINE_SEARCH_H_
#define NMC_ENCODER_SPHERE_LINE_SEARCH_H_

#include <vector>

#include "encoder/sphere/optimization.h"

namespace nmc {

struct LineSearchResult {
  bool success = false;
  double length = 0;
  double energy = 0;
  std::vector<Vec3> positions, gradient;
};

/// Looks for a length with sufficient decrease and |slope| <= curvature * |initial slope|. Points with flips
/// (when `forbid_flips`) or infinite energy count as too far. `evaluations` is increased per energy and
/// gradient.
LineSearchResult wolfe_line_search(const SphereProblem& problem, const std::vector<Vec3>& positions,
                                   double energy, const std::vector<Vec3>& gradient,
                                   const std::vector<Vec3>& direction, double first_length, double curvature,
                                   bool forbid_flips, long& evaluations);

/// Moves tangent vectors at `from` to tangent vectors at `to` by projection.
void transport(const std::vector<Vec3>& to, std::vector<Vec3>& field);

}  // namespace nmc

#endif  // NMC_ENCODER_SPHERE_LINE_SEARCH_H_
