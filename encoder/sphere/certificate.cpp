// SPDX-License-Identifier: Apache-2.0
#include "encoder/sphere/certificate.h"

#include <cmath>
#include <numbers>

#include "encoder/core/parallel.h"
#include "encoder/sphere/exact_orientation.h"

namespace nmc {

SphereCertificate certify_sphere(const std::vector<Vec3>& positions, const std::vector<Triangle>& triangles) {
  SphereCertificate certificate;
  certificate.flipped_count = parallel_sum<std::size_t>(triangles.size(), [&](std::size_t f) -> std::size_t {
    const Triangle& t = triangles[f];
    return orientation_sign(positions[t[0]], positions[t[1]], positions[t[2]]) > 0 ? 0 : 1;
  });
  const double solid_angle = parallel_sum<double>(triangles.size(), [&](std::size_t f) {
    const Triangle& t = triangles[f];
    return signed_solid_angle(positions[t[0]], positions[t[1]], positions[t[2]]);
  });
  certificate.solid_angle_over_4pi = solid_angle / (4 * std::numbers::pi);
  return certificate;
}

}  // namespace nmc
