// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cmath>
#include <utility>

#include "encoder/normal_mesh/interpolating_normal_mesh.h"
#include "encoder/normal_mesh/sample_correspondences.h"
#include "encoder/normal_mesh/uncovered_regions.h"
#include "tests/unit/normal_mesh/synthetic_surfaces.h"

namespace nmc {
namespace {

struct Scene {
  Parameterization map;
  DomainParameterizedSurface surface;
  SurfaceIndex index;
  InterpolatingResult result;
  explicit Scene(Parameterization parameterization, int level_count)
      : map(std::move(parameterization)), surface(map), index(*map.surface) {
    InterpolatingOptions options;
    options.level_count = level_count;
    result = interpolate(surface, index, base_of(map), options);
  }
  std::vector<SurfaceSample> samples(const SamplingOptions& options,
                                     SampleStatistics* statistics = nullptr) const {
    const int level = result.mesh.level_count();
    return sample_correspondences(surface, index, result.mesh.hierarchy.level(level), level, result.positions,
                                  result.parameters, options, statistics);
  }
};

TEST_CASE("correspondences: targets lie on the input near the mesh, weights sum to one", "[samples]") {
  const Scene scene(make_parameterization(test::icosahedron(), 4, 0.2, test::on_bumpy_sphere), 3);
  for (const SampleWeighting weighting :
       {SampleWeighting::kMesh, SampleWeighting::kInput, SampleWeighting::kBoth}) {
    SamplingOptions options;
    options.weighting = weighting;
    SampleStatistics statistics;
    const auto samples = scene.samples(options, &statistics);
    CHECK(samples.size() == 20 * 64 * 9);
    CHECK(statistics.count == samples.size());
    CHECK(statistics.doubtful == 0);
    double weight = 0, off_surface = 0, farthest = 0;
    for (const SurfaceSample& s : samples) {
      weight += s.weight;
      off_surface = std::max(off_surface, scene.index.closest_point(s.target).t);
      const LevelTopology& finest = scene.result.mesh.hierarchy.level(3);
      Vec3 own;
      double sum = 0;
      for (std::uint32_t k = 0; k < 3; ++k) {
        own += double{s.barycentric[k]} * scene.result.positions[finest.face_vertices[3 * s.face + k]];
        sum += double{s.barycentric[k]};
      }
      CHECK(sum == Approx(1).margin(1e-6));
      farthest = std::max(farthest, distance(own, s.target));
      CHECK(norm(s.normal) == Approx(1).margin(1e-12));
    }
    CHECK(weight == Approx(1).margin(1e-5));
    CHECK(off_surface < 1e-12);
    CHECK(farthest < 0.05);
  }
}

TEST_CASE("correspondences: weights by input area integrate over the input", "[samples]") {
  // A base of two large faces over a sheet whose left half is stretched in space.
  const Scene scene(make_parameterization(test::sheet(1), 4, 0,
                                          [](const Vec3& p) {
                                            return Vec3{p.x < 0.5 ? 3 * p.x : 1 + p.x, p.y, 0};
                                          }),
                    2);
  const auto left_share = [&](SampleWeighting weighting) {
    SamplingOptions options;
    options.weighting = weighting;
    options.subdivisions = 8;
    double sum = 0;
    for (const SurfaceSample& s : scene.samples(options)) sum += s.target.x < 1.5 ? s.weight : 0;
    return sum;
  };
  CHECK(left_share(SampleWeighting::kInput) == Approx(0.75).margin(0.01));
}

TEST_CASE("correspondences: a target on a wrong sheet is replaced, a hopeless one weighs little",
          "[samples]") {
  Scene scene(make_parameterization(test::icosahedron(), 4, 0, test::on_bumpy_sphere), 2);
  // Parameters of the opposite side: the map now points through the body.
  SampleStatistics statistics;
  auto swapped = scene.result.parameters;
  const LevelTopology& finest = scene.result.mesh.hierarchy.level(2);
  const std::uint32_t odd = finest.vertex_count - 1;
  for (std::uint32_t v = 12; v < finest.vertex_count; ++v) {
    if (dot(scene.result.positions[v], scene.result.positions[odd]) < -0.9)
      swapped[odd] = scene.result.parameters[v];
  }
  const auto samples = sample_correspondences(scene.surface, scene.index, finest, 2, scene.result.positions,
                                              swapped, {}, &statistics);
  CHECK(statistics.replaced > 0);
  double farthest = 0;
  for (const SurfaceSample& s : samples) {
    Vec3 own;
    for (std::uint32_t k = 0; k < 3; ++k)
      own += double{s.barycentric[k]} * scene.result.positions[finest.face_vertices[3 * s.face + k]];
    farthest = std::max(farthest, distance(own, s.target));
  }
  CHECK(farthest < 1.0);  // within three edges; the sphere is 2 across

  // A mesh turned inside out agrees with no normal anywhere.
  std::vector<Vec3> inside_out;
  for (const Vec3& p : scene.result.positions) inside_out.push_back(-p);
  const auto doubtful = sample_correspondences(scene.surface, scene.index, finest, 2, inside_out,
                                               scene.result.parameters, {}, &statistics);
  CHECK(statistics.doubtful > statistics.count * 9 / 10);
  double weight = 0;
  for (const SurfaceSample& s : doubtful) weight += s.weight;
  CHECK(weight < 0.2);
}

TEST_CASE("uncovered regions: a cut-off tip is found, with its farthest vertex", "[uncovered]") {
  const Vec3 tip = normalized(Vec3{0.3, 0.5, 0.8});
  const auto with_tip = [&](const Vec3& p) {
    const Vec3 n = normalized(p);
    return (1 + 0.5 * std::exp(-60 * squared_norm(n - tip))) * n;
  };
  const Parameterization map = make_parameterization(test::icosahedron(), 5, 0, with_tip);
  const Parameterization sphere = make_parameterization(test::icosahedron(), 5, 0, test::on_unit_sphere);
  const SurfaceIndex index(*sphere.surface);
  const auto regions = uncovered_regions(*map.surface, index, 0.05);
  REQUIRE(regions.size() == 1);
  CHECK(regions[0].farthest_distance == Approx(0.5).margin(0.02));
  CHECK(dot(normalized(map.surface->positions[regions[0].farthest_vertex]), tip) > 0.995);
  CHECK(regions[0].vertices.size() > 10);
  CHECK(regions[0].area > 0);
  CHECK(uncovered_regions(*sphere.surface, index, 1e-9).empty());
}

TEST_CASE("uncovered regions: the worst comes first", "[uncovered]") {
  const Vec3 tips[2] = {normalized(Vec3{0.3, 0.5, 0.8}), normalized(Vec3{-1, 0.2, -0.4})};
  const Parameterization map = make_parameterization(test::icosahedron(), 4, 0, [&](const Vec3& p) {
    const Vec3 n = normalized(p);
    return (1 + 0.2 * std::exp(-60 * squared_norm(n - tips[0])) +
            0.4 * std::exp(-60 * squared_norm(n - tips[1]))) *
           n;
  });
  const Parameterization sphere = make_parameterization(test::icosahedron(), 4, 0, test::on_unit_sphere);
  const auto regions = uncovered_regions(*map.surface, SurfaceIndex(*sphere.surface), 0.05);
  REQUIRE(regions.size() == 2);
  CHECK(regions[0].squared_error > regions[1].squared_error);
  CHECK(dot(normalized(map.surface->positions[regions[0].farthest_vertex]), tips[1]) > 0.98);
}

}  // namespace
}  // namespace nmc
