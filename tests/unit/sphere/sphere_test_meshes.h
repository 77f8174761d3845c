// SPDX-License-Identifier: Apache-2.0
// Small closed genus-0 surfaces for the tests of the sphere room.
#ifndef NMC_TESTS_UNIT_SPHERE_SPHERE_TEST_MESHES_H_
#define NMC_TESTS_UNIT_SPHERE_SPHERE_TEST_MESHES_H_

#include <cmath>
#include <map>
#include <random>

#include "encoder/core/triangle_mesh.h"

namespace nmc_test {

inline nmc::TriangleMesh octahedron() {
  nmc::TriangleMesh mesh;
  mesh.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  return mesh;
}

/// The octahedron, split at edge midpoints `levels` times, on the unit sphere.
inline nmc::TriangleMesh geodesic_sphere(int levels) {
  nmc::TriangleMesh mesh = octahedron();
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> midpoints;
    const auto midpoint = [&](std::uint32_t a, std::uint32_t b) {
      const auto key = std::minmax(a, b);
      const auto [it, is_new] = midpoints.try_emplace(key, static_cast<std::uint32_t>(mesh.positions.size()));
      if (is_new) mesh.positions.push_back(normalized(mesh.positions[a] + mesh.positions[b]));
      return it->second;
    };
    std::vector<nmc::Triangle> triangles;
    for (const nmc::Triangle& t : mesh.triangles) {
      const std::uint32_t a = midpoint(t[0], t[1]), b = midpoint(t[1], t[2]), c = midpoint(t[2], t[0]);
      triangles.insert(triangles.end(), {{t[0], a, c}, {a, t[1], b}, {c, b, t[2]}, {a, b, c}});
    }
    mesh.triangles = std::move(triangles);
  }
  return mesh;
}

/// A sphere with long spikes and dents: r = 1 + amplitude * noise, deterministic.
inline nmc::TriangleMesh spiky_sphere(int levels, double amplitude) {
  nmc::TriangleMesh mesh = geodesic_sphere(levels);
  for (nmc::Vec3& p : mesh.positions)
    p = p * (1 + amplitude * std::sin(5 * p.x + 1) * std::sin(4 * p.y + 2) * std::sin(6 * p.z + 0.5));
  return mesh;
}

/// A tube of aspect ratio `length`, closed at both ends: starves on the sphere under angle-preserving maps.
inline nmc::TriangleMesh long_capsule(int levels, double length) {
  nmc::TriangleMesh mesh = geodesic_sphere(levels);
  for (nmc::Vec3& p : mesh.positions) p.z *= length;
  return mesh;
}

/// Unit vectors near the given ones, moved tangentially by up to `amount`.
inline std::vector<nmc::Vec3> jiggled(std::vector<nmc::Vec3> positions, double amount, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> distribution(-amount, amount);
  for (nmc::Vec3& p : positions) {
    // One call per statement: the order of evaluation of arguments is not fixed.
    const double dx = distribution(generator);
    const double dy = distribution(generator);
    const double dz = distribution(generator);
    p = normalized(p + nmc::Vec3{dx, dy, dz});
  }
  return positions;
}

}  // namespace nmc_test

#endif  // NMC_TESTS_UNIT_SPHERE_SPHERE_TEST_MESHES_H_
