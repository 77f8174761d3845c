// SPDX-License-Identifier: Apache-2.0
// Meshes and brute-force oracles for the tests of the spatial index.
#ifndef NMC_TESTS_UNIT_SPATIAL_TEST_MESHES_H_
#define NMC_TESTS_UNIT_SPATIAL_TEST_MESHES_H_

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "encoder/core/triangle_mesh.h"
#include "encoder/spatial/surface_index.h"

namespace nmc::test {

/// SplitMix64 (Steele, Lea, Flood 2014): fixed seeds, the same numbers everywhere.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t bits() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  double uniform(double low = 0, double high = 1) {
    return low + (high - low) * static_cast<double>(bits() >> 11) * 0x1p-53;
  }
  Vec3 point(double low = -1, double high = 1) {
    const double x = uniform(low, high), y = uniform(low, high);
    return {x, y, uniform(low, high)};
  }

 private:
  std::uint64_t state_;
};

/// Unconnected triangles of the given size in the cube [-1, 1]^3, moved by `offset`.
inline TriangleMesh triangle_soup(std::uint64_t seed, int count, double size, const Vec3& offset = {}) {
  Random random(seed);
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(count); ++i) {
    const Vec3 center = random.point() + offset;
    for (int k = 0; k < 3; ++k) mesh.positions.push_back(center + random.point(-size, size));
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

/// A sheet of n x n squares over [0, n]^2, z = height(x, y).
template <class Height>
TriangleMesh sheet(std::uint32_t n, const Height& height) {
  TriangleMesh mesh;
  for (std::uint32_t y = 0; y <= n; ++y) {
    for (std::uint32_t x = 0; x <= n; ++x) {
      mesh.positions.push_back({double(x), double(y), height(double(x), double(y))});
    }
  }
  for (std::uint32_t y = 0; y < n; ++y) {
    for (std::uint32_t x = 0; x < n; ++x) {
      const std::uint32_t i = y * (n + 1) + x;
      mesh.triangles.push_back({i, i + 1, i + n + 2});
      mesh.triangles.push_back({i, i + n + 2, i + n + 1});
    }
  }
  return mesh;
}

/// Independent of the library's code: Ericson, "Real-Time Collision Detection", 5.1.5, in long double.
inline double distance_to_triangle(const Vec3& point, const Vec3& corner_a, const Vec3& corner_b,
                                   const Vec3& corner_c) {
  struct Long {
    long double x, y, z;
  };
  const auto minus = [](const Long& a, const Long& b) { return Long{a.x - b.x, a.y - b.y, a.z - b.z}; };
  const auto inner = [](const Long& a, const Long& b) { return a.x * b.x + a.y * b.y + a.z * b.z; };
  const auto along = [](const Long& a, long double s, const Long& b) {
    return Long{a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
  };
  const auto to_long = [](const Vec3& a) { return Long{a.x, a.y, a.z}; };
  const Long p = to_long(point), a = to_long(corner_a), b = to_long(corner_b), c = to_long(corner_c);
  const auto segment = [&](const Long& start, const Long& end) {
    const Long edge = minus(end, start);
    const long double length = inner(edge, edge);
    const long double s = length > 0 ? std::clamp(inner(minus(p, start), edge) / length, 0.0L, 1.0L) : 0.0L;
    const Long gap = minus(p, along(start, s, edge));
    return std::sqrt(inner(gap, gap));
  };
  long double best = std::min({segment(a, b), segment(b, c), segment(c, a)});
  const Long ab = minus(b, a), ac = minus(c, a), ap = minus(p, a);
  const long double g00 = inner(ab, ab), g01 = inner(ab, ac), g11 = inner(ac, ac);
  const long double r0 = inner(ab, ap), r1 = inner(ac, ap), determinant = g00 * g11 - g01 * g01;
  if (determinant > 0) {
    const long double v = (g11 * r0 - g01 * r1) / determinant, w = (g00 * r1 - g01 * r0) / determinant;
    if (v >= 0 && w >= 0 && v + w <= 1) {
      const Long gap = minus(p, along(along(a, v, ab), w, ac));
      best = std::min(best, std::sqrt(inner(gap, gap)));
    }
  }
  return static_cast<double>(best);
}

inline double brute_force_distance(const TriangleMesh& mesh, const Vec3& point) {
  double best = std::numeric_limits<double>::infinity();
  for (const Triangle& t : mesh.triangles) {
    best = std::min(
        best, distance_to_triangle(point, mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]));
  }
  return best;
}

}  // namespace nmc::test

#endif  // NMC_TESTS_UNIT_SPATIAL_TEST_MESHES_H_
