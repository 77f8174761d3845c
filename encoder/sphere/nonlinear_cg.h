// SPDX-License-Identifier: Apache-2.0
// Nonlinear conjugate gradients and steepest descent on the sphere product.
//
// Based on: E. Polak, G. Ribiere, 1969; J. Nocedal, S. Wright, "Numerical Optimization", section 5.2 (PR+).
#ifndef NMC_ENCODER_SPHERE_NONLINEAR_CG_H_
#define NMC_ENCODER_SPHERE_NONLINEAR_CG_H_

#include "encoder/sphere/optimization.h"

namespace nmc {

enum class ConjugateGradientRule {
  kPolakRibiere,
  kPolakRibierePlus,  // never a negative factor: restarts by itself
  kFletcherReeves,
  kSteepestDescent,  // the factor is zero
};

/// Improves `positions` in place. O(n) memory and time per iteration.
OptimizationResult minimize_nonlinear_cg(
    const SphereProblem& problem, std::vector<Vec3>& positions, const OptimizationOptions& options,
    ConjugateGradientRule rule = ConjugateGradientRule::kPolakRibierePlus);

}  // namespace nmc

#endif  // NMC_ENCODER_SPHERE_NONLINEAR_CG_H_
