// SPDX-License-Identifier: Apache-2.0
// From a surface to base meshes: half-edge collapses by quadrics, recorded so that they can be undone.
//
// Based on: Lee et al., "MAPS" (1998), with half-edge collapses by quadric error (Garland, Heckbert 1997;
// line quadrics on boundaries and creases) instead of independent sets, so that base vertices are input
// vertices and every step touches one star.
#ifndef NMC_ENCODER_DOMAIN_MAPS_COLLAPSE_H_
#define NMC_ENCODER_DOMAIN_MAPS_COLLAPSE_H_

#include <vector>

#include "encoder/core/progress.h"
#include "encoder/domain/parameterization.h"

namespace nmc {

struct MapsOptions {
  /// Edges whose dihedral angle exceeds this (degrees) become creases, kept as base edge paths; 0: none.
  double crease_angle_degrees = 0;
  /// Local extremities (tips of limbs, ears, fingers) that must survive to the base: at most this share of
  /// the vertices of each base.
  double extremity_share = 0.25;
};

/// Weights of the energy that relaxation minimizes (study B.5): Dirichlet and area.
struct RelaxationOptions {
  double dirichlet_weight = 1;
  double area_weight = 4;
  int sweeps_per_level = 4;
};

/// One parameterization per entry of `base_sizes` (numbers of base vertices; reached as nearly as topology,
/// creases and extremities allow, never fewer), all from one run of collapses, so the base vertices are
/// nested.
///
/// `mesh` must be an oriented 2-manifold with or without boundary; any genus, any number of components. Every
/// map is a bijection (certify() in certificate.h counts its folds: 0). Deterministic, the same for any
/// number of threads. O(n log n). Throws Error (kInvalidInput) where the mesh is not manifold.
std::vector<Parameterization> parameterize(const TriangleMesh& mesh, const std::vector<int>& base_sizes,
                                           const MapsOptions& maps_options = {},
                                           const RelaxationOptions& relaxation_options = {},
                                           const Progress& progress = {});

}  // namespace nmc

#endif  // NMC_ENCODER_DOMAIN_MAPS_COLLAPSE_H_
