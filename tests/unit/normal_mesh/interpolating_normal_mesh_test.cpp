// SPDX-License-Identifier: Apache-2.0
#include "encoder/normal_mesh/interpolating_normal_mesh.h"

#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <utility>

#include "encoder/normal_mesh/flip_test.h"
#include "tests/unit/normal_mesh/synthetic_surfaces.h"

namespace nmc {
namespace {

struct Scene {
  Parameterization map;
  DomainParameterizedSurface surface;
  SurfaceIndex index;
  explicit Scene(Parameterization parameterization)
      : map(std::move(parameterization)), surface(map), index(*map.surface) {}
  InterpolatingResult interpolate(const InterpolatingOptions& options) const {
    return nmc::interpolate(surface, index, base_of(map), options);
  }
};

double largest_difference(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  if (a.size() != b.size()) return std::numeric_limits<double>::infinity();
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, distance(a[i], b[i]));
  return worst;
}

TEST_CASE("interpolating normal mesh: details reconstruct points of the input", "[interpolating]") {
  for (const double shake : {0.0, 0.2}) {
    const Scene scene(make_parameterization(test::icosahedron(), 4, shake, test::on_bumpy_sphere));
    InterpolatingOptions options;
    options.level_count = 4;
    const InterpolatingResult result = scene.interpolate(options);
    CHECK(largest_difference(result.positions, reconstruct(result.mesh, 4)) == 0);
    double from_surface = 0, from_parameter = 0;
    for (std::size_t v = 0; v < result.positions.size(); ++v) {
      from_surface = std::max(from_surface, scene.index.closest_point(result.positions[v]).t);
      const Vec3 at_parameter = scene.surface.position(scene.surface.locate(result.parameters[v]));
      from_parameter = std::max(from_parameter, distance(result.positions[v], at_parameter));
    }
    CHECK(from_surface < 1e-13);
    CHECK(from_parameter < 1e-11);
    CHECK(result.non_normal_share() < 0.01);
    for (std::size_t l = 0; l < 4; ++l) {
      for (std::size_t e = 0; e < result.mesh.details[l].size(); ++e) {
        if (result.mesh.non_normal[l][e]) continue;
        CHECK(result.mesh.details[l][e].along == 0);
        CHECK(result.mesh.details[l][e].across == 0);
      }
    }
  }
}

TEST_CASE("interpolating normal mesh: on a smooth surface offsets decay as the prediction promises",
          "[interpolating]") {
  const Scene scene(make_parameterization(test::icosahedron(), 6, 0, test::on_bumpy_sphere));
  double factor[2];
  for (const double tension : {0.0, 1.0}) {
    InterpolatingOptions options;
    options.tension = tension;
    options.level_count = 5;
    const InterpolatingResult result = scene.interpolate(options);
    CHECK(result.non_normal_share() < 0.002);
    std::vector<double> mean;
    for (const auto& level : result.mesh.details) {
      double sum = 0;
      for (const OddVertexDetail& detail : level) sum += std::abs(detail.normal);
      mean.push_back(sum / static_cast<double>(level.size()));
    }
    factor[tension > 0] = mean[2] / mean[4];
  }
  // Midpoint prediction: h^2, a factor of 4 per level. Butterfly: h^4 where regular, until the facets of the
  // input show.
  CHECK(factor[0] > 13);
  CHECK(factor[0] < 19);
  CHECK(factor[1] > 40);
}

TEST_CASE("interpolating normal mesh: a plane needs no detail at all", "[interpolating]") {
  const Scene scene(make_parameterization(test::sheet(3), 3, 0, test::unchanged));
  InterpolatingOptions options;
  options.level_count = 3;
  options.tension = 0;  // the four-point rule would round the corners of the square
  const InterpolatingResult result = scene.interpolate(options);
  CHECK(result.non_normal_share() == 0);
  double largest = 0;
  for (const auto& level : result.mesh.details)
    for (const OddVertexDetail& d : level)
      largest = std::max({largest, std::abs(d.normal), std::abs(d.across), std::abs(d.along)});
  CHECK(largest < 1e-14);
}

TEST_CASE("interpolating normal mesh: the reparameterization stays free of folds", "[interpolating]") {
  const Scene scene(make_parameterization(test::octahedron(), 5, 0.3, test::on_bumpy_sphere));
  for (const ParameterPrediction prediction :
       {ParameterPrediction::kMidpoint, ParameterPrediction::kButterfly}) {
    InterpolatingOptions options;
    options.level_count = 5;
    options.parameter_prediction = prediction;
    const InterpolatingResult result = scene.interpolate(options);
    for (const LevelStatistics& level : result.levels) CHECK(level.folded_face_count == 0);
    const LevelTopology& finest = result.mesh.hierarchy.level(5);
    int folded = 0;
    for (std::uint32_t f = 0; f < finest.face_count; ++f) {
      SurfaceParameter corners[3];
      for (int k = 0; k < 3; ++k) corners[k] = result.parameters[finest.face_vertices[3 * f + k]];
      LocalChart chart;
      ChartPoint at[3];
      REQUIRE(scene.surface.make_chart(f >> 10, corners, chart, at));
      folded += face_ratio(at[0], at[1], at[2]) <= 0;
    }
    CHECK(folded == 0);
  }
}

TEST_CASE("interpolating normal mesh: boundary vertices lie on the boundary and need two scalars",
          "[interpolating]") {
  const Scene scene(make_parameterization(test::sheet(2), 5, 0.2, [](const Vec3& p) {
    const Vec3 q = test::on_wavy_sheet(p);
    return Vec3{q.x + 0.1 * std::sin(3 * q.y), q.y + 0.08 * std::cos(2 * q.x), q.z};
  }));
  std::vector<Vec3> boundary_points;
  std::vector<Triangle> boundary_segments;
  for (std::uint32_t f = 0; f < scene.map.domain.face_count(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const auto knots = scene.surface.curve(f, k);
      for (std::size_t i = 0; i < knots.size(); ++i) {
        boundary_points.push_back(scene.map.surface->positions[knots[i].vertex]);
        const auto last = static_cast<std::uint32_t>(boundary_points.size() - 1);
        if (i > 0) boundary_segments.push_back({last - 1, last, last});
      }
    }
  }
  const SurfaceIndex boundary(boundary_points, boundary_segments);
  InterpolatingOptions options;
  options.level_count = 4;
  const InterpolatingResult result = scene.interpolate(options);
  double worst = 0;
  int curve_vertices = 0, three_scalars = 0;
  for (int l = 0; l < 4; ++l) {
    const LevelTopology& topology = result.mesh.hierarchy.level(l);
    for (std::uint32_t e = 0; e < topology.edge_count; ++e) {
      if (!topology.is_boundary(e)) continue;
      ++curve_vertices;
      worst = std::max(worst, boundary.closest_point(result.positions[topology.vertex_count + e]).t);
      three_scalars += result.mesh.details[static_cast<std::size_t>(l)][e].along != 0;
    }
  }
  CHECK(curve_vertices == 8 * 15);
  CHECK(worst < 1e-12);
  CHECK(three_scalars == 0);
  CHECK(result.non_normal_share() < 0.02);
}

TEST_CASE("interpolating normal mesh: crease vertices stay on the crease", "[interpolating]") {
  test::BaseShape shape = test::sheet(2);
  shape.creases = {{3, 4}, {4, 5}};
  const Scene scene(make_parameterization(shape, 4, 0.2, [](const Vec3& p) {
    return Vec3{p.x, p.y, std::abs(p.y - 1) + 0.1 * std::sin(2 * p.x)};
  }));
  InterpolatingOptions options;
  options.level_count = 3;
  const InterpolatingResult result = scene.interpolate(options);
  int crease_vertices = 0;
  for (int l = 0; l < 3; ++l) {
    const LevelTopology& topology = result.mesh.hierarchy.level(l);
    for (std::uint32_t e = 0; e < topology.edge_count; ++e) {
      if (!topology.is_curve(e) || topology.is_boundary(e)) continue;
      ++crease_vertices;
      CHECK(result.positions[topology.vertex_count + e].y == Approx(1).margin(1e-12));
    }
  }
  CHECK(crease_vertices == 2 * 7);
}

TEST_CASE("interpolating normal mesh: a narrow aperture makes more vectors than a wide one",
          "[interpolating]") {
  const Scene scene(make_parameterization(test::icosahedron(), 5, 0, [](const Vec3& p) {
    const Vec3 n = normalized(p);  // the map slides along the surface
    return test::on_bumpy_sphere(n + 0.12 * Vec3{std::sin(4 * n.y), std::sin(3 * n.z), std::cos(5 * n.x)});
  }));
  InterpolatingOptions options;
  options.level_count = 4;
  options.aperture_rule = ApertureRule::kParametric;
  std::vector<double> share;
  for (const double aperture : {0.05, 0.2, 0.43}) {
    options.coarse_aperture = options.fine_aperture = aperture;
    share.push_back(scene.interpolate(options).non_normal_share());
  }
  options.aperture_rule = ApertureRule::kAdaptive;
  options.coarse_aperture = 0.6;
  options.fine_aperture = 0.8;
  share.push_back(scene.interpolate(options).non_normal_share());
  INFO("shares " << share[0] << " " << share[1] << " " << share[2] << ", adaptive " << share[3]);
  CHECK(share[0] > share[1]);
  CHECK(share[1] > share[2]);
  CHECK(share[2] >= share[3]);
  CHECK(share[3] < 0.01);
}

TEST_CASE("interpolating normal mesh: one level from a decoder's positions repairs their error",
          "[interpolating]") {
  const Scene scene(make_parameterization(test::icosahedron(), 4, 0.1, test::on_bumpy_sphere));
  InterpolatingOptions options;
  options.level_count = 2;
  InterpolatingResult coarse = scene.interpolate(options);
  std::vector<Vec3> rounded = coarse.positions;
  for (Vec3& p : rounded)
    for (int i = 0; i < 3; ++i) p[i] = std::round(p[i] * 100) / 100;
  coarse.mesh.hierarchy.refine_to(3);
  const LevelInsertion insertion =
      insert_level(scene.surface, scene.index, coarse.mesh.hierarchy, 2, rounded, coarse.parameters, options);
  double worst = 0;
  for (const Vec3& p : insertion.positions) worst = std::max(worst, scene.index.closest_point(p).t);
  CHECK(worst < 1e-13);
  CHECK(insertion.statistics.non_normal_count < insertion.statistics.vertex_count / 50);
}

TEST_CASE("interpolating normal mesh: the same bits for one thread and for two", "[interpolating]") {
  const Scene scene(make_parameterization(test::octahedron(), 5, 0.3, test::on_bumpy_sphere));
  InterpolatingOptions options;
  options.level_count = 4;
  std::vector<InterpolatingResult> results;
  for (const std::size_t threads : {1u, 2u}) {
    const oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism, threads);
    results.push_back(scene.interpolate(options));
  }
  CHECK(largest_difference(results[0].positions, results[1].positions) == 0);
  CHECK(results[0].mesh.non_normal == results[1].mesh.non_normal);
}

TEST_CASE("flip test: a vertex that turns a face over falls back, its neighbours stay", "[flip_test]") {
  const Scene scene(make_parameterization(test::octahedron(), 3, 0, test::on_unit_sphere));
  const ParameterizedBase base = base_of(scene.map);
  const SubdivisionHierarchy hierarchy(base.faces, 6, 1);
  const LevelTopology& topology = hierarchy.level(0);
  std::vector<OddVertexChoice> choices(topology.edge_count);
  for (std::uint32_t e = 0; e < topology.edge_count; ++e) {
    const SurfaceParameter ends[2] = {base.parameters[topology.edge_vertices[2 * e]],
                                      base.parameters[topology.edge_vertices[2 * e + 1]]};
    LocalChart chart;
    ChartPoint at[2];
    REQUIRE(scene.surface.make_chart(topology.edge_faces[2 * e], ends, chart, at));
    choices[e].midpoint = choices[e].predicted = choices[e].parameter =
        scene.surface.from_chart(chart, 0.5 * (at[0] + at[1]));
    choices[e].source = OddVertexSource::kPierced;
  }
  choices[topology.face_edges[0]].parameter = {0, 0.05, 0.05, 0};  // of face 0, beside the opposite corner
  const FlipTestResult result = resolve_flips(scene.surface, topology, 0, base.parameters, 0.02, choices);
  CHECK(result.demoted_count == 1);
  CHECK(result.folded_face_count == 0);
  for (std::uint32_t e = 0; e < topology.edge_count; ++e)
    CHECK((choices[e].source == OddVertexSource::kPierced) == (e != topology.face_edges[0]));
}

}  // namespace
}  // namespace nmc
