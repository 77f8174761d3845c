// SPDX-License-Identifier: Apache-2.0
// Gauss-Seidel sweeps over all vertices of a SurfaceMap, in parallel by colours.
#ifndef NMC_ENCODER_DOMAIN_MAP_SWEEPS_H_
#define NMC_ENCODER_DOMAIN_MAP_SWEEPS_H_

#include <vector>

#include "encoder/domain/surface_map.h"

namespace nmc {

/// Domain area per surface area of every base face, from the triangles that lie there now, smoothed over
/// neighbours in the logarithm: the map evens out sampling within a neighbourhood, not over the whole
/// surface, since the base mesh is denser where the surface needs it. O(live triangles).
std::vector<double> domain_scale(const SurfaceMap& map, int smoothing);

/// `count` sweeps of exact one-vertex minimizations with a guard against folds. Vertices of one colour share
/// no triangle, so the result does not depend on the number of threads.
void sweep(SurfaceMap& map, const EnergyWeights& weights, const std::vector<double>& scale, int count);

}  // namespace nmc

#endif  // NMC_ENCODER_DOMAIN_MAP_SWEEPS_H_
