// SPDX-License-Identifier: Apache-2.0
#include "encoder/spatial/surface_index.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "encoder/core/parallel.h"
#include "tests/unit/spatial/test_meshes.h"

namespace nmc {
namespace {

using test::Random;

// Moeller and Trumbore's test in long double: the oracle for rays that stay clear of edges.
std::vector<double> brute_force_hits(const TriangleMesh& mesh, const Vec3& origin, const Vec3& direction,
                                     double t_minimum, double t_maximum) {
  using Real = long double;
  std::vector<double> hits;
  for (const Triangle& triangle : mesh.triangles) {
    Real corner[3][3];
    for (int k = 0; k < 3; ++k) {
      for (int i = 0; i < 3; ++i) corner[k][i] = Real(mesh.positions[triangle[k]][i]) - origin[i];
    }
    // Solve u (b - a) + v (c - a) - t d = -a by Cramer's rule.
    Real m[3][3], right[3];
    for (int i = 0; i < 3; ++i) {
      m[i][0] = corner[1][i] - corner[0][i];
      m[i][1] = corner[2][i] - corner[0][i];
      m[i][2] = -Real(direction[i]);
      right[i] = -corner[0][i];
    }
    const auto determinant = [](const Real(&a)[3][3]) {
      return a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) -
             a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0]) +
             a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
    };
    const Real whole = determinant(m);
    Real solution[3];
    for (int column = 0; column < 3; ++column) {
      Real replaced[3][3];
      for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) replaced[i][k] = k == column ? right[i] : m[i][k];
      }
      solution[column] = determinant(replaced) / whole;
    }
    if (solution[0] < 0 || solution[1] < 0 || solution[0] + solution[1] > 1) continue;
    if (solution[2] >= t_minimum && solution[2] <= t_maximum)
      hits.push_back(static_cast<double>(solution[2]));
  }
  std::sort(hits.begin(), hits.end());
  return hits;
}

TEST_CASE("closest_point agrees with brute force on triangle soups of every size and place") {
  const struct {
    double size, spread, offset;
  } cases[] = {{0.05, 1.2, 0}, {2.0, 1.2, 0},    {1e-4, 1.2, 0},
               {0.05, 30, 0},  {0.05, 1.2, 1e7}, {0.3, 1e5, -3e5}};
  for (const auto& c : cases) {
    const Vec3 offset{c.offset, -c.offset, 2 * c.offset};
    const TriangleMesh mesh = test::triangle_soup(7, 400, c.size, offset);
    const SurfaceIndex index(mesh);
    Random random(11);
    for (int i = 0; i < 400; ++i) {
      const Vec3 point = offset + random.point(-c.spread, c.spread);
      const SurfacePoint nearest = index.closest_point(point);
      const double expected = test::brute_force_distance(mesh, point);
      const double tolerance = 1e-13 * (1 + std::abs(c.offset) * 20 + c.spread);
      CAPTURE(c.size, c.spread, c.offset, i);
      REQUIRE(nearest.found());
      REQUIRE(nearest.t == Approx(expected).epsilon(0).margin(tolerance));
      REQUIRE(distance(nearest.position, point) == Approx(nearest.t).epsilon(0).margin(tolerance));
      const double* w = nearest.barycentric;
      REQUIRE(w[0] + w[1] + w[2] == Approx(1).margin(1e-12));
      REQUIRE(std::min({w[0], w[1], w[2]}) >= 0);
    }
  }
}

TEST_CASE("closest_point gives the lowest triangle index where several are equally near") {
  const TriangleMesh flat = test::sheet(8, [](double, double) { return 0.0; });
  const SurfaceIndex index(flat);
  for (int y = 1; y < 8; ++y) {
    for (int x = 1; x < 8; ++x) {
      const std::uint32_t vertex = static_cast<std::uint32_t>(y * 9 + x);
      std::uint32_t lowest = kNoTriangle;
      for (std::uint32_t t = 0; t < flat.triangles.size() && lowest == kNoTriangle; ++t) {
        for (const std::uint32_t corner : flat.triangles[t]) {
          if (corner == vertex) lowest = t;
        }
      }
      const SurfacePoint nearest = index.closest_point({double(x), double(y), 0.75});
      REQUIRE(nearest.triangle == lowest);
      REQUIRE(nearest.t == 0.75);
    }
  }
}

TEST_CASE("closest_point finds nothing beyond the maximum distance and includes it exactly") {
  const TriangleMesh flat = test::sheet(4, [](double, double) { return 0.0; });
  const SurfaceIndex index(flat);
  CHECK(index.closest_point({1.3, 1.6, 0.5}, 0.5).found());
  CHECK_FALSE(index.closest_point({1.3, 1.6, 0.5}, 0.4999999).found());
}

TEST_CASE("is_within says what closest_point finds") {
  const TriangleMesh mesh = test::triangle_soup(5, 300, 0.05, {});
  const SurfaceIndex index(mesh);
  Random random(3);
  int near_count = 0;
  for (int i = 0; i < 400; ++i) {
    const Vec3 point = random.point(-1.2, 1.2);
    const double nearest = index.closest_point(point).t;
    CAPTURE(i, nearest);
    CHECK(index.is_within(point, 1.001 * nearest));
    CHECK_FALSE(index.is_within(point, 0.999 * nearest));
    near_count += index.is_within(point, 0.1);
    CHECK(index.is_within(point, 0.1) == index.closest_point(point, 0.1).found());
  }
  CHECK(near_count > 0);
  CHECK(near_count < 400);
  CHECK_FALSE(index.is_within({0, 0, 0}, -1));
  CHECK(index.is_within({0, 0, 0}, std::numeric_limits<double>::infinity()));
}

TEST_CASE("closest_point is exact on triangles that are a segment or a point") {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {3, 0, 0}, {5, 5, 5}, {7, 0, 0}, {8, 1e-13, 0}, {9, 0, 0}};
  mesh.triangles = {{0, 1, 2}, {3, 3, 3}, {4, 5, 6}};
  const SurfaceIndex index(mesh);
  Random random(3);
  for (int i = 0; i < 500; ++i) {
    const Vec3 point = random.point(-2, 10);
    const SurfacePoint nearest = index.closest_point(point);
    REQUIRE(nearest.found());
    REQUIRE(nearest.t == Approx(test::brute_force_distance(mesh, point)).margin(1e-12));
  }
}

TEST_CASE("all_hits agrees with brute force on triangle soups") {
  for (const double offset : {0.0, 1e6}) {
    const Vec3 shift{offset, offset, -offset};
    const TriangleMesh mesh = test::triangle_soup(21, 300, 0.4, shift);
    const SurfaceIndex index(mesh);
    Random random(5);
    std::vector<SurfacePoint> hits;
    std::size_t total = 0;
    for (int i = 0; i < 500; ++i) {
      const Vec3 origin = shift + random.point(-3, 3);
      const Vec3 direction = (shift + random.point() - origin) * random.uniform(0.1, 10);
      const std::vector<double> expected = brute_force_hits(mesh, origin, direction, -0.5, 20);
      index.all_hits(origin, direction, -0.5, 20, 1000, hits);
      CAPTURE(offset, i);
      REQUIRE(hits.size() == expected.size());
      for (std::size_t k = 0; k < hits.size(); ++k) {
        REQUIRE(hits[k].t == Approx(expected[k]).epsilon(1e-9).margin(1e-13 * (1 + offset)));
      }
      const SurfacePoint first = index.first_hit(origin, direction, -0.5, 20);
      REQUIRE(first.found() == !hits.empty());
      if (first.found()) {
        REQUIRE(first.triangle == hits[0].triangle);
        REQUIRE(first.t == hits[0].t);
      }
      total += hits.size();
    }
    REQUIRE(total > 1000);
  }
}

TEST_CASE("a ray through a shared edge or vertex hits a surface exactly once") {
  const TriangleMesh mesh =
      test::sheet(16, [](double x, double y) { return std::sin(x * 0.7) * std::cos(y * 0.9); });
  const SurfaceIndex index(mesh);
  std::vector<SurfacePoint> hits;
  Random random(17);
  for (const double scale : {1.0, 1e-3, 1e4}) {
    for (std::uint32_t y = 1; y < 16; ++y) {
      for (std::uint32_t x = 1; x < 16; ++x) {
        const Vec3 vertex = mesh.positions[y * 17 + x];
        const Vec3 neighbour = mesh.positions[(y + 1) * 17 + x + 1];
        const double share = random.uniform();
        for (const Vec3& target :
             {vertex, (1 - share) * vertex + share * neighbour, 0.5 * (vertex + neighbour)}) {
          const Vec3 direction = scale * Vec3{random.uniform(-0.05, 0.05), random.uniform(-0.05, 0.05), -1};
          index.all_hits(target - (3 / scale) * direction, direction, 0, 10 / scale, 100, hits);
          CAPTURE(scale, x, y, share);
          REQUIRE(hits.size() == 1);
          REQUIRE(hits[0].t * scale == Approx(3).margin(1e-9));
          REQUIRE(distance(hits[0].position, target) < 1e-9);
          index.all_hits({target.x, target.y, 5}, {0, 0, -1}, 0, 10, 100, hits);
          REQUIRE(hits.size() == 1);
        }
      }
    }
  }
}

TEST_CASE("all_hits keeps the nearest ones when there are too many, and both sides count") {
  TriangleMesh stack;
  for (std::uint32_t i = 0; i < 20; ++i) {
    const double z = (i * 7) % 20;
    for (const Vec3& corner : {Vec3{0, 0, z}, Vec3{4, 0, z}, Vec3{0, 4, z}})
      stack.positions.push_back(corner);
    stack.triangles.push_back({3 * i, 3 * i + 1 + i % 2, 3 * i + 2 - i % 2});
  }
  const SurfaceIndex index(stack);
  std::vector<SurfacePoint> hits;
  index.all_hits({1, 1, -2}, {0, 0, 0.5}, 0, 1e9, 5, hits);
  REQUIRE(hits.size() == 5);
  for (int i = 0; i < 5; ++i) CHECK(hits[static_cast<std::size_t>(i)].t == Approx(4 + 2 * i));
  index.all_hits({1, 1, -2}, {0, 0, 0.5}, 5.5, 9, 100, hits);
  REQUIRE(hits.size() == 2);
  index.all_hits({1, 1, 30}, {0, 0, 1}, -100, 0, 100, hits);
  REQUIRE(hits.size() == 20);
}

TEST_CASE("an empty mesh is never met") {
  const SurfaceIndex index((TriangleMesh()));
  std::vector<SurfacePoint> hits(3);
  index.all_hits({0, 0, 0}, {1, 0, 0}, 0, 1, 10, hits);
  CHECK(hits.empty());
  CHECK_FALSE(index.first_hit({0, 0, 0}, {1, 0, 0}, 0, 1).found());
  CHECK_FALSE(index.closest_point({0, 0, 0}).found());
}

TEST_CASE("queries from many threads give the same answers") {
  const TriangleMesh mesh = test::triangle_soup(99, 3000, 0.1);
  const SurfaceIndex index(mesh);
  Random random(1);
  std::vector<Vec3> points(4000);
  for (Vec3& p : points) p = random.point();
  std::vector<std::uint32_t> nearest(points.size()), first(points.size());
  parallel_for(points.size(), [&](std::size_t i) {
    nearest[i] = index.closest_point(points[i]).triangle;
    first[i] = index.first_hit(points[i], {0.3, 0.1, 0.9}, 0, 10).triangle;
  });
  for (std::size_t i = 0; i < points.size(); ++i) {
    REQUIRE(nearest[i] == index.closest_point(points[i]).triangle);
    REQUIRE(first[i] == index.first_hit(points[i], {0.3, 0.1, 0.9}, 0, 10).triangle);
  }
}

TEST_CASE("a moved index keeps answering") {
  SurfaceIndex first(test::triangle_soup(4, 50, 0.3));
  const SurfacePoint before = first.closest_point({0.1, 0.2, 0.3});
  const SurfaceIndex second(std::move(first));
  CHECK(second.closest_point({0.1, 0.2, 0.3}).triangle == before.triangle);
}

}  // namespace
}  // namespace nmc
