// SPDX-License-Identifier: Apache-2.0
// Bijective maps of closed genus-0 surfaces to the unit sphere, with minimal distortion.
//
// Based on: I. Friedel, P. Schroeder, M. Desbrun, "Unconstrained Spherical Parameterization", JGT 12(1),
// 2007, and I. Friedel's thesis, chapter 4 (the energies, their upper bounds, both initialisations). The
// coarse-to-fine solution over a collapse hierarchy, which is valid at every moment, is not in the thesis.
#ifndef NMC_ENCODER_SPHERE_SPHERE_PARAMETERIZATION_H_
#define NMC_ENCODER_SPHERE_SPHERE_PARAMETERIZATION_H_

#include <vector>

#include "encoder/core/progress.h"
#include "encoder/core/triangle_mesh.h"
#include "encoder/sphere/certificate.h"
#include "encoder/sphere/optimization.h"

namespace nmc {

/// Where the minimization starts.
enum class SphereStart {
  kHierarchy,           // coarse to fine from a tetrahedron: no flip at any time
  kCenteredNormalized,  // the thesis's: centred at the origin, scaled to unit length; has folds
  kStereographic,  // the thesis's: harmonic map of the punctured surface, stereographically; may have folds
};

enum class SphereSolver {
  kNewton,             // direct solver, see newton.h; L-BFGS beyond `direct_solver_limit` vertices
  kTrustRegionNewton,  // Steihaug-Toint conjugate gradients, see trust_region_newton.h
  kLbfgs,
  kNonlinearConjugateGradient,
  kSteepestDescent,
};

struct SphereOptions {
  SphereEnergyWeights weights;
  SphereStart start = SphereStart::kHierarchy;
  SphereSolver solver =
      SphereSolver::kNewton;  // of the finest level; coarser ones always use Newton's method
  double gradient_tolerance = 1e-7;
  int maximum_iterations = 200;  // on the finest level
  /// Stop early after two steps of less than this relative decrease; 0: only at the tolerance. 1e-5 is enough
  /// for remeshing and saves about two of five Newton steps.
  double relative_decrease = 0;
  std::uint32_t direct_solver_limit = 400'000;  // vertices; memory is about 3 kB for each
  /// Throw when the result is not a proven bijection.
  bool require_bijection = true;
  Progress progress;
};

struct SphereStatistics {
  double collapse_seconds = 0, insertion_seconds = 0, optimization_seconds = 0, total_seconds = 0;
  double finest_seconds = 0;  // of the optimization
  OptimizationResult finest;  // on the input mesh
  int newton_iterations = 0;  // on all levels
  int factorizations = 0;
  int insertions_without_kernel = 0;  // kernels too thin for double precision, put at their best point
};

struct SphereParameterization {
  std::vector<Vec3> positions;  // a unit vector per vertex of the input
  SphereStatistics statistics;
  SphereCertificate certificate;
};

/// Throws nmc::Error: kUnsupported unless the mesh is one closed, oriented, manifold component of genus 0
/// whose vertices are all used; kInternal when a bijection is required and was not reached. Deterministic for
/// any number of threads. O(n^1.5): 67,000 triangles in 4 s, 269,000 in 25 s on two cores.
SphereParameterization parameterize_sphere(const TriangleMesh& closed_genus0,
                                           const SphereOptions& options = {});

/// Half-edge collapses of a closed genus-0 surface to `vertex_count` vertices (a subset of the input's),
/// shape preserving. Throws like parameterize_sphere().
TriangleMesh simplify_genus0(const TriangleMesh& mesh, std::uint32_t vertex_count);

}  // namespace nmc

#endif  // NMC_ENCODER_SPHERE_SPHERE_PARAMETERIZATION_H_
