// SPDX-License-Identifier: Apache-2.0
// Newton's method for one vertex of the sphere while its neighbors stand still.
//
// The 2 x 2 problem is solved with the absolute values of the eigenvalues (so every step descends) and a
// guard that keeps the star's triangles counter-clockwise. Run once after every insertion, and as
// Gauss-Seidel sweeps before every global step, it removes the local errors that a global Newton step is too
// expensive for.
#ifndef NMC_ENCODER_SPHERE_STAR_RELAXATION_H_
#define NMC_ENCODER_SPHERE_STAR_RELAXATION_H_

#include <vector>

#include "encoder/sphere/sphere_problem.h"

namespace nmc {

/// A star: triangle i has the corners centre, ring[i].first, ring[i].second, counter-clockwise, and the
/// reference of corner 0 at the centre.
struct StarTriangle {
  Vec3 second, third;
  ReferenceTriangle reference;
};

/// At most `iterations` guarded Newton steps; returns the new centre. Does nothing where the star is not
/// valid.
Vec3 relax_star(const SphereEnergyWeights& weights, const std::vector<StarTriangle>& star, const Vec3& center,
                int iterations);

/// One step for every vertex, in index order, each with the newest positions of the others. O(n), 3 us a
/// vertex.
void gauss_seidel_sweep(const SphereProblem& problem, std::vector<Vec3>& positions);

}  // namespace nmc

#endif  // NMC_ENCODER_SPHERE_STAR_RELAXATION_H_
