// SPDX-License-Identifier: Apache-2.0
#include "encoder/normal_mesh/semi_regular_input.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "encoder/normal_mesh/surface_atlas.h"
#include "tests/unit/normal_mesh/synthetic_surfaces.h"

namespace nmc {
namespace {

/// The base subdivided `depth` times, with vertices and triangles in random order and corners rotated.
TriangleMesh scrambled(const test::BaseShape& base, int depth) {
  const SubdivisionHierarchy hierarchy(base.faces, static_cast<std::uint32_t>(base.positions.size()), depth);
  std::vector<Vec3> positions = base.positions;
  for (int l = 0; l < depth; ++l) {
    const LevelTopology& level = hierarchy.level(l);
    for (std::uint32_t e = 0; e < level.edge_count; ++e)
      positions.push_back(
          0.5 * (positions[level.edge_vertices[2 * e]] + positions[level.edge_vertices[2 * e + 1]]));
  }
  test::Random random(5);
  std::vector<std::uint32_t> order(positions.size());
  for (std::uint32_t v = 0; v < order.size(); ++v) order[v] = v;
  for (std::uint32_t v = 1; v < order.size(); ++v) std::swap(order[v], order[random.below(v + 1)]);
  TriangleMesh mesh;
  mesh.positions.resize(positions.size());
  for (std::uint32_t v = 0; v < order.size(); ++v) mesh.positions[order[v]] = positions[v];
  mesh.triangles = level_triangles(hierarchy.level(depth));
  for (std::uint32_t t = 1; t < mesh.triangles.size(); ++t)
    std::swap(mesh.triangles[t], mesh.triangles[random.below(t + 1)]);
  for (Triangle& t : mesh.triangles) {
    for (std::uint32_t& v : t) v = order[v];
    std::rotate(t.begin(), t.begin() + random.below(3), t.end());
  }
  return mesh;
}

/// Triangles as sets of positions, so that numbering does not matter.
std::multiset<std::vector<std::array<double, 3>>> shape_of(const TriangleMesh& mesh) {
  std::multiset<std::vector<std::array<double, 3>>> shape;
  for (const Triangle& t : mesh.triangles) {
    std::vector<std::array<double, 3>> corners;
    for (const std::uint32_t v : t)
      corners.push_back({mesh.positions[v].x, mesh.positions[v].y, mesh.positions[v].z});
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    shape.insert(corners);
  }
  return shape;
}

TEST_CASE("semi-regular input: base mesh and levels are found from the triangles alone", "[semi_regular]") {
  struct Case {
    const char* name;
    test::BaseShape base;
    int depth;
  };
  test::BaseShape two = test::icosahedron();  // two components
  const test::BaseShape other = test::octahedron();
  for (const Triangle& t : other.faces) two.faces.push_back({t[0] + 12, t[1] + 12, t[2] + 12});
  for (const Vec3& p : other.positions) two.positions.push_back(p + Vec3{10, 0, 0});
  for (const Case& c :
       {Case{"tetrahedron", test::tetrahedron(), 4}, Case{"octahedron", test::octahedron(), 3},
        Case{"icosahedron", test::icosahedron(), 1}, Case{"two components", two, 2}}) {
    INFO(c.name);
    const TriangleMesh mesh = scrambled(c.base, c.depth);
    const auto input = recognize_subdivision_connectivity(mesh);
    REQUIRE(input);
    CHECK(input->hierarchy.level_count() == c.depth);
    CHECK(input->base_faces.size() == c.base.faces.size());
    const Parameterization map = identity_parameterization(*input, mesh);
    CHECK(shape_of(*map.surface) == shape_of(mesh));
    std::set<std::uint32_t> vertices(input->input_vertex.begin(), input->input_vertex.end());
    CHECK(vertices.size() == mesh.vertex_count());
    const SurfaceAtlas atlas(map);
    CHECK(atlas.folded_triangle_count() == 0);
    double worst = 0;
    for (std::uint32_t v = 0; v < map.surface->vertex_count(); ++v) {
      const SurfaceLocation location = atlas.locate(map.vertex_points[v]);
      Vec3 p;
      for (int k = 0; k < 3; ++k)
        p += location.barycentric[k] * map.surface->positions[map.surface->triangles[location.triangle][k]];
      worst = std::max(worst, distance(p, map.surface->positions[v]));
    }
    CHECK(worst < 1e-13);
  }
}

TEST_CASE("semi-regular input: open surfaces keep their boundary", "[semi_regular]") {
  const TriangleMesh mesh = scrambled(test::sheet(3), 2);
  const auto input = recognize_subdivision_connectivity(mesh);
  REQUIRE(input);
  CHECK(input->hierarchy.level_count() == 2);
  CHECK(input->base_faces.size() == 18);
  const Parameterization map = identity_parameterization(*input, mesh);
  const SurfaceAtlas atlas(map);
  CHECK(atlas.folded_triangle_count() == 0);
}

TEST_CASE("semi-regular input: the limit on levels is kept", "[semi_regular]") {
  const auto input = recognize_subdivision_connectivity(scrambled(test::octahedron(), 3), 2);
  REQUIRE(input);
  CHECK(input->hierarchy.level_count() == 2);
  CHECK(input->base_faces.size() == 32);
}

TEST_CASE("semi-regular input: irregular meshes are refused", "[semi_regular]") {
  TriangleMesh mesh = scrambled(test::icosahedron(), 2);
  // A flipped edge leaves the counts right and the tiling wrong.
  const Triangle t = mesh.triangles[0];
  for (Triangle& s : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      if (s[k] != t[1] || s[(k + 1) % 3] != t[0]) continue;
      const std::uint32_t tip = s[(k + 2) % 3];
      s = {tip, t[1], t[2]};
      mesh.triangles[0] = {t[0], tip, t[2]};
      k = 3;
    }
  }
  CHECK_FALSE(recognize_subdivision_connectivity(mesh));
  CHECK_FALSE(recognize_subdivision_connectivity(TriangleMesh{}));
  TriangleMesh single;
  single.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  single.triangles = {{0, 1, 2}};
  CHECK_FALSE(recognize_subdivision_connectivity(single));
  single.triangles = {{0, 1, 7}};
  CHECK_FALSE(recognize_subdivision_connectivity(single));
  TriangleMesh base = scrambled(test::icosahedron(), 0);
  CHECK_FALSE(recognize_subdivision_connectivity(base));
}

}  // namespace
}  // namespace nmc
