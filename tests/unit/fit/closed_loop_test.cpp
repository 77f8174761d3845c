// SPDX-License-Identifier: Apache-2.0
#include "encoder/fit/closed_loop.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "encoder/domain/parameterize.h"
#include "encoder/fit/round_mesh.h"
#include "tests/unit/fit/bumpy_sphere.h"

namespace nmc {
namespace {

struct Scene {
  BumpySphere sphere;
  Parameterization map = parameterize(fine_mesh(sphere, 5), {20}).front();
  DomainParameterizedSurface surface{map};
  SurfaceIndex index{surface.surface()};
  ParameterizedBase base = base_of(map);

  double rms_distance(const std::vector<Vec3>& positions) const {
    double sum = 0;
    for (const Vec3& p : positions) sum += std::pow(index.closest_point(p).t, 2);
    return std::sqrt(sum / static_cast<double>(positions.size()));
  }
};

ClosedLoopOptions options_with(double step) {
  ClosedLoopOptions options;
  options.interpolating.level_count = 4;
  options.quantize.normal_step = step;
  return options;
}

TEST_CASE("closed loop: what is coded is what was pierced from, to the last bit") {
  const Scene scene;
  ClosedLoopOptions options = options_with(0.01);
  const NormalMesh mesh = quantize_closed_loop(scene.surface, scene.index, scene.base, options);
  const std::vector<Vec3> expected = reconstruct(mesh, 4);
  options.quantize.dead_zone = 0.5;
  const QuantizedMesh integers = round_mesh(mesh, 4, options.quantize);
  const std::vector<Vec3> decoded = reconstruct(integers, mesh.hierarchy, 4);
  REQUIRE(decoded.size() == expected.size());
  double largest = 0;
  for (std::size_t v = 0; v < decoded.size(); ++v)
    largest = std::max(largest, distance(decoded[v], expected[v]));
  CHECK(largest < 1e-12);
  CHECK(integers.nonzero_count() > 50);
}

TEST_CASE("closed loop: a normal vertex of any level lies within the dead zone of the surface") {
  const Scene scene;
  const ClosedLoopOptions options = options_with(0.01);
  const NormalMesh mesh = quantize_closed_loop(scene.surface, scene.index, scene.base, options);
  const std::vector<Vec3> positions = reconstruct(mesh, 4);
  const ScalarQuantizer quantizer(options.quantize, 4);
  for (int l = 0; l < 4; ++l) {
    const LevelTopology& topology = mesh.hierarchy.level(l);
    double largest = 0;
    for (std::size_t e = 0; e < topology.edge_count; ++e) {
      if (mesh.non_normal[static_cast<std::size_t>(l)][e]) continue;
      largest = std::max(largest, scene.index.closest_point(positions[topology.vertex_count + e]).t);
    }
    INFO("level " << l << ", step " << quantizer.normal_step(l));
    CHECK(largest <= options.quantize.dead_zone * quantizer.normal_step(l));
  }
}

TEST_CASE("closed loop: nearer to the surface than the same coefficients rounded in one go") {
  const Scene scene;
  for (const double step : {0.02, 0.005}) {
    const ClosedLoopOptions options = options_with(step);
    const NormalMesh closed = quantize_closed_loop(scene.surface, scene.index, scene.base, options);
    const InterpolatingResult open =
        interpolate(scene.surface, scene.index, scene.base, options.interpolating);
    const QuantizedMesh rounded = round_mesh(open.mesh, 4, options.quantize);
    const double closed_rms = scene.rms_distance(reconstruct(closed, 4));
    const double open_rms = scene.rms_distance(reconstruct(rounded, open.mesh.hierarchy, 4));
    INFO("step " << step << ": closed loop " << closed_rms << ", open loop " << open_rms);
    CHECK(closed_rms < 0.97 * open_rms);
  }
}

TEST_CASE(
    "rounding: nothing below the dead zone, no coefficient farther than its larger side from its integer") {
  QuantizeOptions options;
  options.normal_step = 0.1;
  options.dead_zone = 0.62;
  const ScalarQuantizer quantizer(options, 3);
  CHECK(quantizer.normal_step(2) == 0.1);
  CHECK(quantizer.normal_step(1) == Approx(0.1 / 1.8));
  CHECK(quantizer.normal(0.0619, 2) == 0);
  CHECK(quantizer.normal(0.0621, 2) == 1);
  CHECK(quantizer.normal(-0.0621, 2) == -1);
  CHECK(quantizer.normal(-0.3, 2) == -3);
  CHECK(quantizer.normal(0.1549, 2) == 1);
  CHECK(quantizer.normal(0.1551, 2) == 2);
  std::int32_t along = 7, across = 7;
  quantizer.tangential(0.1, 0.15, 2, along, across);  // a step is 0.35
  CHECK((along == 0 && across == 0));
  quantizer.tangential(0.4, -0.2, 2, along, across);
  CHECK((along == 1 && across == -1));
}

}  // namespace
}  // namespace nmc
