// SPDX-License-Identifier: Apache-2.0
// Proof that a map to the sphere is a bijection.
//
// If every triangle of a closed genus-0 mesh is counter-clockwise (exact predicate) and their solid angles
// add up to 4 pi, not 8 pi or more, the map is a local homeomorphism away from the vertices that covers the
// sphere once; no vertex can then wind around more than once, so the map is a homeomorphism.
#ifndef NMC_ENCODER_SPHERE_CERTIFICATE_H_
#define NMC_ENCODER_SPHERE_CERTIFICATE_H_

#include <cstddef>
#include <vector>

#include "encoder/core/triangle_mesh.h"

namespace nmc {

struct SphereCertificate {
  std::size_t flipped_count = 0;    // triangles whose exact orientation is not positive
  double solid_angle_over_4pi = 0;  // 1 for a single cover
  bool is_bijective() const {
    return flipped_count == 0 && solid_angle_over_4pi > 1 - 1e-9 && solid_angle_over_4pi < 1 + 1e-9;
  }
};

/// Positions are unit vectors up to rounding. O(n).
SphereCertificate certify_sphere(const std::vector<Vec3>& positions, const std::vector<Triangle>& triangles);

}  // namespace nmc

#endif  // NMC_ENCODER_SPHERE_CERTIFICATE_H_
