// SPDX-License-Identifier: Apache-2.0
// Connectivity, ghosts, and undoing.
#include "encoder/domain/corner_table.h"

#include <catch2/catch.hpp>

#include "corpus/generate/shapes.h"
#include "encoder/core/error.h"
#include "encoder/domain/maps_collapse.h"

namespace nmc {
namespace {

using Corner = CornerTable::Corner;

/// Everything a caller can see: triangles and opposite corners of live faces.
std::vector<std::array<std::uint32_t, 2>> snapshot(const CornerTable& table) {
  std::vector<std::array<std::uint32_t, 2>> result;
  for (Corner c = 0; c < 3 * table.face_slot_count(); ++c)
    if (table.is_live_face(CornerTable::face_of(c))) result.push_back({table.vertex(c), table.opposite(c)});
  return result;
}

void check_links(const CornerTable& table) {
  for (Corner c = 0; c < 3 * table.face_slot_count(); ++c) {
    if (!table.is_live_face(CornerTable::face_of(c))) continue;
    const Corner d = table.opposite(c);
    REQUIRE(table.opposite(d) == c);
    REQUIRE(table.vertex(CornerTable::next(c)) == table.vertex(CornerTable::previous(d)));
    REQUIRE(table.vertex(CornerTable::previous(c)) == table.vertex(CornerTable::next(d)));
  }
  for (std::uint32_t v = 0; v < table.vertex_slot_count(); ++v)
    if (table.corner_at(v) != CornerTable::kNone) REQUIRE(table.vertex(table.corner_at(v)) == v);
}

TEST_CASE("Boundaries are closed by one ghost vertex per loop") {
  const TriangleMesh mesh = corpus::disk_with_holes(7);
  const CornerTable table(mesh.vertex_count(), mesh.triangles);
  check_links(table);
  CHECK(table.vertex_slot_count() == table.real_vertex_count() + 8);
  const auto v = static_cast<long>(table.vertex_slot_count()), f = static_cast<long>(table.face_slot_count());
  CHECK(v - f / 2 == 2);  // a sphere
}

TEST_CASE("Collapses undone in reverse order restore the table") {
  for (const TriangleMesh& mesh : {corpus::torus(24, 12), corpus::disk_with_holes(5)}) {
    const CollapseHistory history = maps_collapse(mesh, {12});
    const CornerTable original(history.surface->vertex_count(), history.surface->triangles);
    CornerTable table = history.coarsest;
    check_links(table);
    REQUIRE(history.steps.size() > 50);
    for (std::size_t i = history.steps.size(); i > 0; --i) table.undo_collapse(history.steps[i - 1]);
    check_links(table);
    CHECK(snapshot(table) == snapshot(original));
  }
}

TEST_CASE("A flip undone restores the table") {
  const TriangleMesh mesh = corpus::icosphere(1);
  CornerTable table(mesh.vertex_count(), mesh.triangles);
  const auto before = snapshot(table);
  for (Corner c = 0; c < 30; c += 7) {
    const std::uint32_t p = table.vertex(c), q = table.vertex(table.opposite(c));
    table.flip(c);
    check_links(table);
    bool joined = false;
    Corner d = table.corner_at(p);
    for (int i = table.valence(p); i > 0; --i, d = table.rotate(d))
      joined = joined || table.vertex(CornerTable::next(d)) == q;
    CHECK(joined);
    table.unflip(c);
    CHECK(snapshot(table) == before);
  }
}

TEST_CASE("Surfaces that are no oriented manifold are refused with a reason") {
  CHECK_THROWS_WITH(CornerTable(4, {{0, 1, 2}, {0, 1, 3}}), Catch::Contains("oriented differently"));
  CHECK_THROWS_WITH(CornerTable(5, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}),
                    Catch::Contains("more than two triangles"));
  CHECK_THROWS_WITH(CornerTable(5, {{0, 1, 2}, {0, 3, 4}}), Catch::Contains("manifold"));
  CHECK_THROWS_WITH(CornerTable(3, {{0, 1, 3}}), Catch::Contains("out of range"));
  CHECK_THROWS_WITH(CornerTable(3, {{0, 1, 1}}), Catch::Contains("equal corners"));
}

}  // namespace
}  // namespace nmc
