// SPDX-License-Identifier: Apache-2.0
// Which way a triangle of grid points turns, exactly.
//
// Domain points are multiples of 2^-48 below 16 in every chart in which a triangle is looked at. Differences
// of such numbers are integers of at most 53 bits times 2^-48, so doubles hold them exactly and the
// determinant fits into 128-bit integers: no adaptive expansion is needed (compare Shewchuk, "Adaptive
// precision floating-point arithmetic", 1997, whose first filter is used here).
#ifndef NMC_ENCODER_DOMAIN_EXACT_ORIENTATION_H_
#define NMC_ENCODER_DOMAIN_EXACT_ORIENTATION_H_

#include <cmath>

#include "encoder/domain/base_domain.h"

namespace nmc {

/// +1 counter-clockwise, -1 clockwise, 0 collinear. Exact for grid points with |coordinates| <= 16.
inline int orientation(const ChartPoint& a, const ChartPoint& b, const ChartPoint& c) {
  const ChartPoint p = b - a, q = c - a;
  const double left = p.u * q.v, right = p.v * q.u;
  const double determinant = left - right;
  constexpr double kFilter = 4.5e-16;  // above 4 rounding units of 2^-53
  if (std::abs(determinant) > kFilter * (std::abs(left) + std::abs(right))) return determinant > 0 ? 1 : -1;
  constexpr double kGrid = 281474976710656.0;  // 2^48
  const auto integer = [](double x) { return static_cast<__int128>(static_cast<long long>(x * kGrid)); };
  const __int128 exact = integer(p.u) * integer(q.v) - integer(p.v) * integer(q.u);
  return exact > 0 ? 1 : exact < 0 ? -1 : 0;
}

}  // namespace nmc

#endif  // NMC_ENCODER_DOMAIN_EXACT_ORIENTATION_H_
