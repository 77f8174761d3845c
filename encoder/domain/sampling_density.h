// SPDX-License-Identifier: Apache-2.0
// Where a surface needs more samples: a density from curvature.
//
// The squared error of piecewise linear interpolation grows with curvature^2 times the fourth power of the
// spacing, so with a given number of samples it is least at a density proportional to curvature^(2/3)
// (Nadler, "Piecewise linear best L2 approximation on triangulations", 1986). The exponent here is a
// parameter.
#ifndef NMC_ENCODER_DOMAIN_SAMPLING_DENSITY_H_
#define NMC_ENCODER_DOMAIN_SAMPLING_DENSITY_H_

#include <vector>

#include "encoder/domain/surface_map.h"

namespace nmc {

/// Density of every live vertex of the map's present mesh, relative to the flattest places (1), at most
/// `maximum`; smoothed over neighbours. Other vertices get 1. O(live faces).
std::vector<double> curvature_density(const SurfaceMap& map, double exponent, double maximum);

}  // namespace nmc

#endif  // NMC_ENCODER_DOMAIN_SAMPLING_DENSITY_H_
