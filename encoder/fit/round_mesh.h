// SPDX-License-Identifier: Apache-2.0
// Coefficients to integers in one go: the open loop, in which nothing makes good what rounding takes away.
//
// Based on: Khodakovsky, Guskov, Normal mesh compression, 2002 (coefficients of the interpolating mesh, coded
// as they are).
#ifndef NMC_ENCODER_FIT_ROUND_MESH_H_
#define NMC_ENCODER_FIT_ROUND_MESH_H_

#include "encoder/fit/quantize.h"
#include "encoder/fit/quantized_mesh.h"
#include "encoder/normal_mesh/normal_mesh.h"

namespace nmc {

/// Steps and thresholds by level, from the fields of QuantizeOptions that name them: normal_step, step_ratio,
/// tangential_ratio, base_step_factor, base_origin, dead_zone.
class ScalarQuantizer {
 public:
  ScalarQuantizer(const QuantizeOptions& options, int coded_level_count)
      : options_(options), coded_level_count_(coded_level_count) {}

  double normal_step(int level) const;
  double tangential_step(int level) const { return options_.tangential_ratio * normal_step(level); }
  double base_step() const { return options_.base_step_factor * normal_step(-1); }
  const Vec3& base_origin() const { return options_.base_origin; }

  /// In steps: zero below the dead zone, above it towards zero a little, where most coefficients of a cell
  /// lie.
  std::int32_t normal(double value, int level) const;
  /// To the nearest; both zero where their length is inside the dead zone.
  void tangential(double along, double across, int level, std::int32_t& along_steps,
                  std::int32_t& across_steps) const;
  std::array<std::int32_t, 3> base_coordinates(const Vec3& position) const;
  /// Where a base vertex with these coordinates lies.
  Vec3 base_position(const std::array<std::int32_t, 3>& coordinates) const;

 private:
  QuantizeOptions options_;
  int coded_level_count_;
};

/// Rounds every coefficient of levels below `coded_level_count` by itself. O(vertices).
QuantizedMesh round_mesh(const NormalMesh& mesh, int coded_level_count, const QuantizeOptions& options);

}  // namespace nmc

#endif  // NMC_ENCODER_FIT_ROUND_MESH_H_
