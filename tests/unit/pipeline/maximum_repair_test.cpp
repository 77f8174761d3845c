// SPDX-License-Identifier: Apache-2.0
#include "encoder/pipeline/maximum_repair.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "encoder/core/triangle_mesh.h"
#include "encoder/fit/round_mesh.h"
#include "encoder/measure/compare_meshes.h"
#include "tests/unit/fit/bumpy_sphere.h"

namespace nmc {
namespace {

/// A bumpy sphere as integers of four levels, and the surface that they stand for: an input that they meet exactly.
struct Scene {
  Scene() : hierarchy(octahedron_faces(), 6, kLevels) {
    QuantizeOptions options;
    options.normal_step = 2e-3;
    mesh = round_mesh(interpolating_mesh(BumpySphere{}, kLevels), kLevels, options);
    input.positions = reconstruct(mesh, hierarchy, kLevels);
    input.triangles = level_triangles(hierarchy.level(kLevels));
    index = std::make_unique<SurfaceIndex>(input);
  }

  double largest_error() const {
    TriangleMesh result;
    result.positions = reconstruct(mesh, hierarchy, kLevels);
    result.triangles = input.triangles;
    return compare_meshes(input, result, {}).maximum;
  }

  MaximumRepairResult repair(double tolerance) {
    MaximumRepairOptions options;
    options.tolerance = tolerance;
    options.maximum_rounds = 24;
    options.starts_again = true;
    options.input_sample_count = options.mesh_sample_count = usual_sample_count(input.triangle_count());
    return repair_maximum(*index, hierarchy, options, mesh);
  }

  static constexpr int kLevels = 4;
  SubdivisionHierarchy hierarchy;
  QuantizedMesh mesh;
  TriangleMesh input;
  std::unique_ptr<SurfaceIndex> index;
};

constexpr double kTolerance = 5e-3;

TEST_CASE("maximum repair: a mesh within the tolerance keeps its integers", "[repair]") {
  Scene scene;
  const QuantizedMesh before = scene.mesh;
  const MaximumRepairResult result = scene.repair(kTolerance);
  CHECK(result.initial_beyond == 0);
  CHECK(scene.mesh.normal == before.normal);
  CHECK(scene.mesh.base_coordinates == before.base_coordinates);
}

TEST_CASE("maximum repair: spikes of the finest level are taken back", "[repair]") {
  Scene scene;
  auto& finest = scene.mesh.normal.back();
  for (const std::size_t edge : {10u, 11u, 12u, 200u, 333u}) finest[edge] += edge % 2 == 0 ? 7 : -9;
  REQUIRE(scene.largest_error() > kTolerance);
  const MaximumRepairResult result = scene.repair(kTolerance);
  CHECK(result.initial_beyond > 0);
  CHECK(result.final_beyond == 0);
  CHECK(scene.largest_error() <= kTolerance);
}

TEST_CASE("maximum repair: vertices of every coarser level are brought back", "[repair]") {
  // A little beyond the tolerance, as such a vertex carries a part of the whole surface with it.
  const int level = GENERATE(-1, 0, 1, 2);
  Scene scene;
  if (level < 0) {
    scene.mesh.base_coordinates[1][0] +=
        static_cast<std::int32_t>(std::lround(0.0052 / scene.mesh.base_step));
  } else {
    const auto l = static_cast<std::size_t>(level);
    scene.mesh.normal[l][5] += static_cast<std::int32_t>(std::lround(0.0053 / scene.mesh.quantizers[l].normal_step));
  }
  INFO("level " << level);
  REQUIRE(scene.largest_error() > kTolerance);
  CHECK(scene.repair(kTolerance).final_beyond == 0);
  CHECK(scene.largest_error() <= kTolerance);
}

TEST_CASE("maximum repair: what is hopeless is left no worse", "[repair]") {
  Scene scene;
  auto& finest = scene.mesh.normal.back();
  for (std::size_t edge = 0; edge < finest.size(); edge += 2) finest[edge] += edge % 4 == 0 ? 9 : -9;
  const QuantizedMesh before = scene.mesh;
  const MaximumRepairResult result = scene.repair(kTolerance);
  CHECK(result.final_beyond <= result.initial_beyond);
  if (result.final_beyond == result.initial_beyond) CHECK(scene.mesh.normal == before.normal);
}

}  // namespace
}  // namespace nmc
