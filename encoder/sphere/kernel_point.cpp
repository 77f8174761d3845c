// SPDX-License-Identifier: Apache-2.0
#include "encoder/sphere/kernel_point.h"

#include <algorithm>

namespace nmc {

namespace {

// A cap that holds all the given normals has a centre with n . centre >= cosine for each of them.
struct Cap {
  Vec3 center;
  double cosine = 2;  // 2: empty

  // Slightly generous, so that the points that define the cap count as inside.
  bool holds(const Vec3& n) const { return dot(n, center) >= cosine - 1e-14; }
};

Cap cap_of(const Vec3& a) { return {a, 1}; }

Cap cap_of(const Vec3& a, const Vec3& b) {
  const Vec3 center = normalized(a + b, a);
  return {center, std::min(dot(a, center), dot(b, center))};
}

Cap cap_of(const Vec3& a, const Vec3& b, const Vec3& c) {
  Vec3 center = normalized(cross(b - a, c - a), a);
  // Of the two caps through three points the smaller one holds; it is the one whose centre they lean towards.
  if (dot(a, center) < 0) center = -center;
  return {center, std::min({dot(a, center), dot(b, center), dot(c, center)})};
}

}  // namespace

KernelPoint kernel_point(const std::vector<Vec3>& polygon) {
  const std::size_t count = polygon.size();
  std::vector<Vec3> normals(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 &p = polygon[i], &q = polygon[(i + 1) % count];
    normals[i] = normalized(cross(p, q - p), p);
  }
  // A fixed stride instead of a random order: neighbors on the polygon have similar normals, distant ones
  // define the cap early. Any order is correct.
  for (std::size_t i = 0; i + 1 < count; ++i) std::swap(normals[i], normals[i + (7 * i + 3) % (count - i)]);

  Cap cap;
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0 && cap.holds(normals[i])) continue;
    cap = cap_of(normals[i]);
    for (std::size_t j = 0; j < i; ++j) {
      if (cap.holds(normals[j])) continue;
      cap = cap_of(normals[i], normals[j]);
      for (std::size_t k = 0; k < j; ++k)
        if (!cap.holds(normals[k])) cap = cap_of(normals[i], normals[j], normals[k]);
    }
  }
  KernelPoint point{cap.center, 1};
  for (const Vec3& n : normals) point.clearance = std::min(point.clearance, dot(n, point.position));
  return point;
}

}  // namespace nmc
