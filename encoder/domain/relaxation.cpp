// SPDX-License-Identifier: Apache-2.0
#include "encoder/domain/relaxation.h"

#include <algorithm>
#include <cstdlib>

#include "encoder/domain/map_sweeps.h"
#include "encoder/domain/sampling_density.h"
#include "encoder/domain/surface_map.h"

namespace nmc {

Parameterization relax(const CollapseHistory& history, std::size_t base_index,
                       const RelaxationOptions& options, const Progress& progress) {
  const EnergyWeights weights{options.dirichlet_weight, options.area_weight, options.barrier_weight};
  SurfaceMap map(history, base_index);
  std::vector<double> scale = domain_scale(map);
  const std::size_t step_count = map.steps_left();
  const std::size_t base_count = map.live_vertex_count();
  static const std::size_t kDensityLevel = getenv("DL") ? atoi(getenv("DL")) : 64;
  std::size_t next_level = 2 * map.live_vertex_count();
  while (map.steps_left() > 0) {
    map.undo_step(weights, scale);
    if (map.live_vertex_count() < next_level || map.steps_left() == 0) continue;
    if (map.live_vertex_count() <= kDensityLevel * base_count && options.density_exponent > 0)
      map.set_density(curvature_density(map, options.density_exponent, options.maximum_density));
    scale = domain_scale(map);
    sweep(map, weights, scale, options.sweeps_per_level);
    next_level *= 2;
    report(progress, "parameterize",
           1 - static_cast<double>(map.steps_left()) /
                   static_cast<double>(std::max<std::size_t>(step_count, 1)));
  }
  for (int done = 0; done < options.final_sweeps; done += 4) {
    scale = domain_scale(map);
    sweep(map, weights, scale, std::min(4, options.final_sweeps - done));
  }
  report(progress, "parameterize", 1);
  return map.release();
}

}  // namespace nmc
