// SPDX-License-Identifier: Apache-2.0
// The two exact questions asked of a single triangle: where a ray pierces it, and its point nearest to a
// point.
//
// Based on: Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013 (in double, both
// sides, edges included); nearest point by the sign of the three edge functions, then by the edges that the
// point sees.
#ifndef NMC_ENCODER_SPATIAL_TRIANGLE_GEOMETRY_H_
#define NMC_ENCODER_SPATIAL_TRIANGLE_GEOMETRY_H_

#include "libnmc/common/vec3.h"

namespace nmc {

/// A ray prepared for many triangle tests. `direction` must not be zero and need not be of unit length.
class ShearedRay {
 public:
  ShearedRay(const Vec3& origin, const Vec3& direction);

  /// True where the line meets triangle abc; then `t` is the parameter in units of the direction and
  /// `barycentric` the weights of a, b, c (>= 0, exactly zero on the opposite edge). The decision is
  /// watertight: the sign of a shared edge's function is exactly opposite in its two triangles, so a line
  /// that crosses the edge meets at least one of them. A triangle seen edge-on is not met; its neighbours
  /// are.
  bool intersect(const Vec3& a, const Vec3& b, const Vec3& c, double& t, double barycentric[3]) const;

 private:
  Vec3 origin_;
  int axis_[3];      // the last one is the direction's largest component
  double shear_[3];  // of the first two axes, and scale of the last
};

struct TrianglePoint {
  double barycentric[3];
  double squared_distance;
};

/// The point of triangle abc nearest to `point`. Exact to rounding for every shape, also for triangles that
/// are a segment or a point: the plane is only trusted where the triangle has an area.
TrianglePoint closest_point_on_triangle(const Vec3& point, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace nmc

#endif  // NMC_ENCODER_SPATIAL_TRIANGLE_GEOMETRY_H_
