// SPDX-License-Identifier: Apache-2.0
#include "libnmc/common/face_walk.h"

#include <catch2/catch.hpp>

#include "tests/unit/common/small_meshes.h"

namespace nmc {
namespace {

/// The edge between two vertices, or kNone.
std::uint32_t edge_between(const LevelTopology& topology, std::uint32_t a, std::uint32_t b) {
  for (std::uint32_t e = 0; e < topology.edge_count; ++e) {
    const std::uint32_t p = topology.edge_vertices[2 * e], q = topology.edge_vertices[2 * e + 1];
    if ((p == a && q == b) || (p == b && q == a)) return e;
  }
  return kNone;
}

TEST_CASE("face walk: corners go round", "[face_walk]") {
  for (std::uint32_t corner = 0; corner < 3; ++corner) {
    CHECK(next_corner(corner) == (corner + 1) % 3);
    CHECK(previous_corner(corner) == (corner + 2) % 3);
  }
}

TEST_CASE("face walk: the sides of an edge and the faces beyond are those that share its vertices",
          "[face_walk]") {
  for (const test::SmallMesh& base : {test::bipyramid(5), test::grid(4, 3, false), test::grid(3, 4, true)}) {
    LevelTopology coarse, topology;
    REQUIRE(test::build(base, coarse).ok());
    REQUIRE(subdivide(coarse, false, topology).ok());
    for (std::uint32_t edge = 0; edge < topology.edge_count; ++edge) {
      for (std::uint32_t i = 0; i < 2; ++i) {
        INFO(base.name << " edge " << edge << " side " << i);
        const EdgeSide side = edge_side(topology, edge, i);
        REQUIRE(side.face == topology.edge_faces[2 * edge + i]);
        if (side.face == kNone) continue;
        const std::uint32_t* v = topology.face_vertices.data() + 3 * side.face;
        const std::uint32_t tip = v[side_of(topology, edge, side.face)];
        CHECK(tip == topology.opposite_vertex(edge, side.face));
        for (std::uint32_t end = 0; end < 2; ++end) {
          const std::uint32_t vertex = topology.edge_vertices[2 * edge + end];
          CHECK(v[side.corner[end]] == vertex);
          CHECK(side.other[end] == edge_between(topology, vertex, tip));
        }
        // The left face has the first vertex as the tail of the edge, the right one as its head.
        const std::uint32_t tail = topology.edge_vertices[2 * edge + i],
                            head = topology.edge_vertices[2 * edge + 1 - i];
        const FaceBeyond beyond = face_beyond(topology, edge, side.face);
        REQUIRE(beyond.face == topology.edge_faces[2 * edge + 1 - i]);
        if (beyond.face == kNone) continue;
        const std::uint32_t* w = topology.face_vertices.data() + 3 * beyond.face;
        const std::uint32_t far = topology.opposite_vertex(edge, beyond.face);
        CHECK(w[beyond.corner_at_tail] == tail);
        CHECK(w[beyond.corner_at_head] == head);
        CHECK(beyond.edge_at_tail == edge_between(topology, tail, far));
        CHECK(beyond.edge_at_head == edge_between(topology, head, far));
      }
    }
  }
}

TEST_CASE("face walk: halves lie at the tail and at the head", "[face_walk]") {
  LevelTopology coarse, fine;
  REQUIRE(test::build(test::grid(4, 3, false), coarse).ok());
  REQUIRE(subdivide(coarse, false, fine).ok());
  for (std::uint32_t edge = 0; edge < coarse.edge_count; ++edge) {
    for (std::uint32_t i = 0; i < 2; ++i) {
      const std::uint32_t face = coarse.edge_faces[2 * edge + i];
      if (face == kNone) continue;
      const std::uint32_t tail = coarse.edge_vertices[2 * edge + i],
                          head = coarse.edge_vertices[2 * edge + 1 - i];
      const std::uint32_t middle = coarse.vertex_count + edge;
      CHECK(half_at_tail(coarse, edge, face) == edge_between(fine, tail, middle));
      CHECK(half_at_head(coarse, edge, face) == edge_between(fine, middle, head));
    }
  }
}

}  // namespace
}  // namespace nmc
