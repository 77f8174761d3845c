// SPDX-License-Identifier: Apache-2.0
// Parameterized surfaces with a known map, made by subdividing a base mesh and moving the vertices.
#ifndef NMC_TESTS_UNIT_NORMAL_MESH_SYNTHETIC_SURFACES_H_
#define NMC_TESTS_UNIT_NORMAL_MESH_SYNTHETIC_SURFACES_H_

#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "encoder/core/subdivision_hierarchy.h"
#include "encoder/domain/parameterization.h"

namespace nmc::test {

/// SplitMix64 (Steele, Lea, Flood 2014).
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
  std::uint32_t below(std::size_t count) { return static_cast<std::uint32_t>(bits() % count); }

 private:
  std::uint64_t state_;
};

struct BaseShape {
  std::vector<Triangle> faces;
  std::vector<Vec3> positions;
  std::vector<std::array<std::uint32_t, 2>> creases;
};

inline BaseShape tetrahedron() {
  return {
      {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}, {{1, 1, -1}, {-1, -1, -1}, {1, -1, 1}, {-1, 1, 1}}, {}};
}

inline BaseShape octahedron() {
  return {{{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}},
          {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
          {}};
}

inline BaseShape icosahedron() {
  const double g = 0.5 * (1 + std::sqrt(5.0));
  return {{{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
           {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
           {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}},
          {{-1, g, 0},
           {1, g, 0},
           {-1, -g, 0},
           {1, -g, 0},
           {0, -1, g},
           {0, 1, g},
           {0, -1, -g},
           {0, 1, -g},
           {g, 0, -1},
           {g, 0, 1},
           {-g, 0, -1},
           {-g, 0, 1}},
          {}};
}

/// Columns times rows quads around a torus.
inline BaseShape torus(std::uint32_t columns, std::uint32_t rows) {
  BaseShape shape;
  const auto id = [&](std::uint32_t i, std::uint32_t j) { return (j % rows) * columns + i % columns; };
  for (std::uint32_t j = 0; j < rows; ++j) {
    for (std::uint32_t i = 0; i < columns; ++i) {
      const double a = 2 * std::acos(-1.0) * i / columns, b = 2 * std::acos(-1.0) * j / rows;
      const double r = 2 + 0.7 * std::cos(b);
      shape.positions.push_back({r * std::cos(a), r * std::sin(a), 0.7 * std::sin(b)});
      shape.faces.push_back({id(i, j), id(i + 1, j), id(i, j + 1)});
      shape.faces.push_back({id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  }
  return shape;
}

/// A flat square of n times n quads in the plane z = 0, with corners at (0, 0) and (n, n).
inline BaseShape sheet(std::uint32_t n) {
  BaseShape shape;
  const auto id = [&](std::uint32_t i, std::uint32_t j) { return j * (n + 1) + i; };
  for (std::uint32_t j = 0; j <= n; ++j)
    for (std::uint32_t i = 0; i <= n; ++i) shape.positions.push_back({double(i), double(j), 0});
  for (std::uint32_t j = 0; j < n; ++j) {
    for (std::uint32_t i = 0; i < n; ++i) {
      shape.faces.push_back({id(i, j), id(i + 1, j), id(i, j + 1)});
      shape.faces.push_back({id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  }
  return shape;
}

/// Surface: the base subdivided `depth` times, each vertex at shape(point of the flat base face). Parameters
/// are moved by up to `shake` of a surface edge; those on boundaries and creases along their base edge.
template <class Shape>
Parameterization make_parameterization(const BaseShape& base, int depth, double shake, const Shape& shape) {
  const auto base_count = static_cast<std::uint32_t>(base.positions.size());
  Parameterization result;
  result.domain = BaseDomain(base_count, base.faces, base.creases);
  const BaseDomain& domain = result.domain;
  const SubdivisionHierarchy hierarchy(base.faces, base_count, depth);
  std::vector<std::array<ChartPoint, 3>> corners(base.faces.size(), kFaceCorners);
  for (int l = 0; l < depth; ++l) {
    std::vector<std::array<ChartPoint, 3>> finer;
    for (const auto& c : corners) {
      const ChartPoint m0 = 0.5 * (c[1] + c[2]), m1 = 0.5 * (c[2] + c[0]), m2 = 0.5 * (c[0] + c[1]);
      finer.push_back({c[0], m2, m1});
      finer.push_back({m2, c[1], m0});
      finer.push_back({m1, m0, c[2]});
      finer.push_back({m0, m1, m2});
    }
    corners = finer;
  }
  auto mesh = std::make_shared<TriangleMesh>();
  mesh->triangles = level_triangles(hierarchy.level(depth));
  const std::size_t vertex_count = hierarchy.level(depth).vertex_count;
  mesh->positions.resize(vertex_count);
  result.vertex_points.assign(vertex_count, {});
  Random random(7);
  const double edge = std::ldexp(1.0, -depth);
  for (std::uint32_t t = 0; t < mesh->triangles.size(); ++t) {
    const std::uint32_t f = t >> (2 * depth);
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t v = mesh->triangles[t][k];
      if (result.vertex_points[v].face != kNoFace) continue;
      const ChartPoint at = corners[t][k];
      const double b[3] = {1 - at.u - at.v, at.u, at.v};
      Vec3 flat;
      for (int i = 0; i < 3; ++i) flat += b[i] * base.positions[base.faces[f][i]];
      mesh->positions[v] = shape(flat);
      result.vertex_points[v] = {f, at};
      if (v < base_count) continue;
      ChartPoint offset{edge * random.uniform(-shake, shake), edge * random.uniform(-shake, shake)};
      for (int i = 0; i < 3; ++i) {
        if (b[i] != 0 || domain.edge_tag(f, i) == EdgeTag::kSmooth) continue;
        offset = snap_to_grid(offset.u * (kFaceCorners[(i + 2) % 3] - kFaceCorners[(i + 1) % 3]));
      }
      result.vertex_points[v] = domain.normalize(f, at + offset);
    }
  }
  result.input_vertex_count = vertex_count;
  result.triangle_charts.resize(mesh->triangles.size());
  for (std::uint32_t t = 0; t < mesh->triangles.size(); ++t) {
    const std::uint32_t f = t >> (2 * depth);
    result.triangle_charts[t].face = f;
    for (int k = 0; k < 3; ++k) {
      const DomainPoint& p = result.vertex_points[mesh->triangles[t][k]];
      ChartMap& map = result.triangle_charts[t].maps[k];
      if (domain.cone_at(p) != kNoVertex) {
        const ChartPoint corner = kFaceCorners[domain.corner_of(f, domain.cone_at(p))];
        map.tu = static_cast<std::int16_t>(corner.u - p.at.u);
        map.tv = static_cast<std::int16_t>(corner.v - p.at.v);
      } else {
        map = *domain.find_map(p.face, f);
      }
    }
  }
  for (std::uint32_t v = 0; v < base_count; ++v) {
    result.base_vertex_ids.push_back(v);
    result.base_positions.push_back(mesh->positions[v]);
  }
  result.surface = mesh;
  return result;
}

inline Vec3 on_unit_sphere(const Vec3& p) { return normalized(p); }

/// A sphere with bumps: smooth, of no symmetry that would make tests pass by chance.
inline Vec3 on_bumpy_sphere(const Vec3& p) {
  const Vec3 n = normalized(p);
  return (1 + 0.08 * std::sin(5 * n.x + 1) * std::cos(4 * n.y) + 0.05 * std::sin(7 * n.z)) * n;
}

inline Vec3 on_wavy_sheet(const Vec3& p) {
  return {p.x, p.y, 0.15 * std::sin(1.3 * p.x) * std::cos(1.1 * p.y + 0.3)};
}

inline Vec3 unchanged(const Vec3& p) { return p; }

}  // namespace nmc::test

#endif  // NMC_TESTS_UNIT_NORMAL_MESH_SYNTHETIC_SURFACES_H_
