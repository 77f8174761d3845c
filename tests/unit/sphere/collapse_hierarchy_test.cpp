// SPDX-License-Identifier: Apache-2.0
#include "encoder/sphere/collapse_hierarchy.h"

#include <catch2/catch.hpp>
#include <set>

#include "encoder/core/error.h"
#include "tests/unit/sphere/sphere_test_meshes.h"

using namespace nmc;

namespace {

std::set<Triangle> rotated_to_lowest_first(const std::vector<Triangle>& triangles) {
  std::set<Triangle> result;
  for (Triangle t : triangles) {
    while (t[0] > t[1] || t[0] > t[2]) t = {t[1], t[2], t[0]};
    result.insert(t);
  }
  return result;
}

std::string message_of(const TriangleMesh& mesh) {
  try {
    CollapseHierarchy(mesh.positions, mesh.triangles);
  } catch (const Error& error) {
    CHECK(error.code() == ExitCode::kUnsupported);
    return error.what();
  }
  return "accepted";
}

}  // namespace

TEST_CASE("a sphere collapses to a tetrahedron, and undoing restores the mesh triangle for triangle") {
  const TriangleMesh mesh = nmc_test::spiky_sphere(4, 0.5);
  CollapseHierarchy hierarchy(mesh.positions, mesh.triangles);
  hierarchy.collapse_to(4);
  CHECK(hierarchy.live_count() == 4);
  CHECK(hierarchy.level().triangles.size() == 4);
  while (hierarchy.can_undo()) hierarchy.undo();
  CHECK(rotated_to_lowest_first(hierarchy.level().triangles) == rotated_to_lowest_first(mesh.triangles));
}

TEST_CASE("every level is a closed genus-0 mesh") {
  const TriangleMesh mesh = nmc_test::long_capsule(4, 8);
  CollapseHierarchy hierarchy(mesh.positions, mesh.triangles);
  for (const std::uint32_t count : {800u, 300u, 77u, 12u, 5u, 4u}) {
    hierarchy.collapse_to(count);
    const HierarchyLevel level = hierarchy.level();
    REQUIRE(level.vertices.size() == count);
    std::vector<Vec3> positions;
    for (const std::uint32_t v : level.vertices) positions.push_back(mesh.positions[v]);
    // The constructor checks closedness, orientation, fans, genus and components.
    CHECK_NOTHROW(CollapseHierarchy(positions, level.triangles));
  }
}

TEST_CASE("surfaces that are not a single closed oriented sphere are refused with the reason") {
  TriangleMesh open = nmc_test::geodesic_sphere(1);
  open.triangles.pop_back();
  CHECK(message_of(open).find("boundary") != std::string::npos);

  TriangleMesh turned = nmc_test::geodesic_sphere(1);
  std::swap(turned.triangles[3][0], turned.triangles[3][1]);
  CHECK(message_of(turned).find("oriented") != std::string::npos);

  TriangleMesh two = nmc_test::octahedron();
  const TriangleMesh other = nmc_test::octahedron();
  for (const Vec3& p : other.positions) two.positions.push_back(p + Vec3{5, 0, 0});
  for (const Triangle& t : other.triangles) two.triangles.push_back({t[0] + 6, t[1] + 6, t[2] + 6});
  CHECK(message_of(two).find("Euler") != std::string::npos);

  TriangleMesh unused = nmc_test::octahedron();
  unused.positions.push_back({0, 0, 0});
  CHECK(message_of(unused).find("no triangle") != std::string::npos);
}
