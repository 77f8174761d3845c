// SPDX-License-Identifier: Apache-2.0
// A point of the sphere that sees a whole spherical polygon from inside.
//
// Based on: E. Welzl, "Smallest Enclosing Disks (Balls and Ellipsoids)", 1991, on the normals of the
// polygon's edges: the centre of their smallest enclosing cap is the kernel point with the largest distance
// to all edges.
#ifndef NMC_ENCODER_SPHERE_KERNEL_POINT_H_
#define NMC_ENCODER_SPHERE_KERNEL_POINT_H_

#include <vector>

#include "libnmc/common/vec3.h"

namespace nmc {

struct KernelPoint {
  Vec3 position;
  double clearance = 0;  // sine of the distance to the nearest edge's great circle; not positive: no kernel
};

/// `polygon` holds unit vectors, counter-clockwise seen from outside. O(corners) expected.
KernelPoint kernel_point(const std::vector<Vec3>& polygon);

}  // namespace nmc

#endif  // NMC_ENCODER_SPHERE_KERNEL_POINT_H_
