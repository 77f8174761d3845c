// SPDX-License-Identifier: Apache-2.0
// Charts, hinge maps, unfolding and walking on base domains.
#include "encoder/domain/base_domain.h"

#include <catch2/catch.hpp>

#include "corpus/generate/random.h"
#include "corpus/generate/shapes.h"
#include "encoder/core/error.h"
#include "encoder/domain/exact_orientation.h"

namespace nmc {
namespace {

BaseDomain icosahedron() {
  const TriangleMesh mesh = corpus::icosphere(0);
  return BaseDomain(mesh.vertex_count(), mesh.triangles);
}

/// Two triangles glued along one edge.
BaseDomain rhombus() { return BaseDomain(4, {{0, 1, 2}, {2, 1, 3}}); }

ChartPoint random_inside(corpus::Random& random) {
  double u = random.uniform(), v = random.uniform();
  if (u + v > 1) {
    u = 1 - u;
    v = 1 - v;
  }
  return snap_to_grid({u, v});
}

TEST_CASE("A hinge map there and back is the identity, bit by bit") {
  const BaseDomain domain = icosahedron();
  corpus::Random random(1);
  for (std::uint32_t f = 0; f < domain.face_count(); ++f)
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t g = domain.neighbor(f, k);
      REQUIRE(g != kNoFace);
      const ChartPoint p = random_inside(random);
      CHECK(inverse(domain.hinge(f, k))(domain.hinge(f, k)(p)) == p);
      const ChartMap* back = domain.find_map(f, g);
      REQUIRE(back != nullptr);
      CHECK((*back)(domain.hinge(f, k)(p)) == p);
    }
}

TEST_CASE("The corners of an edge have the same coordinates seen from both faces") {
  const BaseDomain domain = icosahedron();
  for (std::uint32_t f = 0; f < domain.face_count(); ++f)
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t g = domain.neighbor(f, k);
      for (const int i : {(k + 1) % 3, (k + 2) % 3}) {
        const int j = domain.corner_of(g, domain.face(f)[i]);
        CHECK(domain.hinge(f, k)(kFaceCorners[j]) == kFaceCorners[i]);
      }
      // The third corner lies on the other side of the edge.
      int opposite = 0;
      while (domain.corner_of(f, domain.face(g)[opposite]) >= 0) ++opposite;
      const ChartPoint third = domain.hinge(f, k)(kFaceCorners[opposite]);
      CHECK(orientation(kFaceCorners[(k + 1) % 3], kFaceCorners[(k + 2) % 3], third) < 0);
    }
}

TEST_CASE("Hinge maps around a vertex compose to a rotation by the missing angle") {
  const BaseDomain domain = icosahedron();
  for (std::uint32_t v = 0; v < domain.vertex_count(); ++v) {
    const auto ring = domain.faces_around(v);
    REQUIRE(ring.size() == 5);
    ChartMap around;
    std::uint32_t f = ring[0];
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const int side = (domain.corner_of(f, v) + 1) % 3;
      around = compose(around, domain.hinge(f, side));
      f = domain.neighbor(f, side);
      CHECK(f == ring[(i + 1) % ring.size()]);
    }
    const ChartPoint cone = kFaceCorners[domain.corner_of(ring[0], v)];
    CHECK(around(cone) == cone);
    CHECK(around.turns == 5);
  }
}

TEST_CASE("Unfolding a point of a neighbouring face and normalizing it gives the point back") {
  const BaseDomain domain = icosahedron();
  corpus::Random random(2);
  for (std::uint32_t f = 0; f < domain.face_count(); ++f)
    for (int k = 0; k < 3; ++k) {
      const DomainPoint p{domain.neighbor(f, k), random_inside(random)};
      const auto unfolded = domain.unfold(p, f);
      REQUIRE(unfolded.has_value());
      const DomainPoint back = domain.normalize(f, *unfolded);
      CHECK(back.face == p.face);
      CHECK(back.at == p.at);
      ChartMap to_start;
      const DomainPoint walked = domain.walk(f, {0.25, 0.25}, *unfolded, &to_start);
      CHECK(to_start(walked.at) == *unfolded);
    }
}

TEST_CASE("A point outside the boundary is clamped onto it") {
  const BaseDomain domain = rhombus();
  const DomainPoint p = domain.normalize(0, {-0.5, 0.5});
  CHECK(p.face == 0);
  CHECK(p.at.u == 0);
  CHECK(domain.edge_tag(0, 1) == EdgeTag::kBoundary);
  CHECK(domain.edge_tag(0, 0) == EdgeTag::kSmooth);
  CHECK(domain.is_boundary_vertex(3));
  const DomainPoint across = domain.normalize(0, {0.75, 0.75});
  CHECK(across.face == 1);
}

TEST_CASE("A cone is found by its exact coordinates and unfolds into every face around it") {
  const BaseDomain domain = icosahedron();
  for (std::uint32_t v = 0; v < domain.vertex_count(); ++v) {
    const DomainPoint p = domain.cone_point(v);
    CHECK(domain.cone_at(p) == v);
    for (const std::uint32_t f : domain.faces_around(v))
      CHECK(domain.unfold(p, f).value() == kFaceCorners[domain.corner_of(f, v)]);
  }
  CHECK(domain.cone_at({0, {0x1p-48, 0}}) == kNoVertex);
}

TEST_CASE("The exact orientation sees a turn of one grid step") {
  const ChartPoint a{0, 0}, b{1, 0x1p-48};
  const ChartPoint on = {0.5, 0x1p-48};
  CHECK(orientation(a, b, on) == 1);
  CHECK(orientation(a, b, {1, 0x1p-48}) == 0);
  CHECK(orientation({0.1, 0.1}, {0.3, 0.3}, {0.2, 0.2}) == -orientation({0.3, 0.3}, {0.1, 0.1}, {0.2, 0.2}));
}

TEST_CASE("Faces that are no oriented manifold are refused") {
  CHECK_THROWS_AS(BaseDomain(3, {{0, 1, 1}}), Error);
  CHECK_THROWS_AS(BaseDomain(4, {{0, 1, 2}, {1, 2, 3}}), Error);             // orientation
  CHECK_THROWS_AS(BaseDomain(5, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}), Error);  // three faces at an edge
  CHECK_THROWS_AS(BaseDomain(5, {{0, 1, 2}, {0, 3, 4}}), Error);             // two umbrellas at a vertex
}

}  // namespace
}  // namespace nmc
