// SPDX-License-Identifier: Apache-2.0
#include "encoder/sphere/sphere_base.h"

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "encoder/core/error.h"
#include "encoder/core/parallel.h"
#include "encoder/sphere/collapse_hierarchy.h"

namespace nmc {

namespace {

// The polyhedron after `levels` of midpoint subdivision on the sphere, with the two ends of every midpoint.
struct Subdivided {
  std::vector<Vec3> directions;
  std::vector<std::array<std::uint32_t, 2>> parents;  // of vertex i of the polyhedron: {i, i}
};

Subdivided subdivide(const TriangleMesh& polyhedron, int levels) {
  Subdivided result;
  result.directions = polyhedron.positions;
  for (std::uint32_t v = 0; v < polyhedron.vertex_count(); ++v) result.parents.push_back({v, v});
  std::vector<Triangle> triangles = polyhedron.triangles;
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> midpoints;
    const auto midpoint = [&](std::uint32_t a, std::uint32_t b) {
      const auto [it, is_new] =
          midpoints.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(result.directions.size()));
      if (is_new) {
        result.directions.push_back(normalized(result.directions[a] + result.directions[b]));
        result.parents.push_back({a, b});
      }
      return it->second;
    };
    std::vector<Triangle> finer;
    for (const Triangle& t : triangles) {
      const std::uint32_t a = midpoint(t[0], t[1]), b = midpoint(t[1], t[2]), c = midpoint(t[2], t[0]);
      finer.insert(finer.end(), {{t[0], a, c}, {a, t[1], b}, {c, b, t[2]}, {a, b, c}});
    }
    triangles = std::move(finer);
  }
  return result;
}

Vec3 rotate(const Eigen::Quaterniond& rotation, const Vec3& x) {
  const Eigen::Vector3d y = rotation * Eigen::Vector3d(x.x, x.y, x.z);
  return {y[0], y[1], y[2]};
}

// How far the surface's points at midpoints are from the middle of their ends: what a normal mesh of a few
// levels would have to code.
double detail_energy(const SphereParameterizedSurface& surface, const Subdivided& samples,
                     const Eigen::Quaterniond& rotation) {
  std::vector<Vec3> positions(samples.directions.size());
  parallel_for(positions.size(), [&](std::size_t i) {
    positions[i] =
        surface.position(surface.locate(to_parameter(normalized(rotate(rotation, samples.directions[i])))));
  });
  double energy = 0;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const auto [a, b] = samples.parents[i];
    energy += squared_norm(positions[i] - 0.5 * (positions[a] + positions[b]));
  }
  return energy;
}

// A low-discrepancy sequence of rotations.
// Based on: K. Shoemake, "Uniform Random Rotations", Graphics Gems III, 1992; R_3 sequence of M. Roberts,
// 2018.
Eigen::Quaterniond rotation_number(int i) {
  if (i == 0) return Eigen::Quaterniond::Identity();
  constexpr double kRoot = 1.2207440846057596;  // of x^4 = x + 1
  const auto fraction = [](double x) { return x - std::floor(x); };
  const double u1 = fraction(0.5 + i / kRoot);
  const double u2 = 2 * std::numbers::pi * fraction(0.5 + i / (kRoot * kRoot));
  const double u3 = 2 * std::numbers::pi * fraction(0.5 + i / (kRoot * kRoot * kRoot));
  return {std::sqrt(u1) * std::cos(u3), std::sqrt(1 - u1) * std::sin(u2), std::sqrt(1 - u1) * std::cos(u2),
          std::sqrt(u1) * std::sin(u3)};
}

Eigen::Quaterniond best_rotation(const SphereParameterizedSurface& surface, const TriangleMesh& polyhedron,
                                 int rotation_count) {
  const Subdivided samples = subdivide(polyhedron, polyhedron.vertex_count() > 6 ? 2 : 3);
  Eigen::Quaterniond best = rotation_number(0);
  double best_energy = detail_energy(surface, samples, best);
  for (int i = 1; i < rotation_count; ++i) {
    const Eigen::Quaterniond candidate = rotation_number(i);
    const double energy = detail_energy(surface, samples, candidate);
    if (energy < best_energy) {
      best_energy = energy;
      best = candidate;
    }
  }
  // Pattern search: turn about the three axes, halving the angle when none helps.
  for (double angle = 0.15; angle > 0.02 && rotation_count > 0;) {
    bool improved = false;
    for (int axis = 0; axis < 3; ++axis) {
      for (const double sign : {1.0, -1.0}) {
        const Eigen::Quaterniond candidate =
            Eigen::Quaterniond(Eigen::AngleAxisd(sign * angle, Eigen::Vector3d::Unit(axis))) * best;
        const double energy = detail_energy(surface, samples, candidate);
        if (energy >= best_energy) continue;
        best_energy = energy;
        best = candidate;
        improved = true;
      }
    }
    if (!improved) angle /= 2;
  }
  return best;
}

ParameterizedBase adaptive_base(const SphereParameterizedSurface& surface, std::uint32_t vertex_count) {
  CollapseHierarchyOptions options;
  options.edge_length_weight = 1e-3;
  options.preferred_maximum_valence = 8;
  options.sphere_positions = &surface.sphere_positions();
  CollapseHierarchy hierarchy(surface.surface().positions, surface.surface().triangles, options);
  hierarchy.collapse_to(vertex_count);
  const HierarchyLevel level = hierarchy.level();
  ParameterizedBase base;
  base.faces = level.triangles;
  for (const std::uint32_t v : level.vertices) {
    base.positions.push_back(surface.surface().positions[v]);
    base.parameters.push_back(to_parameter(surface.sphere_positions()[v]));
  }
  return base;
}

}  // namespace

TriangleMesh regular_polyhedron(SphereBaseKind kind) {
  TriangleMesh mesh;
  switch (kind) {
    case SphereBaseKind::kTetrahedron:
      mesh.positions = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
      mesh.triangles = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
      break;
    case SphereBaseKind::kOctahedron:
      mesh.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
      mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                        {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
      break;
    case SphereBaseKind::kIcosahedron: {
      const double g = std::numbers::phi;
      mesh.positions = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                        {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
      mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                        {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                        {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
      break;
    }
    case SphereBaseKind::kAdaptive:
      throw Error(ExitCode::kInternal, "an adaptive base is not a regular polyhedron");
  }
  for (Vec3& p : mesh.positions) p = normalized(p);
  return mesh;
}

ParameterizedBase sphere_base(const SphereParameterizedSurface& surface, const SphereBaseOptions& options) {
  if (options.kind == SphereBaseKind::kAdaptive) return adaptive_base(surface, options.adaptive_vertex_count);
  const TriangleMesh polyhedron = regular_polyhedron(options.kind);
  const Eigen::Quaterniond rotation = best_rotation(surface, polyhedron, options.rotation_count);
  ParameterizedBase base;
  base.faces = polyhedron.triangles;
  for (const Vec3& p : polyhedron.positions) {
    base.parameters.push_back(to_parameter(normalized(rotate(rotation, p))));
    base.positions.push_back(surface.position(surface.locate(base.parameters.back())));
  }
  return base;
}

}  // namespace nmc
