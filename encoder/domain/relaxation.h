// SPDX-License-Identifier: Apache-2.0
// The globally smooth map of a surface onto a base domain, built coarse to fine by undoing the collapses.
//
// Based on: Friedel, Schroeder, Desbrun, "Unconstrained spherical parameterization" (2007): the combined
// Dirichlet and area energy, here in the flat cone metric of the base domain; Hormann, Greiner, Campagna,
// "Hierarchical parametrization of triangulated surfaces" (1999) for the insertion order; Khodakovsky et al.
// (2003) for cones.
#ifndef NMC_ENCODER_DOMAIN_RELAXATION_H_
#define NMC_ENCODER_DOMAIN_RELAXATION_H_

#include "encoder/core/progress.h"
#include "encoder/domain/maps_collapse.h"
#include "encoder/domain/parameterization.h"

namespace nmc {

/// Weights of the energy sum (dirichlet/4 sum cot |e|^2 + area A^2/A_target + barrier A_target^2/A) that
/// relaxation minimizes, and how long.
struct RelaxationOptions {
  double dirichlet_weight = 1;
  double area_weight = 2;
  double barrier_weight = 0.2;
  /// Target areas follow curvature^(2 * density_exponent), up to maximum_density times the flattest places'.
  double density_exponent = 0.5;
  double maximum_density = 64;
  /// Target areas are evened out over about this many rings of base faces, not over the whole surface.
  int scale_smoothing = 10;
  int sweeps_per_level = 4;
  int final_sweeps = 8;
};

/// Undoes the collapses of `history` from the base of `base_index` up and places every vertex in the domain
/// at the moment it appears, inside the kernel of its link, so the map is a bijection at every step; relaxes
/// by sweeps whenever the number of vertices has doubled. O(n). The sweeps are parallel by colours.
Parameterization relax(const CollapseHistory& history, std::size_t base_index,
                       const RelaxationOptions& options = {}, const Progress& progress = {});

}  // namespace nmc

#endif  // NMC_ENCODER_DOMAIN_RELAXATION_H_
