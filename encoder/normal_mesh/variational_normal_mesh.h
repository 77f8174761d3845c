// SPDX-License-Identifier: Apache-2.0
// Variational normal meshes: on every level the best approximation in the L2 sense that its normal lines
// allow.
//
// The correspondence R o p comes from piercing, as for interpolating meshes; then all vertices of the level,
// old and new, slide along the normal lines on which they were inserted to the least-squares position. The
// coefficients form a Laplacian pyramid: one scalar per vertex and level.
//
// Based on: Friedel, sections 3.4-3.6 and Figure 3.6, after Friedel, Schroeder, Khodakovsky, "Variational
// normal meshes" (ACM TOG 23(4), 2004).
#ifndef NMC_ENCODER_NORMAL_MESH_VARIATIONAL_NORMAL_MESH_H_
#define NMC_ENCODER_NORMAL_MESH_VARIATIONAL_NORMAL_MESH_H_

#include <cstdint>
#include <vector>

#include "encoder/normal_mesh/interpolating_normal_mesh.h"
#include "encoder/normal_mesh/quadrature.h"

namespace nmc {

struct VariationalOptions {
  InterpolatingOptions interpolating;  // levels, prediction, aperture
  QuadratureOptions quadrature;
  ConjugateGradientOptions solver;
  /// Also slides the base vertices along their normals before the first level; otherwise S^0 = R^0, as in
  /// Figure 3.6. Either way every line passes through R(u) of its vertex, without which a fine level could
  /// not converge.
  bool fit_base = false;
};

struct VariationalResult {
  SubdivisionHierarchy hierarchy;
  std::vector<std::vector<Vec3>> positions;  // [l]: S^l, l = 0 ... L
  std::vector<SurfaceParameter> parameters;  // p^L; those of level l are its first ones
  std::vector<Vec3> directions;              // of the vertices' normal lines, unit length
  /// [l][v], l = 1 ... L (0 is empty): how far vertex v moved on level l: an old vertex along its line; a new
  /// one along its line from its prediction, or from R(u) where it is not normal.
  std::vector<std::vector<double>> coefficients;
  std::vector<std::vector<std::uint8_t>> non_normal;  // [l][e]: odd vertex of edge e of level l
  std::vector<LevelStatistics> levels;
  std::vector<int> solver_iterations;  // per level 1 ... L

  double non_normal_share() const;
};

/// Figure 3.6. Time is dominated by the quadrature: samples per face times faces of all levels.
VariationalResult variational_normal_mesh(const ParameterizedSurface& map, const SurfaceIndex& index,
                                          const ParameterizedBase& base, const VariationalOptions& options);

}  // namespace nmc

#endif  // NMC_ENCODER_NORMAL_MESH_VARIATIONAL_NORMAL_MESH_H_
