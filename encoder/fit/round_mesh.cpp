// SPDX-License-Identifier: Apache-2.0
#include "encoder/fit/round_mesh.h"

#include <algorithm>
#include <cmath>

namespace nmc {

double ScalarQuantizer::normal_step(int level) const {
  return options_.normal_step * std::pow(options_.step_ratio, level - (coded_level_count_ - 1));
}

std::int32_t ScalarQuantizer::normal(double value, int level) const {
  constexpr double kRoundUp = 0.45, kLargest = 6e7;
  const double steps = std::abs(value) / normal_step(level);
  if (steps < options_.dead_zone) return 0;
  const auto q = static_cast<std::int32_t>(std::min(std::max(steps + kRoundUp, 1.0), kLargest));
  return value < 0 ? -q : q;
}

void ScalarQuantizer::tangential(double along, double across, int level, std::int32_t& along_steps,
                                 std::int32_t& across_steps) const {
  const double step = tangential_step(level);
  along_steps = across_steps = 0;
  if (std::hypot(along, across) < options_.dead_zone * step) return;
  along_steps = static_cast<std::int32_t>(std::lround(along / step));
  across_steps = static_cast<std::int32_t>(std::lround(across / step));
}

std::array<std::int32_t, 3> ScalarQuantizer::base_coordinates(const Vec3& position) const {
  std::array<std::int32_t, 3> coordinates;
  for (int k = 0; k < 3; ++k)
    coordinates[static_cast<std::size_t>(k)] =
        static_cast<std::int32_t>(std::lround((position[k] - options_.base_origin[k]) / base_step()));
  return coordinates;
}

Vec3 ScalarQuantizer::base_position(const std::array<std::int32_t, 3>& c) const {
  return options_.base_origin +
         base_step() * Vec3{static_cast<double>(c[0]), static_cast<double>(c[1]), static_cast<double>(c[2])};
}

QuantizedMesh round_mesh(const NormalMesh& mesh, int coded_level_count, const QuantizeOptions& options) {
  const ScalarQuantizer quantizer(options, coded_level_count);
  QuantizedMesh result;
  result.base_origin = quantizer.base_origin();
  result.base_step = quantizer.base_step();
  for (const Vec3& p : mesh.base_positions) result.base_coordinates.push_back(quantizer.base_coordinates(p));
  result.smoothing_level_count = mesh.level_count() - coded_level_count;
  for (int l = 0; l < coded_level_count; ++l) {
    const std::vector<OddVertexDetail>& details = mesh.details[static_cast<std::size_t>(l)];
    LevelQuantizer& level = result.quantizers.emplace_back();
    level.normal_step = quantizer.normal_step(l);
    level.tangential_step = quantizer.tangential_step(l);
    level.tension = Tension{mesh.tension.empty() ? 1.0 : mesh.tension[static_cast<std::size_t>(l)]};
    auto& normal = result.normal.emplace_back(details.size());
    auto& tangential = result.tangential.emplace_back();
    for (std::size_t e = 0; e < details.size(); ++e) {
      normal[e] = quantizer.normal(details[e].normal, l);
      TangentialCoefficient t{static_cast<std::uint32_t>(e), 0, 0};
      quantizer.tangential(details[e].along, details[e].across, l, t.along, t.across);
      if (t.along != 0 || t.across != 0) tangential.push_back(t);
    }
  }
  return result;
}

}  // namespace nmc
