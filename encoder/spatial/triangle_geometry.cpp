// SPDX-License-Identifier: Apache-2.0
#include "encoder/spatial/triangle_geometry.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace nmc {
namespace {

// Below this squared sine of the widest angle the rounding of the normal exceeds the triangle's own height.
constexpr double kFlatSquaredSine = 1e-26;

struct SegmentPoint {
  double weight_of_end;
  double squared_distance;
};

// `to_point` and `edge` start at the segment's first corner.
SegmentPoint closest_point_on_segment(const Vec3& to_point, const Vec3& edge) {
  const double length_squared = squared_norm(edge);
  const double along = dot(to_point, edge);
  const double weight = length_squared > 0 ? std::clamp(along / length_squared, 0.0, 1.0) : 0.0;
  return {weight, squared_norm(to_point - weight * edge)};
}

}  // namespace

ShearedRay::ShearedRay(const Vec3& origin, const Vec3& direction) : origin_(origin) {
  axis_[2] = 0;
  for (int i = 1; i < 3; ++i) {
    if (std::abs(direction[i]) > std::abs(direction[axis_[2]])) axis_[2] = i;
  }
  axis_[0] = (axis_[2] + 1) % 3;
  axis_[1] = (axis_[0] + 1) % 3;
  if (direction[axis_[2]] < 0) std::swap(axis_[0], axis_[1]);
  shear_[0] = direction[axis_[0]] / direction[axis_[2]];
  shear_[1] = direction[axis_[1]] / direction[axis_[2]];
  shear_[2] = 1.0 / direction[axis_[2]];
}

bool ShearedRay::intersect(const Vec3& corner_a, const Vec3& corner_b, const Vec3& corner_c, double& t,
                           double barycentric[3]) const {
  const Vec3 a = corner_a - origin_;
  const Vec3 b = corner_b - origin_;
  const Vec3 c = corner_c - origin_;
  const double ax = a[axis_[0]] - shear_[0] * a[axis_[2]];
  const double ay = a[axis_[1]] - shear_[1] * a[axis_[2]];
  const double bx = b[axis_[0]] - shear_[0] * b[axis_[2]];
  const double by = b[axis_[1]] - shear_[1] * b[axis_[2]];
  const double cx = c[axis_[0]] - shear_[0] * c[axis_[2]];
  const double cy = c[axis_[1]] - shear_[1] * c[axis_[2]];
  const double u = cx * by - cy * bx;
  const double v = ax * cy - ay * cx;
  const double w = bx * ay - by * ax;
  if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return false;
  const double determinant = u + v + w;
  if (determinant == 0) return false;
  barycentric[0] = u / determinant;
  barycentric[1] = v / determinant;
  barycentric[2] = w / determinant;
  t = shear_[2] *
      (barycentric[0] * a[axis_[2]] + barycentric[1] * b[axis_[2]] + barycentric[2] * c[axis_[2]]);
  return true;
}

TrianglePoint closest_point_on_triangle(const Vec3& point, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a;
  const Vec3 ac = c - a;
  const Vec3 ap = point - a;
  const Vec3 normal = cross(ab, ac);
  const double normal_squared = squared_norm(normal);
  const bool flat = !(normal_squared > kFlatSquaredSine * squared_norm(ab) * squared_norm(ac));

  const double weight_b = dot(cross(ap, ac), normal);
  const double weight_c = dot(cross(ab, ap), normal);
  const double weight_a = normal_squared - weight_b - weight_c;
  if (!flat && weight_a >= 0 && weight_b >= 0 && weight_c >= 0) {
    const double height = dot(ap, normal);
    return {{weight_a / normal_squared, weight_b / normal_squared, weight_c / normal_squared},
            height * height / normal_squared};
  }

  // A point outside a convex polygon sees the edge it is nearest to, so edges with a positive weight are left
  // out.
  TrianglePoint best{{1, 0, 0}, std::numeric_limits<double>::infinity()};
  if (flat || weight_c < 0) {
    const SegmentPoint on = closest_point_on_segment(ap, ab);
    if (on.squared_distance < best.squared_distance) {
      best = {{1 - on.weight_of_end, on.weight_of_end, 0}, on.squared_distance};
    }
  }
  if (flat || weight_b < 0) {
    const SegmentPoint on = closest_point_on_segment(ap, ac);
    if (on.squared_distance < best.squared_distance) {
      best = {{1 - on.weight_of_end, 0, on.weight_of_end}, on.squared_distance};
    }
  }
  if (flat || weight_a < 0) {
    const SegmentPoint on = closest_point_on_segment(point - b, c - b);
    if (on.squared_distance < best.squared_distance) {
      best = {{0, 1 - on.weight_of_end, on.weight_of_end}, on.squared_distance};
    }
  }
  return best;
}

}  // namespace nmc
