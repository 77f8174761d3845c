// SPDX-License-Identifier: Apache-2.0
#include <oneapi/tbb/global_control.h>

#include <catch2/catch.hpp>
#include <numeric>

#include "corpus/generate/shapes.h"
#include "encoder/condition/condition.h"
#include "tests/unit/condition/oriented_manifold.h"

using namespace nmc;

namespace {
/// Through memory: g++ 12 at -O2 drops the rounding where it vectorizes float casts that end in doubles
/// again.
double rounded_to_float(double x) {
  volatile float rounded = static_cast<float>(x);
  return rounded;
}
}  // namespace

TEST_CASE("condition: returns a clean mesh bit for bit", "[condition]") {
  const std::vector<TriangleMesh> meshes = {
      corpus::icosphere(4),
      corpus::torus(60, 20),
      corpus::gear(),
      corpus::koch_surface(4),
      corpus::disk_with_holes(100),
      corpus::terrain(50),
      corpus::gyroid(24),
      corpus::comb(),
      corpus::thin_sheets(3, 20),
      corpus::perforated_plate(4, 3),
      corpus::torus_knot(2, 3, 300, 12),
  };
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    CAPTURE(i);
    for (const Repair repair : {Repair::kAuto, Repair::kNothing, Repair::kStrict}) {
      ConditionOptions options;
      options.repair = repair;
      options.small_hole_edges = 0;
      const ConditionedMesh result = condition(meshes[i], options);
      CHECK(test::difference(result.mesh, meshes[i]) == "");
      CHECK_FALSE(result.report.needed_repair());
      CHECK(test::accounting_fault(meshes[i], result) == "");
      std::vector<std::uint32_t> identity(meshes[i].vertex_count());
      std::iota(identity.begin(), identity.end(), 0u);
      CHECK(result.source_vertex == identity);
      CHECK(result.stitched_vertex == identity);
    }
  }
}

TEST_CASE("condition: gives the same result with one thread and with many", "[condition]") {
  TriangleMesh mesh =
      corpus::voxel_surface(16, 16, 16, [](int x, int y, int z) { return (x * y + z) % 3 == 0; });
  corpus::append(mesh, corpus::loose_triangles(3000));
  const auto with_threads = [&](std::size_t count) {
    const oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism, count);
    return condition(mesh);
  };
  const ConditionedMesh one = with_threads(1), many = with_threads(8);
  CHECK(test::difference(one.mesh, many.mesh) == "");
  CHECK(to_json(one.report) == to_json(many.report));
}

TEST_CASE("condition: carries colours and attributes along with their vertices", "[condition]") {
  TriangleMesh mesh = corpus::icosphere(2);
  mesh.positions.insert(mesh.positions.begin() + 5, Vec3{9, 9, 9});  // unreferenced
  for (Triangle& t : mesh.triangles)
    for (std::uint32_t& v : t) v += v >= 5;
  VertexAttribute pairs{"pair", 2, {}};
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    mesh.colors.push_back({static_cast<std::uint8_t>(v), 7, static_cast<std::uint8_t>(255 - v)});
    pairs.values.push_back(static_cast<float>(v));
    pairs.values.push_back(-static_cast<float>(v));
  }
  mesh.attributes.push_back(pairs);
  mesh.dropped_properties.push_back("u: texture coordinates");
  const ConditionedMesh result = condition(mesh);
  REQUIRE(result.mesh.vertex_count() == mesh.vertex_count() - 1);
  REQUIRE(result.mesh.attributes.size() == 1);
  CHECK(result.mesh.attributes[0].name == "pair");
  CHECK(result.mesh.dropped_properties == mesh.dropped_properties);
  CHECK(result.report.unreferenced_vertices == 1);
  for (std::size_t v = 0; v < result.mesh.vertex_count(); ++v) {
    const std::uint32_t source = result.source_vertex[v];
    CHECK(result.mesh.colors[v] == mesh.colors[source]);
    CHECK(result.mesh.attributes[0].values[2 * v] == static_cast<float>(source));
    CHECK(result.mesh.attributes[0].values[2 * v + 1] == -static_cast<float>(source));
  }
}

TEST_CASE("condition: keeps millimetres at ten million units from the origin", "[condition]") {
  TriangleMesh mesh = corpus::noisy_sphere(4);
  corpus::translate(mesh, {1.0e7, -5.5e6, 432.1});
  const ConditionedMesh result = condition(mesh);
  CHECK(test::difference(result.mesh, mesh) == "");
  CHECK(result.report.components.at(0).area == Approx(surface_area(corpus::noisy_sphere(4))).epsilon(1e-6));
  CHECK(result.report.components.at(0).volume == Approx(4.18).epsilon(0.02));
}

TEST_CASE("condition: turns triangle soup back into the surface it was cut from", "[condition]") {
  const TriangleMesh sphere = corpus::icosphere(3);
  TriangleMesh soup;
  for (const Triangle& t : sphere.triangles) {
    const auto first = static_cast<std::uint32_t>(soup.vertex_count());
    for (const std::uint32_t v : t) soup.positions.push_back(sphere.positions[v]);
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  const ConditionedMesh result = condition(soup);
  CHECK(test::manifold_fault(result.mesh) == "");
  CHECK(result.mesh.vertex_count() == sphere.vertex_count());
  CHECK(result.mesh.triangle_count() == sphere.triangle_count());
  CHECK(result.report.components.size() == 1);
  CHECK(result.report.boundary_loops.empty());
  CHECK(result.report.welded_exactly == soup.vertex_count() - sphere.vertex_count());

  SECTION("also when every corner was rounded differently") {
    TriangleMesh rounded = soup;
    for (std::size_t v = 0; v < rounded.vertex_count(); ++v)
      rounded.positions[v].x += (static_cast<double>(v % 7) - 3) * 1e-9;
    const ConditionedMesh welded = condition(rounded);
    CHECK(test::manifold_fault(welded.mesh) == "");
    CHECK(test::accounting_fault(rounded, welded) == "");
    CHECK(welded.mesh.vertex_count() == sphere.vertex_count());
    CHECK(welded.report.boundary_loops.empty());
    CHECK(welded.report.welded_nearby > 0);
  }
  SECTION("also when 32-bit floats far from the origin rounded it") {
    TriangleMesh rounded = soup;
    corpus::translate(rounded, {2e4, 2e4, 0});
    for (std::size_t v = 0; v < rounded.vertex_count(); ++v)
      for (int k = 0; k < 3; ++k)
        rounded.positions[v][k] = rounded_to_float(rounded.positions[v][k] + (v % 3 == 0 ? 1e-3 : 0));
    const ConditionedMesh welded = condition(rounded);
    CHECK(test::manifold_fault(welded.mesh) == "");
    INFO(to_text(welded.report) << welded.report.weld_distance);
    CHECK(welded.report.boundary_loops.empty());
  }
}
