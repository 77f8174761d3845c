// SPDX-License-Identifier: Apache-2.0
// Limited-memory BFGS on the sphere product, with vector transport by projection.
//
// Based on: D. Liu, J. Nocedal, "On the Limited Memory BFGS Method for Large Scale Optimization", Math. Prog.
// 45, 1989; W. Ring, B. Wirth, "Optimization Methods on Riemannian Manifolds", SIAM J. Optim. 22, 2012.
#ifndef NMC_ENCODER_SPHERE_LBFGS_H_
#define NMC_ENCODER_SPHERE_LBFGS_H_

#include "encoder/sphere/optimization.h"

namespace nmc {

struct LbfgsOptions {
  int memory = 8;
  /// Scale by the inverse 2 x 2 diagonal blocks of the projected Hessian, renewed every 20 iterations.
  bool block_jacobi = false;
};

/// Improves `positions` in place. O(n) memory and time per iteration: for meshes too large to factor.
OptimizationResult minimize_lbfgs(const SphereProblem& problem, std::vector<Vec3>& positions,
                                  const OptimizationOptions& options, const LbfgsOptions& lbfgs = {});

}  // namespace nmc

#endif  // NMC_ENCODER_SPHERE_LBFGS_H_
