// SPDX-License-Identifier: Apache-2.0
// Hierarchies without normals, as yardsticks: plain remeshes and unconstrained least-squares vectors ("VVM").
//
// Based on: Friedel, section 3.6 (Figures 3.8 and 3.10 compare against both); Eck et al., "Multiresolution
// analysis of arbitrary meshes" (1995), plain remeshing at parametric midpoints.
#ifndef NMC_ENCODER_NORMAL_MESH_UNCONSTRAINED_VECTOR_MESH_H_
#define NMC_ENCODER_NORMAL_MESH_UNCONSTRAINED_VECTOR_MESH_H_

#include <span>
#include <vector>

#include "encoder/normal_mesh/parameterized_surface.h"
#include "encoder/normal_mesh/quadrature.h"

namespace nmc {

/// The positions of the vertices of one level that minimize the integral of |R o p - S|^2. `positions` give
/// the area weights only. Three scalar solves with one matrix.
std::vector<Vec3> fit_vectors(const ParameterizedSurface& map, const LevelTopology& topology, int level,
                              std::span<const Vec3> positions, std::span<const SurfaceParameter> parameters,
                              const QuadratureOptions& quadrature, const ConjugateGradientOptions& solver);

/// Parameters of all vertices down to the hierarchy's finest level by parametric midpoints: p = id. Those of
/// level l are the first ones.
std::vector<SurfaceParameter> midpoint_parameters(const ParameterizedSurface& map,
                                                  const SubdivisionHierarchy& hierarchy,
                                                  const std::vector<SurfaceParameter>& base_parameters);

/// R at the given parameters: with midpoint_parameters() the plain semi-regular remesh.
std::vector<Vec3> sample_surface(const ParameterizedSurface& map,
                                 std::span<const SurfaceParameter> parameters);

/// [l]: the unconstrained best approximation on level l, for the parameters of the hierarchy's finest level
/// (which include those of all levels): p^L of a normal mesh, or midpoint_parameters().
std::vector<std::vector<Vec3>> unconstrained_vector_mesh(const ParameterizedSurface& map,
                                                         const SubdivisionHierarchy& hierarchy,
                                                         std::span<const SurfaceParameter> parameters,
                                                         const QuadratureOptions& quadrature = {},
                                                         const ConjugateGradientOptions& solver = {});

}  // namespace nmc

#endif  // NMC_ENCODER_NORMAL_MESH_UNCONSTRAINED_VECTOR_MESH_H_
