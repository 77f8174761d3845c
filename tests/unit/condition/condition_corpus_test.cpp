// SPDX-License-Identifier: Apache-2.0
// Real meshes with real defects. The counts were compared with corpus/manifest.json, which another program
// made.
#include <catch2/catch.hpp>

#include "encoder/condition/condition.h"
#include "tests/unit/condition/oriented_manifold.h"

using namespace nmc;

namespace {
struct Expectation {
  const char* file;
  bool changes_nothing;  // bit for bit, but for welding and unreferenced vertices
  std::size_t components, closed_components, boundary_loops;
  long genus;
};
}  // namespace

TEST_CASE("condition: finds the known topology of real meshes", "[condition][corpus]") {
  const Expectation expectations[] = {
      {"bimba.off", true, 1, 1, 0, 0},          {"bun_zipper.ply", true, 1, 0, 5, 0},
      {"boot.obj", true, 1, 1, 0, 12},          {"gyroidpuzzle.obj", true, 1, 1, 0, 15},
      {"ADIS16480.stl", true, 1, 1, 0, 24},     {"thingi_99865.stl", true, 4, 4, 0, 4},
      {"Julius.obj", true, 1, 0, 1, 0},         {"chaise.ply", true, 3, 3, 0, 2},
      {"rs1_normals.ply", false, 21, 0, 31, 0}, {"cycloidal.ply", false, 112, 112, 0, 135},
      {"conrod.off", false, 4, 1, 3, 0},        {"ogre.obj", false, 44, 39, 5, 1},
  };
  for (const Expectation& expected : expectations) {
    TriangleMesh mesh;
    if (!test::read_corpus_mesh(expected.file, mesh)) continue;
    CAPTURE(expected.file);
    ConditionOptions options;
    options.small_hole_edges = 0;
    const ConditionedMesh result = condition(mesh, options);
    CHECK(test::manifold_fault(result.mesh) == "");
    CHECK(test::accounting_fault(mesh, result) == "");
    CHECK(test::difference(condition(result.mesh, options).mesh, result.mesh) == "");
    std::size_t closed = 0;
    for (const ConditionedComponent& component : result.report.components) closed += component.is_closed();
    CHECK(result.report.components.size() == expected.components);
    CHECK(closed == expected.closed_components);
    CHECK(result.report.boundary_loops.size() == expected.boundary_loops);
    CHECK(result.report.total_genus() == expected.genus);
    CHECK(result.report.needed_repair() != expected.changes_nothing);
  }
}

TEST_CASE("condition: turns the horse, which is stored inside out", "[condition][corpus]") {
  TriangleMesh mesh;
  if (!test::read_corpus_mesh("horse.ply", mesh)) return;
  const ConditionedMesh result = condition(mesh);
  CHECK(result.report.turned_components == 1);
  CHECK(result.report.count(TriangleFate::kReoriented) == mesh.triangle_count());
  CHECK(result.report.components.at(0).volume > 0);
  CHECK(result.mesh.positions == mesh.positions);
}

TEST_CASE("condition: takes the doubled, crossing parts of motorBike apart", "[condition][corpus]") {
  TriangleMesh mesh;
  if (!test::read_corpus_mesh("motorBike.obj", mesh)) return;
  const ConditionedMesh result = condition(mesh);
  CHECK(test::manifold_fault(result.mesh) == "");
  CHECK(test::accounting_fault(mesh, result) == "");
  CHECK(result.report.count(TriangleFate::kDuplicate) +
            result.report.count(TriangleFate::kOppositeDuplicate) ==
        67326);
  CHECK(result.report.non_manifold_edges == 943);
  CHECK(result.report.cut_edges == 0);
  CHECK(test::difference(condition(result.mesh).mesh, result.mesh) == "");
}

TEST_CASE("condition: survives a scan quantized until an eighth of it was degenerate",
          "[condition][corpus]") {
  TriangleMesh mesh;
  if (!test::read_corpus_mesh("dragon_871k_draco11.ply", mesh)) return;
  const ConditionedMesh result = condition(mesh);
  CHECK(test::manifold_fault(result.mesh) == "");
  CHECK(test::accounting_fault(mesh, result) == "");
  CHECK(result.report.count(TriangleFate::kDegenerate) == 103734);
  CHECK(result.report.count(TriangleFate::kDuplicate) +
            result.report.count(TriangleFate::kOppositeDuplicate) ==
        252);
  CHECK(result.report.slivers_left < 100);
}
