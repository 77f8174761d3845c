// SPDX-License-Identifier: Apache-2.0
// Quadric error of planes: a symmetric 4x4 form whose value at x is the weighted sum of squared distances.
//
// Based on: Garland, Heckbert, "Surface simplification using quadric error metrics" (1997).
#ifndef NMC_ENCODER_DOMAIN_QUADRIC_H_
#define NMC_ENCODER_DOMAIN_QUADRIC_H_

#include "libnmc/common/vec3.h"

namespace nmc {

struct Quadric {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;  // matrix
  double x = 0, y = 0, z = 0;                             // linear part, half
  double constant = 0;

  Quadric& operator+=(const Quadric& q) {
    xx += q.xx, xy += q.xy, xz += q.xz, yy += q.yy, yz += q.yz, zz += q.zz;
    x += q.x, y += q.y, z += q.z, constant += q.constant;
    return *this;
  }
  double operator()(const Vec3& p) const {
    return p.x * (xx * p.x + 2 * (xy * p.y + xz * p.z + x)) + p.y * (yy * p.y + 2 * (yz * p.z + y)) +
           p.z * (zz * p.z + 2 * z) + constant;
  }
};

/// `weight` times the squared distance to the plane through `point` with unit `normal`.
inline Quadric plane_quadric(const Vec3& normal, const Vec3& point, double weight) {
  const double d = -dot(normal, point);
  return {weight * normal.x * normal.x, weight * normal.x * normal.y,
          weight * normal.x * normal.z, weight * normal.y * normal.y,
          weight * normal.y * normal.z, weight * normal.z * normal.z,
          weight * normal.x * d,        weight * normal.y * d,
          weight * normal.z * d,        weight * d * d};
}

}  // namespace nmc

#endif  // NMC_ENCODER_DOMAIN_QUADRIC_H_
