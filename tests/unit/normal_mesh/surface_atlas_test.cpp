// SPDX-License-Identifier: Apache-2.0
#include "encoder/normal_mesh/surface_atlas.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <utility>

#include "tests/unit/normal_mesh/synthetic_surfaces.h"

namespace nmc {
namespace {

using test::Random;

struct NamedMap {
  std::string name;
  Parameterization map;
};

std::vector<NamedMap> maps() {
  std::vector<NamedMap> result;
  for (const double shake : {0.0, 0.2}) {
    const std::string suffix = shake > 0 ? ", shaken" : ", straight";
    result.push_back(
        {"tetrahedron" + suffix, make_parameterization(test::tetrahedron(), 4, shake, test::on_unit_sphere)});
    result.push_back(
        {"octahedron" + suffix, make_parameterization(test::octahedron(), 4, shake, test::on_bumpy_sphere)});
    result.push_back({"icosahedron" + suffix,
                      make_parameterization(test::icosahedron(), 3, shake, test::on_bumpy_sphere)});
    result.push_back({"coarse icosahedron" + suffix,
                      make_parameterization(test::icosahedron(), 1, shake, test::on_unit_sphere)});
    result.push_back({"torus" + suffix, make_parameterization(test::torus(5, 4), 2, shake, test::unchanged)});
    result.push_back(
        {"sheet" + suffix, make_parameterization(test::sheet(2), 3, shake, test::on_wavy_sheet)});
  }
  return result;
}

Vec3 position(const Parameterization& map, const SurfaceLocation& location) {
  Vec3 p;
  for (int k = 0; k < 3; ++k)
    p += location.barycentric[k] * map.surface->positions[map.surface->triangles[location.triangle][k]];
  return p;
}

SurfaceLocation random_location(const Parameterization& map, Random& random) {
  SurfaceLocation location{random.below(map.surface->triangle_count()), {}};
  double a = random.uniform(), b = random.uniform();
  if (a + b > 1) {
    a = 1 - a;
    b = 1 - b;
  }
  location.barycentric[0] = 1 - a - b;
  location.barycentric[1] = a;
  location.barycentric[2] = b;
  return location;
}

TEST_CASE("surface atlas: finds every surface vertex at its domain point", "[surface_atlas]") {
  for (const NamedMap& m : maps()) {
    INFO(m.name);
    const SurfaceAtlas atlas(m.map);
    CHECK(atlas.folded_triangle_count() == 0);
    CHECK(atlas.entry_count() >= m.map.surface->triangle_count());
    double worst = 0;
    for (std::uint32_t v = 0; v < m.map.surface->vertex_count(); ++v) {
      const SurfaceLocation location = atlas.locate(m.map.vertex_points[v]);
      worst = std::max(worst, distance(position(m.map, location), m.map.surface->positions[v]));
    }
    CHECK(worst < 1e-11);
    CHECK(atlas.nearest_triangle_count() == 0);
  }
}

TEST_CASE("surface atlas: there and back again returns the surface point", "[surface_atlas]") {
  for (const NamedMap& m : maps()) {
    INFO(m.name);
    const SurfaceAtlas atlas(m.map);
    Random random(11);
    double worst = 0;
    for (int i = 0; i < 20000; ++i) {
      const SurfaceLocation there = random_location(m.map, random);
      const SurfaceLocation back = atlas.locate(atlas.domain_point(there));
      worst = std::max(worst, distance(position(m.map, there), position(m.map, back)));
    }
    CHECK(worst < 1e-10);
    CHECK(atlas.nearest_triangle_count() == 0);
  }
}

TEST_CASE("surface atlas: neighbouring faces agree along their common edge and around cones",
          "[surface_atlas]") {
  for (const NamedMap& m : maps()) {
    INFO(m.name);
    const SurfaceAtlas atlas(m.map);
    const BaseDomain& domain = m.map.domain;
    double worst = 0;
    for (std::uint32_t f = 0; f < domain.face_count(); ++f) {
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t g = domain.neighbor(f, k);
        if (g == kNoFace) continue;
        for (const double s : {0x1p-30, 0x1p-12, 0.03125, 0.3125, 0.5, 0.875, 1 - 0x1p-20}) {
          const ChartPoint at = (1 - s) * kFaceCorners[(k + 1) % 3] + s * kFaceCorners[(k + 2) % 3];
          int j = 0;
          while (domain.neighbor(g, j) != f || domain.face(g)[(j + 1) % 3] != domain.face(f)[(k + 2) % 3])
            ++j;
          const ChartPoint same = domain.hinge(g, j)(at);
          worst = std::max(worst, distance(position(m.map, atlas.locate({f, at})),
                                           position(m.map, atlas.locate({g, same}))));
        }
      }
    }
    CHECK(worst < 1e-10);
    for (std::uint32_t v = 0; v < domain.vertex_count(); ++v) {
      for (const std::uint32_t f : domain.faces_around(v)) {
        const Vec3 p = position(m.map, atlas.locate({f, kFaceCorners[domain.corner_of(f, v)]}));
        CHECK(p == m.map.base_positions[v]);
      }
    }
    CHECK(atlas.nearest_triangle_count() == 0);
  }
}

TEST_CASE("surface atlas: a dense grid of each face is covered", "[surface_atlas]") {
  for (const NamedMap& m : maps()) {
    INFO(m.name);
    const SurfaceAtlas atlas(m.map);
    constexpr int n = 48;
    for (std::uint32_t f = 0; f < m.map.domain.face_count(); ++f) {
      for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n - i; ++j)
          atlas.locate({f, snap_to_grid({double(i) / n, double(j) / n * (1 - 1e-15)})});
    }
    CHECK(atlas.nearest_triangle_count() == 0);
  }
}

TEST_CASE("surface atlas: chart coordinates of a surface point agree with its domain point",
          "[surface_atlas]") {
  for (const NamedMap& m : maps()) {
    INFO(m.name);
    const SurfaceAtlas atlas(m.map);
    Random random(12);
    double worst = 0;
    for (int i = 0; i < 2000; ++i) {
      const SurfaceLocation location = random_location(m.map, random);
      const DomainPoint p = atlas.domain_point(location);
      const auto at = atlas.chart_point(location, p.face);
      REQUIRE(at);
      worst = std::max(worst, std::sqrt(squared_length(*at - p.at)));
    }
    CHECK(worst < 1e-13);
  }
}

TEST_CASE("surface atlas: boundary and crease edges know their polylines", "[surface_atlas]") {
  test::BaseShape shape = test::sheet(2);
  shape.creases = {{3, 4}, {4, 5}};  // the middle row
  const Parameterization map = make_parameterization(shape, 3, 0.2, test::on_wavy_sheet);
  const SurfaceAtlas atlas(map);
  int curves = 0;
  for (std::uint32_t f = 0; f < map.domain.face_count(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const std::vector<CurveKnot> knots = atlas.curve(f, k);
      if (map.domain.edge_tag(f, k) == EdgeTag::kSmooth) {
        CHECK(knots.empty());
        continue;
      }
      ++curves;
      REQUIRE(knots.size() == 9);
      CHECK(knots.front().share == 0);
      CHECK(knots.front().vertex == map.domain.face(f)[(k + 1) % 3]);
      CHECK(knots.back().share == 1);
      CHECK(knots.back().vertex == map.domain.face(f)[(k + 2) % 3]);
      for (std::size_t i = 1; i < knots.size(); ++i) {
        CHECK(knots[i].share > knots[i - 1].share);
        const Vec3 step =
            map.surface->positions[knots[i].vertex] - map.surface->positions[knots[i - 1].vertex];
        CHECK(norm(Vec3{step.x, step.y, 0}) == Approx(0.125));
      }
    }
  }
  CHECK(curves == 8 + 4);  // the crease from both of its sides
}

}  // namespace
}  // namespace nmc
