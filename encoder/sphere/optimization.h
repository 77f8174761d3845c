// SPDX-License-Identifier: Apache-2.0
// What the solvers for the spherical energy have in common: when to stop and what to report.
#ifndef NMC_ENCODER_SPHERE_OPTIMIZATION_H_
#define NMC_ENCODER_SPHERE_OPTIMIZATION_H_

#include <functional>
#include <vector>

#include "encoder/sphere/sphere_problem.h"

namespace nmc {

/// One accepted iterate, for convergence plots.
struct IterationRecord {
  int iteration = 0;
  double seconds = 0;  // since the solver started
  double energy = 0;
  double gradient_norm = 0;
  long evaluations = 0;  // energies, gradients and products with the Hessian so far
};

struct OptimizationOptions {
  int maximum_iterations = 100;
  /// Stop when the Riemannian gradient's L2 norm over all vertices is below this.
  double gradient_tolerance = 1e-7;
  /// Stop after two steps that lower the energy by less than this fraction; 0: never.
  double relative_decrease = 0;
  /// Keep every triangle counter-clockwise in every step; needs a start without flips.
  bool forbid_flips = true;
  /// Called after every accepted step, and once for the start; return false to stop.
  std::function<bool(const IterationRecord&, const std::vector<Vec3>&)> observer;
};

struct OptimizationResult {
  double energy = 0;
  double gradient_norm = 0;
  int iterations = 0;
  int factorizations = 0;
  long damped_vertices = 0;  // times a vertex's step was halved to keep its triangles from flipping
  bool converged = false;    // the gradient tolerance was reached
};

}  // namespace nmc

#endif  // NMC_ENCODER_SPHERE_OPTIMIZATION_H_
