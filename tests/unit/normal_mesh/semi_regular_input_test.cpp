// SPDX-License-Identifier: Apache-2.0
#include "encoder/normal_mesh/semi_regular_input.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <optional>
#include <set>
#include <string>

#include "encoder/core/error.h"
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

test::BaseShape two_components() {
  test::BaseShape two = test::icosahedron();
  const test::BaseShape other = test::octahedron();
  for (const Triangle& t : other.faces) two.faces.push_back({t[0] + 12, t[1] + 12, t[2] + 12});
  for (const Vec3& p : other.positions) two.positions.push_back(p + Vec3{10, 0, 0});
  return two;
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
  for (const Case& c :
       {Case{"tetrahedron", test::tetrahedron(), 4}, Case{"octahedron", test::octahedron(), 3},
        Case{"icosahedron", test::icosahedron(), 1}, Case{"two components", two_components(), 2}}) {
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

/// The base as a mesh of its own, in another order than scrambled() gives it, and a little rounded.
TriangleMesh as_mesh(const test::BaseShape& base) {
  TriangleMesh mesh;
  const std::uint32_t last = static_cast<std::uint32_t>(base.positions.size()) - 1;
  for (std::uint32_t v = 0; v <= last; ++v)
    mesh.positions.push_back(base.positions[last - v] + Vec3{1e-8, -1e-8, 1e-8});
  for (const Triangle& t : base.faces) mesh.triangles.push_back({last - t[1], last - t[2], last - t[0]});
  std::reverse(mesh.triangles.begin(), mesh.triangles.end());
  return mesh;
}

std::string refusal(const TriangleMesh& base, const TriangleMesh& mesh, std::optional<int> level_count = {}) {
  try {
    recognize_subdivision_of(base, mesh, 1e-6, level_count);
  } catch (const Error& error) {
    CHECK(error.code() == ExitCode::kInvalidInput);
    return error.what();
  }
  return "";
}

TEST_CASE("semi-regular input: a base mesh that is given is found again, however it is numbered",
          "[semi_regular]") {
  struct Case {
    const char* name;
    test::BaseShape base;
    int depth;
  };
  for (const Case& c : {Case{"icosahedron", test::icosahedron(), 3}, Case{"boundary", test::sheet(3), 2},
                        Case{"two components", two_components(), 2},
                        Case{"torus, which can be tiled in four ways", test::torus(3, 3), 2}}) {
    INFO(c.name);
    const TriangleMesh mesh = scrambled(c.base, c.depth), base = as_mesh(c.base);
    for (const std::optional<int> level_count : {std::optional<int>(), std::optional<int>(c.depth)}) {
      const SemiRegularInput input = recognize_subdivision_of(base, mesh, 1e-6, level_count);
      CHECK(input.hierarchy.level_count() == c.depth);
      REQUIRE(input.base_vertex_count == base.vertex_count());
      CHECK(input.base_faces.size() == base.triangle_count());
      for (std::uint32_t v = 0; v < input.base_vertex_count; ++v) {
        const Vec3 p = mesh.positions[input.input_vertex[v]];
        CHECK(std::any_of(base.positions.begin(), base.positions.end(),
                          [&](const Vec3& q) { return distance(p, q) < 1e-6; }));
      }
    }
  }
}

TEST_CASE("semi-regular input: a base mesh may be a finer level than the coarsest there is",
          "[semi_regular]") {
  const TriangleMesh mesh = scrambled(test::octahedron(), 4), base = scrambled(test::octahedron(), 2);
  CHECK(recognize_subdivision_connectivity(mesh)->hierarchy.level_count() == 4);
  CHECK(recognize_subdivision_of(base, mesh, 1e-6).hierarchy.level_count() == 2);
}

TEST_CASE("semi-regular input: a base mesh turned inside out, or given corner by corner, is accepted",
          "[semi_regular]") {
  const TriangleMesh mesh = scrambled(test::icosahedron(), 2);
  TriangleMesh soup;
  const test::BaseShape icosahedron = test::icosahedron();
  for (const Triangle& t : icosahedron.faces) {
    const auto first = static_cast<std::uint32_t>(soup.positions.size());
    for (const std::uint32_t v : t) soup.positions.push_back(icosahedron.positions[v]);
    soup.triangles.push_back({first + 2, first + 1, first});
  }
  CHECK(recognize_subdivision_of(soup, mesh, 1e-6).base_vertex_count == 12);
}

TEST_CASE("semi-regular input: a wrong base mesh is refused with the reason", "[semi_regular]") {
  using Catch::Contains;
  const test::BaseShape shape = test::icosahedron();
  const TriangleMesh mesh = scrambled(shape, 3), base = as_mesh(shape);
  CHECK_THAT(refusal(as_mesh(test::octahedron()), mesh),
             Contains("1280 triangles") && Contains("8 of the base"));
  CHECK_THAT(refusal(mesh, mesh), Contains("1280 triangles"));
  CHECK_THAT(refusal(base, mesh, 2), Contains("after 3 splits, not 2"));
  CHECK_THAT(refusal(TriangleMesh{}, mesh), Contains("no triangles"));
  TriangleMesh moved = base;
  moved.positions[7].x += 0.01;
  CHECK_THAT(refusal(moved, mesh), Contains("vertex 7 of the base mesh"));
  TriangleMesh flipped = base;  // two neighbours after an edge flip: the same places, other triangles
  const Triangle t = flipped.triangles[0];
  for (Triangle& s : flipped.triangles) {
    for (int k = 0; k < 3; ++k) {
      if (s[k] != t[1] || s[(k + 1) % 3] != t[0]) continue;
      const std::uint32_t tip = s[(k + 2) % 3];
      s = {tip, t[1], t[2]};
      flipped.triangles[0] = {t[0], tip, t[2]};
      k = 3;
    }
  }
  CHECK_THAT(refusal(flipped, mesh), Contains("triangles that the base mesh does not have"));
  TriangleMesh broken = base;
  broken.triangles[0][0] = 99;
  CHECK_THAT(refusal(broken, mesh), Contains("does not exist"));
  TriangleMesh irregular = mesh;  // the base is right, the input is not
  std::swap(irregular.triangles[0][0], irregular.triangles[0][1]);
  CHECK_THAT(refusal(base, irregular), Contains("connectivity"));
}

}  // namespace
}  // namespace nmc
