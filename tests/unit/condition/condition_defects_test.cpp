// SPDX-License-Identifier: Apache-2.0
// One defect at a time, and exactly what becomes of it.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "corpus/generate/shapes.h"
#include "encoder/condition/condition.h"
#include "encoder/core/error.h"
#include "tests/unit/condition/oriented_manifold.h"

using namespace nmc;
using Catch::Matchers::Contains;

namespace {

/// Conditions the mesh and checks what holds for every result.
ConditionedMesh conditioned(const TriangleMesh& mesh, const ConditionOptions& options = {}) {
  ConditionedMesh result = condition(mesh, options);
  CHECK(test::manifold_fault(result.mesh) == "");
  CHECK(test::accounting_fault(mesh, result) == "");
  CHECK(test::difference(condition(result.mesh, options).mesh, result.mesh) == "");
  return result;
}

TriangleMesh tetrahedron() {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

TriangleMesh box(double half) {
  TriangleMesh mesh = corpus::voxel_surface(2, 2, 2, [](int, int, int) { return true; }, {half, half, half});
  corpus::translate(mesh, {-half, -half, -half});
  return mesh;
}

/// `page_count` rectangles of two triangles around the z axis.
TriangleMesh book(int page_count) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {0, 0, 1}};
  for (int i = 0; i < page_count; ++i) {
    const double angle = 2 * std::numbers::pi * i / page_count;
    const auto outer = static_cast<std::uint32_t>(mesh.vertex_count());
    mesh.positions.push_back({std::cos(angle), std::sin(angle), 0});
    mesh.positions.push_back({std::cos(angle), std::sin(angle), 1});
    mesh.triangles.push_back({0, outer, outer + 1});
    mesh.triangles.push_back({0, outer + 1, 1});
  }
  return mesh;
}

std::string refusal(const TriangleMesh& mesh, const ConditionOptions& options = {}) {
  try {
    condition(mesh, options);
  } catch (const Error& error) {
    CHECK(error.code() == ExitCode::kInvalidInput);
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("condition: separates two tetrahedra that share a vertex", "[condition]") {
  TriangleMesh mesh = tetrahedron();
  mesh.positions.insert(mesh.positions.end(), {{-1, 0, 0}, {0, -1, 0}, {0, 0, -1}});
  mesh.triangles.insert(mesh.triangles.end(), {{0, 4, 5}, {0, 6, 4}, {0, 5, 6}, {4, 6, 5}});
  const ConditionedMesh result = conditioned(mesh);
  CHECK(result.report.components.size() == 2);
  CHECK(result.report.non_manifold_vertices == 1);
  CHECK(result.report.split_vertices == 1);
  CHECK(result.mesh.vertex_count() == 8);
  CHECK(result.source_vertex[7] == 0);
  CHECK(result.stitched_vertex[7] == 0);
}

TEST_CASE("condition: separates two solids that share an edge, whatever joins them", "[condition]") {
  // Two cells on a diagonal: their four faces at the common edge are pairwise coplanar.
  const TriangleMesh mesh = corpus::voxel_surface(2, 2, 1, [](int x, int y, int) { return x == y; });
  const ConditionedMesh result = conditioned(mesh);
  CHECK(result.report.non_manifold_edges == 1);
  CHECK(result.report.non_manifold_edges_open == 0);
  REQUIRE(result.report.components.size() == 2);
  for (const ConditionedComponent& component : result.report.components) {
    CHECK(component.is_closed());
    CHECK(component.triangle_count == 12);
    CHECK(component.volume == Approx(1));
  }
}

TEST_CASE("condition: keeps solids that touch in a face apart when the file does", "[condition]") {
  TriangleMesh mesh = box(0.5);
  TriangleMesh other = box(0.5);
  corpus::translate(other, {1, 0, 0});
  corpus::append(mesh, other);
  const ConditionedMesh result = conditioned(mesh);
  CHECK(test::difference(result.mesh, mesh) == "");
  CHECK(result.report.components.size() == 2);
  // The nine points of the common face, and nothing else, are stitched.
  std::size_t stitched = 0;
  for (std::size_t v = 0; v < result.mesh.vertex_count(); ++v) stitched += result.stitched_vertex[v] != v;
  CHECK(stitched == 9);
}

TEST_CASE("condition: drops the second of two equal closed surfaces", "[condition]") {
  TriangleMesh mesh = corpus::icosphere(2);
  corpus::append(mesh, corpus::icosphere(2));
  const ConditionedMesh result = conditioned(mesh);
  CHECK(test::difference(result.mesh, corpus::icosphere(2)) == "");
  CHECK(result.report.count(TriangleFate::kDuplicate) == corpus::icosphere(2).triangle_count());
}

TEST_CASE("condition: keeps one side of a sheet stored front and back", "[condition]") {
  TriangleMesh mesh = corpus::terrain(6);
  TriangleMesh back = mesh;
  corpus::turn_around(back);
  corpus::append(mesh, back);
  const ConditionedMesh result = conditioned(mesh);
  CHECK(test::difference(result.mesh, corpus::terrain(6)) == "");
  CHECK(result.report.count(TriangleFate::kOppositeDuplicate) == back.triangle_count());
}

TEST_CASE("condition: pairs the pages of a book and leaves an odd one open", "[condition]") {
  for (const int pages : {3, 4, 5, 6, 7}) {
    CAPTURE(pages);
    const ConditionedMesh result = conditioned(book(pages));
    CHECK(result.report.non_manifold_edges == 1);
    CHECK(result.report.non_manifold_edges_open == static_cast<std::size_t>(pages % 2));
    CHECK(result.report.components.size() == static_cast<std::size_t>((pages + 1) / 2));
    CHECK(result.mesh.triangle_count() == book(pages).triangle_count());
  }
}

TEST_CASE("condition: lets crossing sheets pass through each other", "[condition]") {
  const ConditionedMesh result = conditioned(book(4));
  REQUIRE(result.report.components.size() == 2);
  for (const ConditionedComponent& sheet : result.report.components) {
    const Vec3 size = sheet.box.maximum - sheet.box.minimum;
    CHECK(std::min(size.x, size.y) == Approx(0).margin(1e-12));
    CHECK(std::max(size.x, size.y) == Approx(2));
  }
}

TEST_CASE("condition: opens a Moebius strip along one line across it", "[condition]") {
  const ConditionedMesh result = conditioned(corpus::moebius_strip(40, 4));
  CHECK(result.report.cut_edges == 4);
  CHECK(result.report.non_orientable_components == 1);
  REQUIRE(result.report.components.size() == 1);
  CHECK(result.report.components[0].genus == 0);
  CHECK(result.report.components[0].boundary_loop_count == 1);
  CHECK(result.mesh.triangle_count() == corpus::moebius_strip(40, 4).triangle_count());
}

TEST_CASE("condition: opens a Klein bottle into a tube", "[condition]") {
  const ConditionedMesh result = conditioned(corpus::klein_bottle(30, 16));
  CHECK(result.report.cut_edges == 16);
  REQUIRE(result.report.components.size() == 1);
  CHECK(result.report.components[0].genus == 0);
  CHECK(result.report.components[0].boundary_loop_count == 2);
}

TEST_CASE("condition: orients triangles turned at random, with the majority of the area", "[condition]") {
  TriangleMesh mesh = corpus::torus(30, 12);
  for (std::size_t t = 0; t < mesh.triangle_count(); t += 3)
    std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
  const ConditionedMesh result = conditioned(mesh);
  CHECK(result.report.count(TriangleFate::kReoriented) == (mesh.triangle_count() + 2) / 3);
  CHECK(result.report.cut_edges == 0);
  CHECK(result.report.turned_components == 0);
  CHECK(result.report.components.at(0).volume > 0);
}

TEST_CASE("condition: turns a closed surface that is inside out, but not an open one", "[condition]") {
  TriangleMesh sphere = corpus::icosphere(2);
  corpus::turn_around(sphere);
  const ConditionedMesh result = conditioned(sphere);
  CHECK(result.report.turned_components == 1);
  CHECK(result.report.components.at(0).turned_inside_out);
  CHECK(result.report.components.at(0).volume > 0);
  CHECK(result.report.count(TriangleFate::kReoriented) == sphere.triangle_count());

  TriangleMesh sheet = corpus::terrain(5);
  corpus::turn_around(sheet);
  CHECK(test::difference(conditioned(sheet).mesh, sheet) == "");
}

TEST_CASE("condition: keeps the inner wall of a cavity looking into the cavity", "[condition]") {
  TriangleMesh wall = box(0.5);
  corpus::turn_around(wall);
  TriangleMesh hollow = box(1);
  corpus::append(hollow, wall);

  const ConditionedMesh kept = conditioned(hollow);
  CHECK(test::difference(kept.mesh, hollow) == "");

  // All inside out: both are turned, so the wall looks into the cavity again.
  TriangleMesh inside_out = hollow;
  corpus::turn_around(inside_out);
  const ConditionedMesh turned = conditioned(inside_out);
  CHECK(turned.report.turned_components == 2);
  CHECK(turned.report.components.at(0).volume == Approx(8));
  CHECK(turned.report.components.at(1).volume == Approx(-1));

  // A solid part in a housing: both look outward, and stay so.
  TriangleMesh part_in_housing = box(1);
  corpus::append(part_in_housing, box(0.5));
  CHECK(test::difference(conditioned(part_in_housing).mesh, part_in_housing) == "");

  // An inside-out solid beside the box is nobody's cavity.
  TriangleMesh beside = box(1);
  corpus::translate(wall, {5, 0, 0});
  corpus::append(beside, wall);
  CHECK(conditioned(beside).report.components.at(1).volume == Approx(1));
}

TEST_CASE("condition: closes T-junctions where that joins the surface", "[condition]") {
  // A square of two triangles above; below, the same edge in three parts.
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {3, 0, 0}, {3, 1, 0}, {0, 1, 0}, {1, 0, 0}, {2, 0, 0}, {0, -1, 0}, {3, -1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {6, 4, 0}, {6, 5, 4}, {6, 7, 5}, {7, 1, 5}};
  ConditionOptions options;
  const ConditionedMesh closed = conditioned(mesh, options);
  CHECK(closed.report.t_junctions_closed == 2);
  CHECK(closed.report.components.size() == 1);
  CHECK(closed.report.boundary_loops.size() == 1);
  CHECK(closed.mesh.triangle_count() == mesh.triangle_count() + 2);
  CHECK(closed.report.count(TriangleFate::kSplit) == 1);
  options.close_t_junctions = false;
  CHECK(conditioned(mesh, options).report.components.size() == 2);
}

TEST_CASE("condition: leaves a vertex that merely touches an edge alone", "[condition]") {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {2, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0.5, -1, 0}, {1.5, -1, 0}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  CHECK(test::difference(conditioned(mesh).mesh, mesh) == "");
}

TEST_CASE("condition: closes up needles and flips caps without opening a hole", "[condition]") {
  // A cap: a vertex on the edge (0, 1) of a tetrahedron, closed with a triangle without area.
  TriangleMesh cap = tetrahedron();
  cap.positions.push_back({0.5, 0, 0});
  cap.triangles = {{0, 2, 4}, {4, 2, 1}, {0, 4, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  const ConditionedMesh flipped = conditioned(cap);
  CHECK(flipped.report.caps_flipped == 1);
  CHECK(flipped.report.slivers_left == 0);
  CHECK(flipped.report.components.at(0).is_closed());
  CHECK(flipped.report.components.at(0).volume == Approx(1.0 / 6));

  // Needles: an edge of a sphere split beside one of its ends; both triangles at the short edge are needles.
  TriangleMesh needle = corpus::icosphere(2);
  const Triangle t = needle.triangles[7];
  const auto tip = static_cast<std::uint32_t>(needle.vertex_count());
  needle.positions.push_back(needle.positions[t[0]] +
                             1e-13 * (needle.positions[t[1]] - needle.positions[t[0]]));
  const std::size_t before = needle.triangle_count();
  for (std::size_t i = 0; i < before; ++i)
    for (int k = 0; k < 3; ++k) {
      const Triangle c = needle.triangles[i];
      if ((c[k] != t[0] || c[(k + 1) % 3] != t[1]) && (c[k] != t[1] || c[(k + 1) % 3] != t[0])) continue;
      needle.triangles[i][(k + 1) % 3] = tip;
      needle.triangles.push_back({tip, c[(k + 1) % 3], c[(k + 2) % 3]});
      break;
    }
  const ConditionedMesh collapsed = conditioned(needle);
  CHECK(collapsed.report.needles_collapsed == 1);
  CHECK(collapsed.report.count(TriangleFate::kSliver) == 2);
  CHECK(collapsed.mesh.triangle_count() == before);
  CHECK(collapsed.report.components.at(0).is_closed());
}

TEST_CASE("condition: fills small holes only, and only when asked", "[condition]") {
  // Triangles of one block of 4^k are the parts of one coarser triangle.
  TriangleMesh mesh = corpus::icosphere(5);
  const auto erase = [&](std::ptrdiff_t first, std::ptrdiff_t count) {
    mesh.triangles.erase(mesh.triangles.begin() + first, mesh.triangles.begin() + first + count);
  };
  erase(12800, 256);  // 48 edges
  erase(8000, 4);     // 6 edges
  erase(100, 1);
  ConditionOptions options;
  options.small_hole_length_fraction = 0.1;
  const ConditionedMesh filled = conditioned(mesh, options);
  CHECK(filled.report.filled_holes == 2);
  CHECK(filled.report.filled_hole_triangles == 5);
  CHECK(filled.report.boundary_loops.size() == 1);
  CHECK(std::count(filled.source_triangle.begin(), filled.source_triangle.end(), kFilledHole) == 5);
  CHECK(filled.report.components.at(0).boundary_loop_count == 1);
  options.small_hole_edges = 0;
  CHECK(conditioned(mesh, options).report.boundary_loops.size() == 3);
}

TEST_CASE("condition: does not close a lone triangle or a small sheet", "[condition]") {
  TriangleMesh mesh = corpus::icosphere(5);
  TriangleMesh small = corpus::terrain(2);
  for (Vec3& p : small.positions) p = 1e-3 * p + Vec3{2, 0, 0};
  corpus::append(mesh, small);
  TriangleMesh lone;
  lone.positions = {{3, 0, 0}, {3.001, 0, 0}, {3, 0.001, 0}};
  lone.triangles = {{0, 1, 2}};
  corpus::append(mesh, lone);
  CHECK(test::difference(conditioned(mesh).mesh, mesh) == "");
}

TEST_CASE("condition: drops dust only when asked, and never everything", "[condition]") {
  TriangleMesh mesh = corpus::icosphere(3);
  TriangleMesh speck = tetrahedron();
  for (Vec3& p : speck.positions) p = 1e-4 * p + Vec3{2, 0, 0};
  corpus::append(mesh, speck);
  CHECK(conditioned(mesh).report.components.size() == 2);
  ConditionOptions options;
  options.drop_dust = true;
  const ConditionedMesh clean = conditioned(mesh, options);
  CHECK(clean.report.dust_components == 1);
  CHECK(clean.report.count(TriangleFate::kDust) == 4);
  CHECK(test::difference(clean.mesh, corpus::icosphere(3)) == "");
  const TriangleMesh cloud = corpus::loose_triangles(2000);
  CHECK(conditioned(cloud, options).mesh.triangle_count() == cloud.triangle_count());
}

TEST_CASE("condition: accepts a single triangle and a plane", "[condition]") {
  TriangleMesh triangle;
  triangle.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  triangle.triangles = {{0, 1, 2}};
  CHECK(test::difference(conditioned(triangle).mesh, triangle) == "");
  TriangleMesh plane = corpus::terrain(9);
  for (Vec3& p : plane.positions) p.z = 3;
  CHECK(test::difference(conditioned(plane).mesh, plane) == "");
}

TEST_CASE("condition: says what is wrong where nothing is left", "[condition]") {
  CHECK_THAT(refusal({}), Contains("no vertices and no triangles"));
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}};
  CHECK_THAT(refusal(mesh), Contains("3 vertices but no triangles"));
  mesh.triangles = {{0, 1, 2}};
  CHECK_THAT(refusal(mesh), Contains("on a line"));
  mesh.triangles = {{0, 1, 9}};
  CHECK_THAT(refusal(mesh), Contains("vertex that does not exist"));
  mesh.triangles = {{0, 0, 1}};
  CHECK_THAT(refusal(mesh), Contains("two corners at the same point"));
  for (Vec3& p : mesh.positions) p = {1, 1, 1};
  mesh.triangles = {{0, 1, 2}};
  CHECK_THAT(refusal(mesh), Contains("all points are the same"));
  for (Vec3& p : mesh.positions) p.x = std::numeric_limits<double>::quiet_NaN();
  CHECK_THAT(refusal(mesh), Contains("not finite"));
  mesh.positions = {{0, 0, 0}, {1e300, 0, 0}, {0, 1, 0}};
  CHECK_THAT(refusal(mesh), Contains("beyond"));
}

TEST_CASE("condition: with repair none refuses what is no oriented manifold, and says where", "[condition]") {
  ConditionOptions none;
  none.repair = Repair::kNothing;
  CHECK_THAT(refusal(book(3), none), Contains("edge between vertices 0 and 1 has 3 triangles"));
  TriangleMesh turned = corpus::icosphere(1);
  std::swap(turned.triangles[11][0], turned.triangles[11][1]);
  CHECK_THAT(refusal(turned, none), Contains("not oriented") && Contains("11"));
  TriangleMesh touching = tetrahedron();
  touching.positions.insert(touching.positions.end(), {{-1, 0, 0}, {0, -1, 0}});
  touching.triangles.push_back({0, 4, 5});
  CHECK_THAT(refusal(touching, none), Contains("vertex 0 joins several sheets"));
  TriangleMesh doubled;
  doubled.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  doubled.triangles = {{0, 1, 2}, {0, 2, 1}};
  CHECK_THAT(refusal(doubled, none), Contains("triangles 0 and 1 have the same corners"));

  // Left out without a word of refusal: what no mesh can hold.
  TriangleMesh litter = corpus::icosphere(1);
  litter.positions.push_back({9, 9, 9});
  litter.triangles.push_back({3, 3, 4});
  litter.triangles.push_back({3, 4, 999});
  CHECK(test::difference(condition(litter, none).mesh, corpus::icosphere(1)) == "");
}

TEST_CASE("condition: with repair strict refuses any repair and names them all", "[condition]") {
  ConditionOptions strict;
  strict.repair = Repair::kStrict;
  TriangleMesh mesh = corpus::icosphere(2);
  mesh.positions.push_back({9, 9, 9});  // unreferenced: no repair
  CHECK(refusal(mesh, strict) == "");
  mesh.triangles.push_back(mesh.triangles[5]);
  std::swap(mesh.triangles[40][0], mesh.triangles[40][1]);
  CHECK_THAT(refusal(mesh, strict), Contains("triangle 320 has the corners of an earlier triangle") &&
                                        Contains("triangle 40 is oriented against its neighbours"));
  TriangleMesh inside_out = corpus::icosphere(1);
  corpus::turn_around(inside_out);
  CHECK_THAT(refusal(inside_out, strict), Contains("inside out"));
}
