// SPDX-License-Identifier: Apache-2.0
// The exact sign of a spherical triangle's orientation.
//
// Based on: J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
// Predicates", Discrete & Computational Geometry 18, 1997 (floating-point filter, then expansion arithmetic).
#ifndef NMC_ENCODER_SPHERE_EXACT_ORIENTATION_H_
#define NMC_ENCODER_SPHERE_EXACT_ORIENTATION_H_

#include <cmath>

#include "libnmc/common/vec3.h"

namespace nmc {

/// The sign (-1, 0, +1) of det(a, b, c) in exact arithmetic on the given doubles. It is +1 when a, b, c run
/// counter-clockwise seen from outside a sphere around the origin; the vectors need not be of unit length.
/// Exact as long as no product of three components overflows or underflows, which unit vectors with
/// components above 1e-90 or equal to zero never do.
int orientation_sign(const Vec3& a, const Vec3& b, const Vec3& c);

/// det(a, b, c) in plain doubles, computed from differences so that it keeps its relative accuracy for small
/// triangles of unit vectors.
inline double orientation_volume(const Vec3& a, const Vec3& b, const Vec3& c) {
  return dot(a, cross(b - a, c - a));
}

/// Of the spherical triangle, in (-2 pi, 2 pi), positive when counter-clockwise.
/// Based on: A. Van Oosterom, J. Strackee, "The Solid Angle of a Plane Triangle", IEEE TBME 30, 1983.
inline double signed_solid_angle(const Vec3& a, const Vec3& b, const Vec3& c) {
  return 2 * std::atan2(orientation_volume(a, b, c), 1 + dot(a, b) + dot(b, c) + dot(c, a));
}

}  // namespace nmc

#endif  // NMC_ENCODER_SPHERE_EXACT_ORIENTATION_H_
