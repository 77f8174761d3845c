// SPDX-License-Identifier: Apache-2.0
#include "libnmc/common/subdivision.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <map>
#include <set>
#include <utility>

#include "tests/unit/common/small_meshes.h"

namespace nmc {
namespace {

using test::SmallMesh;

/// The first broken rule of the tables of one level, or nothing.
std::string broken_rule(const LevelTopology& t) {
  const auto at = [](const char* rule, std::uint32_t index) {
    return std::string(rule) + " at " + std::to_string(index);
  };
  if (t.face_vertices.size() != 3u * t.face_count || t.face_edges.size() != 3u * t.face_count ||
      t.edge_vertices.size() != 2u * t.edge_count || t.edge_faces.size() != 2u * t.edge_count) {
    return "table sizes";
  }
  std::vector<int> uses(t.edge_count, 0);
  for (std::uint32_t f = 0; f < t.face_count; ++f) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      if (t.face_vertices[3 * f + k] >= t.vertex_count) return at("corner out of range", f);
      const std::uint32_t e = t.face_edges[3 * f + k];
      if (e >= t.edge_count) return at("edge out of range", f);
      ++uses[e];
      const std::uint32_t a = t.face_vertices[3 * f + (k + 1) % 3], b = t.face_vertices[3 * f + (k + 2) % 3];
      const std::uint32_t p = t.edge_vertices[2 * e], q = t.edge_vertices[2 * e + 1];
      const bool is_left = t.edge_faces[2 * e] == f, is_right = t.edge_faces[2 * e + 1] == f;
      if (is_left == is_right) return at("face is not one side of its edge", f);
      if (is_left && (p != a || q != b)) return at("left face does not hold its edge counter-clockwise", f);
      if (is_right && (p != b || q != a)) return at("right face does not hold its edge clockwise", f);
      if (t.opposite_vertex(e, f) != t.face_vertices[3 * f + k]) return at("opposite vertex", f);
    }
  }
  for (std::uint32_t e = 0; e < t.edge_count; ++e) {
    if (t.edge_faces[2 * e] == kNone) return at("edge without left face", e);
    if (uses[e] != (t.is_boundary(e) ? 1 : 2)) return at("number of faces of an edge", e);
  }
  if (!t.has_curves()) {
    for (std::uint32_t e = 0; e < t.edge_count; ++e)
      if (t.is_boundary(e)) return at("boundary edge without curve tables", e);
    return {};
  }
  std::vector<std::set<std::uint32_t>> curves(t.vertex_count);
  for (std::uint32_t e = 0; e < t.edge_count; ++e) {
    if (t.is_boundary(e) && !t.is_curve(e)) return at("boundary edge is no curve", e);
    if (!t.is_curve(e)) continue;
    curves[t.edge_vertices[2 * e]].insert(e);
    curves[t.edge_vertices[2 * e + 1]].insert(e);
  }
  for (std::uint32_t v = 0; v < t.vertex_count; ++v) {
    const int degree = std::min(3, static_cast<int>(curves[v].size()));
    if (t.curve_degree(v) != degree) return at("curve degree", v);
    if (degree == 0 || degree == 3) continue;
    std::set<std::uint32_t> slots = {t.vertex_curve_edges[2 * v]};
    if (degree == 2) slots.insert(t.vertex_curve_edges[2 * v + 1]);
    if (slots != curves[v]) return at("curve edges of a vertex", v);
  }
  return {};
}

int euler_characteristic(const LevelTopology& t) {
  return static_cast<int>(t.vertex_count) - static_cast<int>(t.edge_count) + static_cast<int>(t.face_count);
}

TEST_CASE("subdivision: the tables of every level to 4 agree with each other", "[subdivision]") {
  for (const SmallMesh& mesh : test::all_small_meshes()) {
    LevelTopology level;
    REQUIRE(test::build(mesh, level).ok());
    const int characteristic = euler_characteristic(level);
    for (int l = 0; l <= 4; ++l) {
      INFO(mesh.name << ", level " << l);
      CHECK(broken_rule(level) == "");
      CHECK(euler_characteristic(level) == characteristic);
      CHECK(level.base_vertex_count == mesh.vertex_count);
      LevelTopology fine;
      REQUIRE(subdivide(level, false, fine).ok());
      level = std::move(fine);
    }
  }
}

TEST_CASE("subdivision: vertices, faces and edges are numbered as the header draws them", "[subdivision]") {
  for (const SmallMesh& mesh : test::all_small_meshes()) {
    INFO(mesh.name);
    LevelTopology coarse, fine;
    REQUIRE(test::build(mesh, coarse).ok());
    REQUIRE(subdivide(coarse, false, fine).ok());
    const std::uint32_t V = coarse.vertex_count, E = coarse.edge_count;
    CHECK(fine.vertex_count == V + E);
    CHECK(fine.edge_count == 2 * E + 3 * coarse.face_count);
    CHECK(fine.face_count == 4 * coarse.face_count);
    for (std::uint32_t f = 0; f < coarse.face_count; ++f) {
      const std::uint32_t* v = coarse.face_vertices.data() + 3 * f;
      const std::uint32_t m[3] = {V + coarse.face_edges[3 * f], V + coarse.face_edges[3 * f + 1],
                                  V + coarse.face_edges[3 * f + 2]};
      const std::vector<std::uint32_t> expected = {v[0], m[2], m[1], m[2], v[1], m[0],
                                                   m[1], m[0], v[2], m[0], m[1], m[2]};
      CHECK(std::vector<std::uint32_t>(fine.face_vertices.data() + 12 * f,
                                       fine.face_vertices.data() + 12 * f + 12) == expected);
      for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t e = 2 * E + 3 * f + k;
        CHECK(fine.edge_vertices[2 * e] == m[(k + 1) % 3]);
        CHECK(fine.edge_vertices[2 * e + 1] == m[(k + 2) % 3]);
        CHECK(fine.edge_faces[2 * e] == 4 * f + 3);
        CHECK(fine.edge_faces[2 * e + 1] == 4 * f + k);
      }
    }
    for (std::uint32_t e = 0; e < E; ++e) {
      CHECK(fine.edge_vertices[4 * e] == coarse.edge_vertices[2 * e]);
      CHECK(fine.edge_vertices[4 * e + 1] == V + e);
      CHECK(fine.edge_vertices[4 * e + 2] == V + e);
      CHECK(fine.edge_vertices[4 * e + 3] == coarse.edge_vertices[2 * e + 1]);
    }
  }
}

TEST_CASE("subdivision: faces_only gives the same faces", "[subdivision]") {
  LevelTopology coarse, fine, faces;
  REQUIRE(test::build(test::fan(5, true), coarse).ok());
  REQUIRE(subdivide(coarse, false, fine).ok());
  REQUIRE(subdivide(coarse, true, faces).ok());
  CHECK(faces.vertex_count == fine.vertex_count);
  CHECK(faces.edge_count == fine.edge_count);
  CHECK(std::equal(faces.face_vertices.begin(), faces.face_vertices.end(), fine.face_vertices.begin(),
                   fine.face_vertices.end()));
}

TEST_CASE("base topology: edges are numbered by first visit", "[subdivision]") {
  LevelTopology t;
  REQUIRE(test::build(test::fan(2, false), t).ok());  // faces (0,1,2), (0,2,3)
  const std::vector<std::uint32_t> expected = {1, 2, 2, 0, 0, 1, 2, 3, 3, 0};
  CHECK(std::vector<std::uint32_t>(t.edge_vertices.begin(), t.edge_vertices.end()) == expected);
}

TEST_CASE("base topology: refuses what is not an oriented manifold, with the reason",
          "[subdivision][malformed]") {
  struct Case {
    const char* name;
    SmallMesh mesh;
    const char* reason;  // part of the message
  };
  const std::vector<Case> cases = {
      {"index out of range", {"", 3, {{0, 1, 3}}, {}}, "does not exist"},
      {"largest index", {"", 3, {{0, 1, 0xffffffffu}}, {}}, "does not exist"},
      {"equal corners", {"", 3, {{0, 1, 1}}, {}}, "equal corners"},
      {"three faces at an edge", {"", 5, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}, {}}, "more than two faces"},
      {"orientation", {"", 4, {{0, 1, 2}, {0, 1, 3}}, {}}, "orientation"},
      {"the same face twice", {"", 3, {{0, 1, 2}, {0, 1, 2}}, {}}, "orientation"},
      {"unused vertex", {"", 4, {{0, 1, 2}}, {}}, "has no face"},
      {"two umbrellas", {"", 5, {{0, 1, 2}, {0, 3, 4}}, {}}, "not connected"},
      {"closed and open umbrella",
       {"", 6, {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {0, 4, 5}}, {}},
       "not connected"},
      {"valence", test::fan(kMaximumValence + 1, true), "too many faces"},
  };
  for (const Case& c : cases) {
    INFO(c.name);
    LevelTopology topology;
    const Status status = test::build(c.mesh, topology);
    CHECK(status.code() == StatusCode::kCorrupt);
    REQUIRE(status.message());
    CHECK(std::string(status.message()).find(c.reason) != std::string::npos);
  }
  LevelTopology topology;
  CHECK(test::build(test::fan(kMaximumValence, true), topology).ok());
}

TEST_CASE("base topology: a face back to back with itself is a valid closed surface", "[subdivision]") {
  LevelTopology t;
  REQUIRE(test::build({"", 3, {{0, 1, 2}, {0, 2, 1}}, {}}, t).ok());
  CHECK(t.edge_count == 3);
  CHECK_FALSE(t.has_curves());
}

TEST_CASE("base topology: a memory limit is a status at every allocation", "[subdivision][malformed]") {
  const SmallMesh mesh = test::fan(7, true);
  int failures = 0;
  for (std::uint64_t limit = 0; limit < 4096; limit += 16) {
    Memory memory(nullptr, nullptr, nullptr, limit);
    {
      LevelTopology base(&memory), fine(&memory);
      Status status =
          build_base_topology(mesh.faces.front().data(), static_cast<std::uint32_t>(mesh.faces.size()),
                              mesh.vertex_count, &memory, base);
      if (status.ok()) status = subdivide(base, false, fine);
      if (!status.ok()) {
        ++failures;
        CHECK(status.code() == StatusCode::kNoMemory);
      }
    }
    CHECK(memory.used() == 0);
  }
  CHECK(failures > 10);
  CHECK(failures < 256);
}

}  // namespace
}  // namespace nmc
