// SPDX-License-Identifier: Apache-2.0
// Collapses to base meshes.
#include "encoder/domain/maps_collapse.h"

#include <catch2/catch.hpp>

#include <algorithm>

#include "corpus/generate/shapes.h"

namespace nmc {
namespace {

TEST_CASE("Large bases on the way do not bend the collapses to a small one") {
  // 10,080 vertices: the small base's own conditions hold from 3,000 down at most, whatever else is asked for.
  const TriangleMesh mesh = corpus::comb();
  const CollapseHistory alone = maps_collapse(mesh, {100});
  const CollapseHistory nested = maps_collapse(mesh, {100, 1500, 2600, 4000, 6000, 9000});
  const std::size_t steps_to_3000 = mesh.vertex_count() - 3000;
  REQUIRE(alone.steps.size() > steps_to_3000);
  REQUIRE(nested.steps.size() > steps_to_3000);
  const auto different = std::mismatch(alone.steps.begin(), alone.steps.begin() + steps_to_3000, nested.steps.begin());
  CHECK(static_cast<std::size_t>(different.first - alone.steps.begin()) == steps_to_3000);
}

TEST_CASE("Nested bases are reached in one run, each with the vertices asked for") {
  const TriangleMesh mesh = corpus::noisy_sphere(4, 0.01);
  const CollapseHistory history = maps_collapse(mesh, {40, 600, 150});
  REQUIRE(history.base_step_counts.size() == 3);
  CHECK(mesh.vertex_count() - history.base_step_counts[0] == 40);
  CHECK(mesh.vertex_count() - history.base_step_counts[1] == 600);
  CHECK(mesh.vertex_count() - history.base_step_counts[2] == 150);
}

}  // namespace
}  // namespace nmc
