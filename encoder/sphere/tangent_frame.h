// SPDX-License-Identifier: Apache-2.0
// Orthonormal tangent frames and steps on the unit sphere: no longitude and latitude, hence no poles.
//
// Based on: T. Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017.
#ifndef NMC_ENCODER_SPHERE_TANGENT_FRAME_H_
#define NMC_ENCODER_SPHERE_TANGENT_FRAME_H_

#include <cmath>

#include "libnmc/common/vec3.h"

namespace nmc {

struct TangentFrame {
  Vec3 u, v;  // orthonormal, and (u, v, x) is right-handed
};

inline TangentFrame tangent_frame(const Vec3& x) {
  const double sign = std::copysign(1.0, x.z);
  const double a = -1 / (sign + x.z);
  const double b = x.x * x.y * a;
  return {{1 + sign * x.x * x.x * a, sign * b, -sign * x.x}, {b, sign + x.y * x.y * a, -x.y}};
}

/// The retraction: x + tangent, projected back.
inline Vec3 retract(const Vec3& x, const Vec3& tangent) { return normalized(x + tangent, x); }

inline Vec3 project_to_tangent(const Vec3& x, const Vec3& vector) { return vector - dot(x, vector) * x; }

}  // namespace nmc

#endif  // NMC_ENCODER_SPHERE_TANGENT_FRAME_H_
