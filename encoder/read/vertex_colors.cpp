// SPDX-License-Identifier: Apache-2.0
#include "encoder/read/vertex_colors.h"

#include <algorithm>
#include <cmath>

namespace nmc {

std::uint8_t color_byte(double value, double white) {
  const double scaled = value / white * 255.0;
  if (!(scaled > 0)) return 0;
  return static_cast<std::uint8_t>(std::lround(std::min(scaled, 255.0)));
}

std::vector<std::array<std::uint8_t, 3>> colors_from_unscaled(std::span<const float> rgb,
                                                              float largest_opacity) {
  float maximum = largest_opacity;
  for (const float value : rgb)
    if (std::isfinite(value)) maximum = std::max(maximum, value);
  const double white = maximum <= 1 ? 1 : maximum <= 255 ? 255 : 65535;
  std::vector<std::array<std::uint8_t, 3>> colors(rgb.size() / 3);
  for (std::size_t i = 0; i < colors.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) colors[i][k] = color_byte(rgb[3 * i + k], white);
  return colors;
}

bool holds_negative(std::span<const float> rgb) {
  return std::any_of(rgb.begin(), rgb.end(), [](float value) { return value < 0; });
}

std::uint8_t srgb_byte_from_linear(double linear) {
  if (!(linear > 0)) return 0;
  if (linear >= 1) return 255;
  const double encoded = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
  return color_byte(encoded, 1);
}

}  // namespace nmc
