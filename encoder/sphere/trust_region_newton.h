// SPDX-License-Identifier: Apache-2.0
// Trust-region Newton method with truncated conjugate gradients.
//
// Based on: T. Steihaug, "The Conjugate Gradient Method and Trust Regions in Large Scale Optimization", SIAM
// J. Numer. Anal. 20, 1983; P. Toint, 1981; I. Friedel, thesis, Figs. A.5 and A.8 (forcing sequences). On the
// sphere: P.-A. Absil, C. Baker, K. Gallivan, "Trust-Region Methods on Riemannian Manifolds", FoCM 7, 2007.
#ifndef NMC_ENCODER_SPHERE_TRUST_REGION_NEWTON_H_
#define NMC_ENCODER_SPHERE_TRUST_REGION_NEWTON_H_

#include "encoder/sphere/optimization.h"

namespace nmc {

struct TrustRegionOptions {
  /// The linear solver stops at a residual of eta times the gradient. Positive: eta is this constant. Zero:
  /// eta is min(0.5, sqrt(|gradient|)), which converges superlinearly.
  double forcing = 0;
  /// Measure steps, and precondition, by the 2 x 2 diagonal blocks of the projected Hessian.
  bool block_jacobi = true;
  double initial_radius = 0;  // 0: a tenth of the square root of the vertex count
};

/// Converges from any start, folded ones too when options.forbid_flips is off. Improves `positions` in place.
OptimizationResult minimize_trust_region(const SphereProblem& problem, std::vector<Vec3>& positions,
                                         const OptimizationOptions& options,
                                         const TrustRegionOptions& trust_region = {});

}  // namespace nmc

#endif  // NMC_ENCODER_SPHERE_TRUST_REGION_NEWTON_H_
