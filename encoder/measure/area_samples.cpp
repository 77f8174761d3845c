// SPDX-License-Identifier: Apache-2.0
#include "encoder/measure/area_samples.h"

#include <algorithm>
#include <cmath>

namespace nmc {
namespace {

// 1/p and 1/p^2 for the real root p of p^3 = p + 1, as binary fractions: index * constant modulo 2^64 is the
// fractional part without rounding, however large the index (both made odd: full period).
constexpr std::uint64_t kR2First = 0xc13fa9a902a6328fu;
constexpr std::uint64_t kR2Second = 0x91e10da5c79e7b1du;

double fraction(std::uint64_t bits) { return static_cast<double>(bits >> 11) * 0x1p-53; }

}  // namespace

AreaSamples::AreaSamples(const std::vector<Vec3>& positions, const std::vector<Triangle>& triangles,
                         std::size_t count)
    : positions_(positions), triangles_(triangles), cumulated_area_(triangles.size()), count_(count) {
  double area = 0;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Vec3& a = positions[triangles[t][0]];
    const double own = 0.5 * norm(cross(positions[triangles[t][1]] - a, positions[triangles[t][2]] - a));
    if (std::isfinite(own)) area += own;
    cumulated_area_[t] = area;
  }
  if (!(area > 0)) count_ = 0;
}

AreaSample AreaSamples::operator[](std::size_t i) const {
  const double target = total_area() * ((static_cast<double>(i) + 0.5) / static_cast<double>(count_));
  const auto found = std::upper_bound(cumulated_area_.begin(), cumulated_area_.end(), target);
  AreaSample sample;
  sample.triangle = static_cast<std::uint32_t>(
      std::min<std::ptrdiff_t>(found - cumulated_area_.begin(), std::ssize(cumulated_area_) - 1));

  double u = fraction((i + 1) * kR2First);
  double v = fraction((i + 1) * kR2Second);
  if (u + v > 1) {
    u = 1 - u;
    v = 1 - v;
  }
  sample.barycentric[0] = std::max(0.0, 1 - u - v);
  sample.barycentric[1] = u;
  sample.barycentric[2] = v;
  const Triangle& corners = triangles_[sample.triangle];
  sample.position = sample.barycentric[0] * positions_[corners[0]] + u * positions_[corners[1]] +
                    v * positions_[corners[2]];
  return sample;
}

}  // namespace nmc
