// SPDX-License-Identifier: Apache-2.0
#include "encoder/domain/relaxation.h"

#include <algorithm>
#include <optional>

#include "encoder/core/error.h"
#include "encoder/domain/map_sweeps.h"
#include "encoder/domain/sampling_density.h"
#include "encoder/domain/surface_map.h"

namespace nmc {
namespace {

/// Curvature is measured on levels of up to this many vertices per base vertex: finer ones show noise, and
/// more than two subdivisions below the base the density no longer matters.
constexpr std::size_t kDensityLevel = 64;
/// How often the base may grow before the insertion is given up.
constexpr int kMaximumAttempts = 24;

/// nullopt when a vertex finds no room.
std::optional<Parameterization> try_relax(const CollapseHistory& history, std::size_t step_count,
                                          const RelaxationOptions& options, const Progress& progress) {
  const EnergyWeights weights{options.dirichlet_weight, options.area_weight, options.barrier_weight};
  SurfaceMap map(history, step_count);
  std::vector<double> scale = domain_scale(map, options.scale_smoothing);
  const std::size_t base_count = map.live_vertex_count();
  std::size_t next_level = 2 * base_count;
  while (map.steps_left() > 0) {
    map.undo_step(weights, scale);
    if (map.failed_insertions() > 0) return std::nullopt;
    if (map.live_vertex_count() < next_level || map.steps_left() == 0) continue;
    if (map.live_vertex_count() <= kDensityLevel * base_count && options.density_exponent > 0)
      map.set_density(curvature_density(map, options.density_exponent, options.maximum_density));
    scale = domain_scale(map, options.scale_smoothing);
    sweep(map, weights, scale, options.sweeps_per_level);
    next_level *= 2;
    report(progress, "parameterize",
           1 - static_cast<double>(map.steps_left()) /
                   static_cast<double>(std::max<std::size_t>(step_count, 1)));
  }
  for (int done = 0; done < options.final_sweeps; done += 4) {
    scale = domain_scale(map, options.scale_smoothing);
    sweep(map, weights, scale, std::min(4, options.final_sweeps - done));
  }
  report(progress, "parameterize", 1);
  return map.release();
}

}  // namespace

Parameterization relax(const CollapseHistory& history, std::size_t base_index,
                       const RelaxationOptions& options, const Progress& progress) {
  std::size_t step_count = history.base_step_counts[base_index];
  for (int attempt = 0; attempt < kMaximumAttempts; ++attempt) {
    if (auto result = try_relax(history, step_count, options, progress)) return std::move(*result);
    // More base vertices, ever faster. The whole surface is its own base, so this ends.
    const std::size_t base_count = history.surface->vertex_count() - step_count;
    step_count -= std::min(step_count, std::max<std::size_t>(4, (base_count >> 5) << std::min(attempt, 16)));
  }
  throw Error(ExitCode::kInternal,
              "parameterization: no base was found onto which the surface maps without folds");
}

}  // namespace nmc
