// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>

#include "corpus/generate/shapes.h"

namespace nmc::corpus {

namespace {
using std::numbers::pi;

std::uint32_t index(int i) { return static_cast<std::uint32_t>(i); }

void add_quad(TriangleMesh& mesh, int a, int b, int c, int d) {
  mesh.triangles.push_back({index(a), index(b), index(c)});
  mesh.triangles.push_back({index(a), index(c), index(d)});
}

/// A grid of i in 0..rows-1 and j in 0..columns-1 that closes in both directions.
template <class Point>
TriangleMesh closed_grid(int rows, int columns, const Point& point) {
  TriangleMesh mesh;
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j) mesh.positions.push_back(point(i, j));
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j) {
      const int i1 = (i + 1) % rows, j1 = (j + 1) % columns;
      add_quad(mesh, i * columns + j, i1 * columns + j, i1 * columns + j1, i * columns + j1);
    }
  return mesh;
}
}  // namespace

TriangleMesh torus(int around, int across, double tube_radius) {
  return closed_grid(around, across, [&](int i, int j) {
    const double u = 2 * pi * i / around, v = 2 * pi * j / across;
    const double r = 1 + tube_radius * std::cos(v);
    return Vec3{r * std::cos(u), r * std::sin(u), tube_radius * std::sin(v)};
  });
}

TriangleMesh long_cylinder(double aspect, int around, int along) {
  TriangleMesh mesh;
  const double radius = 0.5 / aspect;
  for (int i = 0; i <= along; ++i)
    for (int j = 0; j < around; ++j) {
      const double v = 2 * pi * j / around;
      mesh.positions.push_back({static_cast<double>(i) / along, radius * std::cos(v), radius * std::sin(v)});
    }
  for (int i = 0; i < along; ++i)
    for (int j = 0; j < around; ++j) {
      const int j1 = (j + 1) % around;
      add_quad(mesh, i * around + j, i * around + j1, (i + 1) * around + j1, (i + 1) * around + j);
    }
  const int start = static_cast<int>(mesh.vertex_count()), end = start + 1;
  mesh.positions.push_back({0, 0, 0});
  mesh.positions.push_back({1, 0, 0});
  for (int j = 0; j < around; ++j) {
    const int j1 = (j + 1) % around;
    mesh.triangles.push_back({index(start), index(j1), index(j)});
    mesh.triangles.push_back({index(end), index(along * around + j), index(along * around + j1)});
  }
  // The y-z circle runs counter-clockwise seen against x, so the quads above look outward.
  return mesh;
}

TriangleMesh torus_knot(int p, int q, int along, int around, double tube_radius) {
  const auto curve = [&](double t) {
    const double r = 1 + 0.4 * std::cos(q * t);
    return Vec3{r * std::cos(p * t), r * std::sin(p * t), -0.4 * std::sin(q * t)};
  };
  return closed_grid(along, around, [&](int i, int j) {
    const double t = 2 * pi * i / along, step = 2 * pi / along;
    const Vec3 before = curve(t - step), here = curve(t), after = curve(t + step);
    // The Frenet frame of a torus knot closes, because its curvature is nowhere zero.
    const Vec3 tangent = normalized(after - before);
    const Vec3 bend = after - 2.0 * here + before;
    const Vec3 normal = normalized(bend - dot(bend, tangent) * tangent);
    const Vec3 binormal = cross(tangent, normal);
    const double v = 2 * pi * j / around;
    return here + tube_radius * (std::cos(v) * binormal + std::sin(v) * normal);
  });
}

TriangleMesh moebius_strip(int around, int across) {
  TriangleMesh mesh;
  for (int i = 0; i < around; ++i)
    for (int j = 0; j <= across; ++j) {
      const double u = 2 * pi * i / around, v = 0.6 * (static_cast<double>(j) / across - 0.5);
      const double r = 1 + v * std::cos(u / 2);
      mesh.positions.push_back({r * std::cos(u), r * std::sin(u), v * std::sin(u / 2)});
    }
  const int width = across + 1;
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const bool last = i + 1 == around;
      const int next = last ? 0 : (i + 1) * width;
      const int c = next + (last ? across - j - 1 : j + 1), d = next + (last ? across - j : j);
      add_quad(mesh, i * width + j, d, c, i * width + j + 1);
    }
  return mesh;
}

TriangleMesh klein_bottle(int around, int across) {
  TriangleMesh mesh;
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const double u = 2 * pi * i / around, v = 2 * pi * j / across;
      const double w = std::cos(u / 2) * std::sin(v) - std::sin(u / 2) * std::sin(2 * v);
      mesh.positions.push_back({(1 + 0.4 * w) * std::cos(u), (1 + 0.4 * w) * std::sin(u),
                                0.4 * (std::sin(u / 2) * std::sin(v) + std::cos(u / 2) * std::sin(2 * v))});
    }
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const bool last = i + 1 == around;
      const int next = last ? 0 : (i + 1) * across, j1 = (j + 1) % across;
      // After one turn around the bottle, v comes back as -v.
      const int d = next + (last ? (across - j) % across : j),
                c = next + (last ? (across - j1) % across : j1);
      add_quad(mesh, i * across + j, d, c, i * across + j1);
    }
  return mesh;
}

}  // namespace nmc::corpus
