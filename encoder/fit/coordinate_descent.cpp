// SPDX-License-Identifier: Apache-2.0
#include "encoder/fit/coordinate_descent.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "encoder/core/parallel.h"

namespace nmc {

std::size_t descend_level(FitSystem& system, int level, double step, const std::vector<double>& dual,
                          const DescentOptions& options, RateModel& rates, CoefficientField& field) {
  const LevelTopology& topology = system.synthesis().hierarchy().level(level);
  const GalerkinMatrix& matrix = system.galerkin().matrix(level + 1);
  const std::size_t vertex_count = topology.vertex_count, edge_count = topology.edge_count;
  std::vector<double> gradient(edge_count), curvature(edge_count);
  parallel_for(edge_count, [&](std::size_t e) {
    const Vec3& n = system.synthesis().normal(level, e);
    gradient[e] = dual[system.layout().normal(level, e)];
    curvature[e] = dot(n, matrix.block[matrix.row_begin[vertex_count + e]] * n);
  });
  std::size_t changes = 0;
  for (int sweep = 0; sweep < options.maximum_sweeps; ++sweep) {
    std::size_t sweep_changes = 0;
    for (std::size_t e = 0; e < edge_count; ++e) {
      const double h = curvature[e];
      if (!(h > 0)) continue;
      const std::int32_t q = field.values[vertex_count + e];
      const double g = gradient[e];
      const std::int32_t rest = rates.resting_value(level, e);
      // Leaving the resting value costs at least two bits, and gains at most what its optimum gains.
      if (q == rest && g * g < 4 * options.lambda * h) continue;
      const double optimum = q - g / (h * step);
      std::int32_t candidates[5] = {q};
      int count = 1;
      const auto consider = [&](std::int32_t candidate) {
        for (int i = 0; i < count; ++i)
          if (candidates[i] == candidate) return;
        candidates[count++] = candidate;
      };
      const double clamped = std::clamp(optimum, -6e7, 6e7);
      consider(static_cast<std::int32_t>(std::floor(clamped)));
      consider(static_cast<std::int32_t>(std::ceil(clamped)));
      if (q != rest) consider(q > rest ? q - 1 : q + 1);
      consider(rest);
      double bits[5];
      rates.costs(level, e, candidates, count, bits);
      int best = 0;
      double best_cost = options.lambda * bits[0];
      for (int i = 1; i < count; ++i) {
        const double change = step * (candidates[i] - q);
        const double cost = g * change + 0.5 * h * change * change + options.lambda * bits[i];
        if (cost < best_cost) {
          best_cost = cost;
          best = i;
        }
      }
      if (best == 0) continue;
      ++sweep_changes;
      const double change = step * (candidates[best] - q);
      field.values[vertex_count + e] = candidates[best];
      rates.set(level, e, candidates[best]);
      const Vec3 displacement = change * system.synthesis().normal(level, e);
      for (std::size_t k = matrix.row_begin[vertex_count + e]; k < matrix.row_begin[vertex_count + e + 1];
           ++k) {
        if (matrix.column[k] < vertex_count) continue;
        const std::size_t f = matrix.column[k] - vertex_count;
        gradient[f] += dot(system.synthesis().normal(level, f), matrix.block[k] * displacement);
      }
    }
    changes += sweep_changes;
    if (1000 * sweep_changes < edge_count) break;
  }
  return changes;
}

std::size_t descend_base(FitSystem& system, double step, const std::vector<double>& dual,
                         const DescentOptions& options,
                         const std::vector<std::array<std::int32_t, 3>>* previous,
                         std::vector<std::array<std::int32_t, 3>>& coordinates) {
  const GalerkinMatrix& matrix = system.galerkin().matrix(0);
  std::vector<Vec3> gradient(coordinates.size());
  for (std::size_t v = 0; v < coordinates.size(); ++v)
    gradient[v] = {dual[3 * v], dual[3 * v + 1], dual[3 * v + 2]};
  const auto correction_bits = [](std::int32_t correction) {
    return correction == 0 ? 1.0 : 2.5 + 1.5 * std::log2(static_cast<double>(std::abs(correction)));
  };
  std::size_t changes = 0;
  for (int sweep = 0; sweep < options.maximum_sweeps; ++sweep) {
    std::size_t sweep_changes = 0;
    for (std::size_t v = 0; v < coordinates.size(); ++v) {
      for (int k = 0; k < 3; ++k) {
        const auto axis = static_cast<std::size_t>(k);
        const SymmetricMatrix3& own = matrix.block[matrix.row_begin[v]];
        const double h = k == 0 ? own.xx : k == 1 ? own.yy : own.zz, g = gradient[v][k];
        if (!(h > 0)) continue;
        const double optimum = -g / (h * step);
        if (!(std::abs(optimum) < 1e6)) continue;
        const std::int32_t present = coordinates[v][axis];
        std::int32_t best = present;
        if (!previous) {
          best += static_cast<std::int32_t>(std::lround(optimum));
        } else {
          const std::int32_t rest = (*previous)[v][axis];
          double best_cost = options.lambda * correction_bits(present - rest);
          const auto down = present + static_cast<std::int32_t>(std::floor(optimum));
          for (const std::int32_t candidate : {down, down + 1, rest}) {
            const double change = step * (candidate - present);
            const double cost =
                g * change + 0.5 * h * change * change + options.lambda * correction_bits(candidate - rest);
            if (cost < best_cost) {
              best_cost = cost;
              best = candidate;
            }
          }
        }
        if (best == present) continue;
        ++sweep_changes;
        coordinates[v][axis] = best;
        Vec3 displacement;
        displacement[k] = step * (best - present);
        for (std::size_t i = matrix.row_begin[v]; i < matrix.row_begin[v + 1]; ++i)
          gradient[matrix.column[i]] += matrix.block[i] * displacement;
      }
    }
    changes += sweep_changes;
    if (sweep_changes == 0) break;
  }
  return changes;
}

}  // namespace nmc
