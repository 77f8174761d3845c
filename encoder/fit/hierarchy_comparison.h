// SPDX-License-Identifier: Apache-2.0
// Four hierarchies over the same connectivity and correspondences: what one scalar per vertex can do.
//
//   interpolating (INM)  one scalar per vertex, every vertex on the input;
//   variational (VNM)    per level least squares, every vertex on the line it was inserted on; even vertices
//   move at
//                        every level, so a code needs a scalar per vertex *and level*;
//   vectors (VVM)        the finest vertices without any constraint: the bound for this connectivity;
//   fit                  one scalar per vertex, all levels at once (global_fit.h).
//
// Based on: Guskov, Vidimce, Sweldens, Schroeder, Normal meshes, SIGGRAPH 2000; Friedel, Khodakovsky,
// Schroeder, Variational normal meshes, 2004.
#ifndef NMC_ENCODER_FIT_HIERARCHY_COMPARISON_H_
#define NMC_ENCODER_FIT_HIERARCHY_COMPARISON_H_

#include <vector>

#include "encoder/fit/global_fit.h"

namespace nmc {

/// Positions of the finest vertices of each hierarchy.
struct HierarchyComparison {
  std::vector<Vec3> interpolating, variational, vectors, fit;
};

/// `mesh` interpolates the input and is fitted in place; `samples` live on its last level. With `input` each
/// of the three optimised hierarchies gets options.reprojection_count re-projections on its own finest level.
HierarchyComparison compare_hierarchies(const GlobalFitOptions& options, const InputSurface* input,
                                        const std::vector<SurfaceSample>& samples, NormalMesh& mesh);

/// Least squares over vertices that each may move along `directions[v]`, or freely where that is zero:
/// conjugate gradients on the frozen quadratic. Returns the energy reached.
double minimize_along_lines(const QuadraticEnergy& energy, const std::vector<Vec3>& directions,
                            int maximum_iterations, std::vector<Vec3>& positions);

/// The thesis's variational normal mesh: positions of the last level.
std::vector<Vec3> variational_normal_mesh(const NormalMesh& connectivity,
                                          const std::vector<SurfaceSample>& samples,
                                          const QuadraticEnergyOptions& options,
                                          std::vector<Vec3>& directions);

}  // namespace nmc

#endif  // NMC_ENCODER_FIT_HIERARCHY_COMPARISON_H_
