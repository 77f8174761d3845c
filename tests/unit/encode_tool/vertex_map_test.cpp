// SPDX-License-Identifier: Apache-2.0
#include "encoder/tool/vertex_map.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <vector>

#include "libnmc/common/subdivision.h"

namespace nmc {
namespace {

/// A base of two triangles, split `level` times; odd vertices on the midpoints of their edges.
TriangleMesh flat_square(int level) {
  const std::array<std::uint32_t, 6> faces{0, 1, 2, 0, 2, 3};
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  LevelTopology topology;
  REQUIRE(build_base_topology(faces.data(), 2, 4, nullptr, topology).ok());
  for (int l = 0; l < level; ++l) {
    for (std::uint32_t e = 0; e < topology.edge_count; ++e) {
      mesh.positions.push_back(0.5 * (mesh.positions[topology.edge_vertices[2 * e]] +
                                      mesh.positions[topology.edge_vertices[2 * e + 1]]));
    }
    LevelTopology fine;
    REQUIRE(subdivide(topology, false, fine).ok());
    topology = std::move(fine);
  }
  for (std::uint32_t f = 0; f < topology.face_count; ++f) {
    const std::uint32_t* v = topology.face_vertices.data() + std::size_t{3} * f;
    mesh.triangles.push_back({v[0], v[1], v[2]});
  }
  return mesh;
}

TEST_CASE("An address names the same point on the base mesh at every level") {
  const TriangleMesh base = flat_square(0);
  for (const int level : {0, 1, 2, 3}) {
    const TriangleMesh fine = flat_square(level);
    for (std::uint32_t f = 0; f < fine.triangle_count(); ++f) {
      const double weights[3] = {0.5, 0.3, 0.2};
      const SurfaceAddress address = address_on_base(f, level, weights);
      const Triangle& t = fine.triangles[f];
      const Vec3 expected =
          0.5 * fine.positions[t[0]] + 0.3 * fine.positions[t[1]] + 0.2 * fine.positions[t[2]];
      const Triangle& b = base.triangles.at(address.base_face);
      const Vec3 found = (1 - address.u - address.v) * base.positions[b[0]] +
                         address.u * base.positions[b[1]] + address.v * base.positions[b[2]];
      INFO("level " << level << ", face " << f);
      CHECK(distance(expected, found) < 1e-12);
    }
  }
}

TEST_CASE("Heights are signed by the side of the surface, and vertices that are not finite have no address") {
  TriangleMesh input;
  input.positions = {{0.25, 0.5, 0.125}, {0.75, 0.25, -0.5}, {NAN, 0, 0}};
  const std::vector<SurfaceAddress> map = map_vertices(input, flat_square(2), 2);
  CHECK(map[0].height == Approx(0.125));
  CHECK(map[1].height == Approx(-0.5));
  CHECK(map[2].base_face == kNoBaseFace);
  CHECK(to_csv(map).find("\n2,-1,0,0,0\n") != std::string::npos);
}

}  // namespace
}  // namespace nmc
