// SPDX-License-Identifier: Apache-2.0
#include "encoder/read/polygon_triangulation.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "tests/unit/read/read_test_tools.h"

namespace nmc {
namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

Triangles triangulated(const std::vector<Vec3>& polygon) {
  Triangles triangles;
  triangulate_polygon(polygon, triangles);
  return triangles;
}

Vec3 area_vector(const std::vector<Vec3>& p, const std::array<std::uint32_t, 3>& t) {
  return 0.5 * cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]);
}

/// All triangles turn like the polygon and their areas add up to its area: then they cover it without
/// overlap.
void check_exact_cover(const std::vector<Vec3>& polygon, double area) {
  const Triangles triangles = triangulated(polygon);
  REQUIRE(triangles.size() == polygon.size() - 2);
  Vec3 total;
  double sum = 0;
  std::set<std::uint32_t> used;
  for (const auto& t : triangles) {
    total += area_vector(polygon, t);
    sum += norm(area_vector(polygon, t));
    used.insert(t.begin(), t.end());
  }
  CHECK(norm(total) == Approx(area));
  CHECK(sum == Approx(area));
  CHECK(used.size() == polygon.size());
}

/// Rotated and moved far away, to be sure that no axis is special.
std::vector<Vec3> placed(const std::vector<std::array<double, 2>>& outline, const Vec3& u, const Vec3& v,
                         const Vec3& origin) {
  std::vector<Vec3> polygon;
  for (const auto& [x, y] : outline) polygon.push_back(origin + u * x + v * y);
  return polygon;
}

TEST_CASE("polygon triangulation: a convex polygon becomes the fan of its first corner", "[polygon]") {
  std::vector<Vec3> hexagon;
  for (int i = 0; i < 6; ++i)
    hexagon.push_back({std::cos(i * std::numbers::pi / 3), std::sin(i * std::numbers::pi / 3), 2});
  CHECK(triangulated(hexagon) == Triangles{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}});
}

TEST_CASE("polygon triangulation: a concave quadrilateral is cut at its reflex corner", "[polygon]") {
  // Reflex at corner 1, so the diagonal 0-2 lies outside.
  const std::vector<Vec3> dart = {{0, 0, 0}, {1, 1, 0}, {2, 0, 0}, {1, 3, 0}};
  CHECK(triangulated(dart) == Triangles{{1, 2, 3}, {1, 3, 0}});
}

TEST_CASE("polygon triangulation: covers concave polygons exactly in any plane", "[polygon]") {
  const std::vector<std::array<double, 2>> comb = {{0, 0}, {7, 0}, {7, 3}, {6, 3}, {6, 1}, {5, 1},
                                                   {5, 3}, {4, 3}, {4, 1}, {3, 1}, {3, 3}, {2, 3},
                                                   {2, 1}, {1, 1}, {1, 3}, {0, 3}};
  const std::vector<std::array<double, 2>> spiral = {{0, 0}, {6, 0}, {6, 6}, {1, 6}, {1, 2}, {4, 2}, {4, 4},
                                                     {3, 4}, {3, 3}, {2, 3}, {2, 5}, {5, 5}, {5, 1}, {0, 1}};
  const std::vector<std::array<double, 2>> with_straight_corners = {
      {0, 0}, {1, 0}, {2, 0}, {3, 0}, {3, 1}, {3, 2}, {2, 2}, {2, 1}, {1, 1}, {1, 2}, {0, 2}, {0, 1}};
  const auto area_of = [](const std::vector<std::array<double, 2>>& outline) {
    double twice = 0;
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const auto& [x0, y0] = outline[i];
      const auto& [x1, y1] = outline[(i + 1) % outline.size()];
      twice += x0 * y1 - x1 * y0;
    }
    return twice / 2;
  };
  const double s = std::sqrt(0.5);
  for (const auto& outline : {comb, spiral, with_straight_corners}) {
    for (const auto& [u, v] : std::vector<std::pair<Vec3, Vec3>>{{{1, 0, 0}, {0, 1, 0}},
                                                                 {{0, 1, 0}, {1, 0, 0}},
                                                                 {{0, 1, 0}, {0, 0, 1}},
                                                                 {{0, 0, 1}, {1, 0, 0}},
                                                                 {{s, s, 0}, {0, 0, 1}},
                                                                 {{s, 0, s}, {0, 1, 0}}}) {
      CAPTURE(outline.size(), u, v);
      check_exact_cover(placed(outline, u, v, {0, 0, 0}), area_of(outline));
      check_exact_cover(placed(outline, u, v, {1000, -2000, 500}), area_of(outline));
    }
  }
}

TEST_CASE("polygon triangulation: covers random star-shaped outlines exactly", "[polygon]") {
  std::uint64_t state = 0x9e3779b97f4a7c15u;
  const auto random = [&] {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return static_cast<double>(state >> 40) / static_cast<double>(1 << 24);
  };
  for (int round = 0; round < 50; ++round) {
    const int count = 5 + round;
    std::vector<Vec3> polygon;
    double twice = 0;
    for (int i = 0; i < count; ++i) {
      const double angle = 2 * std::numbers::pi * i / count, radius = 0.2 + random();
      polygon.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
    }
    for (int i = 0; i < count; ++i) twice += cross(polygon[i], polygon[(i + 1) % count]).z;
    CAPTURE(round);
    check_exact_cover(polygon, twice / 2);
  }
}

TEST_CASE("polygon triangulation: always gives n - 2 triangles, whatever the polygon", "[polygon]") {
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               infinity = std::numeric_limits<double>::infinity();
  const std::vector<std::vector<Vec3>> polygons = {
      std::vector<Vec3>(7),                                                 // all corners in one point
      {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}},              // all on one line
      {{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}},                         // a bow tie
      {{0, 0, 0}, {2, 2, 0}, {0, 2, 0}, {2, 0, 0}, {1, 3, 0}, {1, -1, 0}},  // crosses itself
      {{0, 0, 0}, {nan, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 2, 0}},
      {{0, 0, 0}, {infinity, 0, 0}, {1, 1, 0}, {0, -infinity, 0}, {0, 2, 0}},
      {{0, 0, 0}, {1e308, 0, 0}, {1e308, 1e308, 0}, {0, 1e308, 0}, {-1e308, 5, 0}},
  };
  for (const std::vector<Vec3>& polygon : polygons) {
    const Triangles triangles = triangulated(polygon);
    REQUIRE(triangles.size() == polygon.size() - 2);
    std::set<std::uint32_t> used;
    for (const auto& t : triangles) {
      for (const std::uint32_t corner : t) CHECK(corner < polygon.size());
      used.insert(t.begin(), t.end());
    }
    CHECK(used.size() == polygon.size());
  }
}

}  // namespace
}  // namespace nmc
