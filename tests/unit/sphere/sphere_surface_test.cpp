// SPDX-License-Identifier: Apache-2.0
#include "encoder/sphere/sphere_surface.h"

#include <catch2/catch.hpp>

#include "encoder/normal_mesh/interpolating_normal_mesh.h"
#include "encoder/sphere/exact_orientation.h"
#include "encoder/sphere/sphere_base.h"
#include "tests/unit/sphere/sphere_test_meshes.h"

using namespace nmc;

namespace {

SphereParameterizedSurface spiky_surface() {
  auto mesh = std::make_shared<TriangleMesh>(nmc_test::spiky_sphere(4, 0.4));
  std::vector<Vec3> positions = parameterize_sphere(*mesh).positions;
  return {mesh, std::move(positions)};
}

}  // namespace

TEST_CASE("locating a direction and taking its parameter is the identity on the sphere") {
  const SphereParameterizedSurface surface = spiky_surface();
  double worst = 0;
  for (int i = 0; i < 2000; ++i) {
    const double z = 1 - (2 * i + 1) / 2000.0, angle = 2.399963229728653 * i;
    const double r = std::sqrt(1 - z * z);
    const Vec3 x{r * std::cos(angle), r * std::sin(angle), z};
    worst = std::max(worst, distance(to_unit_vector(surface.parameter(surface.locate(to_parameter(x)))), x));
  }
  CHECK(worst < 1e-12);
  // Vertices are found exactly.
  for (std::uint32_t v = 0; v < 50; ++v) {
    const SurfaceLocation location = surface.locate(to_parameter(surface.sphere_positions()[v]));
    CHECK(distance(surface.position(location), surface.surface().positions[v]) < 1e-12);
  }
}

TEST_CASE(
    "charts keep orientation, map midpoints to midpoints of great circles, and are refused beyond 80 "
    "degrees") {
  const SphereParameterizedSurface surface = spiky_surface();
  const Vec3 a = normalized(Vec3{1, 0.2, 0.3}), b = normalized(Vec3{0.8, 0.7, 0.2}),
             c = normalized(Vec3{0.7, 0.4, 0.9});
  const SurfaceParameter points[3] = {to_parameter(a), to_parameter(b), to_parameter(c)};
  LocalChart chart;
  ChartPoint at[3];
  REQUIRE(surface.make_chart(0, points, chart, at));
  CHECK(orientation_sign(a, b, c) > 0);
  CHECK(face_ratio(at[0], at[1], at[2]) > 0);
  CHECK(distance(to_unit_vector(surface.from_chart(chart, at[1])), b) < 1e-14);
  LocalChart edge;
  ChartPoint ends[2];
  REQUIRE(surface.make_chart(0, std::span(points, 2), edge, ends));
  const Vec3 middle = to_unit_vector(surface.from_chart(edge, 0.5 * (ends[0] + ends[1])));
  CHECK(distance(middle, normalized(a + b)) < 1e-14);
  const SurfaceParameter opposite[2] = {to_parameter(Vec3{1, 0, 0}), to_parameter(Vec3{-1, 0, 0})};
  CHECK_FALSE(surface.make_chart(0, opposite, edge, ends));
}

TEST_CASE("every base is a closed polyhedron around the centre, with its vertices on the surface") {
  const SphereParameterizedSurface surface = spiky_surface();
  struct Case {
    SphereBaseKind kind;
    std::size_t vertices;
  };
  for (const Case& c : {Case{SphereBaseKind::kTetrahedron, 4}, Case{SphereBaseKind::kOctahedron, 6},
                        Case{SphereBaseKind::kIcosahedron, 12}, Case{SphereBaseKind::kAdaptive, 60}}) {
    SphereBaseOptions options;
    options.kind = c.kind;
    options.rotation_count = 4;
    options.adaptive_vertex_count = 60;
    const ParameterizedBase base = sphere_base(surface, options);
    INFO("base of " << c.vertices << " vertices");
    REQUIRE(base.positions.size() == c.vertices);
    std::vector<Vec3> directions;
    for (const SurfaceParameter& p : base.parameters) directions.push_back(to_unit_vector(p));
    CHECK(certify_sphere(directions, base.faces).is_bijective());
    for (std::size_t i = 0; i < base.positions.size(); ++i)
      CHECK(distance(surface.position(surface.locate(base.parameters[i])), base.positions[i]) < 1e-9);
  }
}

TEST_CASE("a normal mesh over the icosahedron converges to the surface, nearly all of it normal") {
  const SphereParameterizedSurface surface = spiky_surface();
  const SurfaceIndex index(surface.surface());
  InterpolatingOptions options;
  options.level_count = 4;
  const InterpolatingResult result = interpolate(surface, index, sphere_base(surface), options);
  CHECK(result.positions.size() == 2562);
  CHECK(result.non_normal_share() < 0.02);
  double worst = 0;
  for (const Vec3& p : result.positions) worst = std::max(worst, index.closest_point(p).t);
  CHECK(worst < 1e-9);
}
