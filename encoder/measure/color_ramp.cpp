// SPDX-License-Identifier: Apache-2.0
#include "encoder/measure/color_ramp.h"

#include <algorithm>
#include <cmath>

namespace nmc {
namespace {

// Viridis at 0, 1/8, ..., 1.
constexpr std::array<RgbColor, 9> kSamples = {{{68, 1, 84},
                                               {71, 45, 123},
                                               {59, 82, 139},
                                               {44, 114, 142},
                                               {33, 145, 140},
                                               {40, 174, 128},
                                               {94, 201, 98},
                                               {173, 220, 48},
                                               {253, 231, 37}}};
constexpr RgbColor kOverflow = {214, 39, 40};

}  // namespace

RgbColor ramp_color(double value) {
  if (value > 1) return kOverflow;
  const double position = std::clamp(value, 0.0, 1.0) * (kSamples.size() - 1);
  const std::size_t first = std::min(static_cast<std::size_t>(position), kSamples.size() - 2);
  const double share = position - static_cast<double>(first);
  RgbColor color;
  for (std::size_t i = 0; i < 3; ++i) {
    color[i] = static_cast<std::uint8_t>(
        std::lround((1 - share) * kSamples[first][i] + share * kSamples[first + 1][i]));
  }
  return color;
}

double round_scale_end(double value) {
  if (!(value > 0) || !std::isfinite(value)) return 1;
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double factor : {1.0, 1.2, 1.6, 2.0, 2.4, 3.0, 4.0, 5.0, 6.0, 8.0}) {
    if (factor * power >= value) return factor * power;
  }
  return 10 * power;
}

}  // namespace nmc
