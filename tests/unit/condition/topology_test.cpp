// SPDX-License-Identifier: Apache-2.0
#include "encoder/condition/topology.h"

#include <catch2/catch.hpp>
#include <numbers>

#include "corpus/generate/shapes.h"

using namespace nmc;

TEST_CASE("analyze_topology: finds genus, loops and Euler characteristic of known surfaces", "[topology]") {
  struct Known {
    const char* name;
    TriangleMesh mesh;
    long euler_characteristic, genus;
    std::size_t loops, components;
  };
  const Known surfaces[] = {
      {"sphere", corpus::icosphere(3), 2, 0, 0, 1},
      {"torus", corpus::torus(20, 10), 0, 1, 0, 1},
      {"knot", corpus::torus_knot(2, 3, 200, 8), 0, 1, 0, 1},
      {"gear", corpus::gear(8, 3), 0, 1, 0, 1},
      {"genus 100", corpus::perforated_plate(10, 10), -198, 100, 0, 1},
      {"comb", corpus::comb(6, 5), 2, 0, 0, 1},
      {"cylinder", corpus::long_cylinder(100, 12, 50), 2, 0, 0, 1},
      {"koch", corpus::koch_surface(3), 2, 0, 0, 1},
      {"terrain", corpus::terrain(10), 1, 0, 1, 1},
      {"disk", corpus::disk_with_holes(300), -299, 0, 301, 1},
      {"sheets", corpus::thin_sheets(4, 5), 8, 0, 0, 4},
      {"loose", corpus::loose_triangles(7), 7, 0, 7, 7},
  };
  for (const Known& known : surfaces) {
    CAPTURE(known.name);
    const Topology topology = analyze_topology(known.mesh);
    CHECK(topology.is_oriented_manifold());
    CHECK(topology.components.size() == known.components);
    CHECK(topology.total_genus() == known.genus);
    CHECK(topology.boundary_loops.size() == known.loops);
    long euler = 0;
    for (const ComponentTopology& c : topology.components) euler += c.euler_characteristic();
    CHECK(euler == known.euler_characteristic);
    CHECK(static_cast<long>(topology.vertex_count) - static_cast<long>(topology.edge_count) +
              static_cast<long>(known.mesh.triangle_count()) ==
          known.euler_characteristic);
  }
}

TEST_CASE("analyze_topology: tells what cannot be oriented from what is only stored so", "[topology]") {
  const Topology strip = analyze_topology(corpus::moebius_strip(30, 3));
  CHECK_FALSE(strip.components.at(0).orientable);
  CHECK(strip.components.at(0).genus == kNoGenus);
  CHECK(strip.boundary_loops.size() == 1);
  CHECK_FALSE(analyze_topology(corpus::klein_bottle(20, 10)).components.at(0).orientable);

  TriangleMesh torus = corpus::torus(20, 10);
  for (std::size_t t = 0; t < torus.triangle_count(); t += 2)
    std::swap(torus.triangles[t][0], torus.triangles[t][1]);
  const Topology turned = analyze_topology(torus);
  CHECK(turned.misoriented_edge_count > 0);
  CHECK(turned.components.at(0).orientable);
  CHECK(turned.components.at(0).genus == 1);
}

TEST_CASE("analyze_topology: counts non-manifold edges and vertices", "[topology]") {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {5, 0, 0}, {5, 1, 0}, {0, 0, 5}};
  mesh.triangles = {{0, 1, 2}, {0, 1, 3}, {1, 0, 4}, {4, 5, 6}};
  const Topology topology = analyze_topology(mesh);
  CHECK(topology.non_manifold_edge_count == 1);
  CHECK(topology.non_manifold_vertex_count == 1);  // vertex 4
  CHECK(topology.vertex_count == 7);
  CHECK(topology.components.size() == 2);
  CHECK(topology.components[0].genus == kNoGenus);
  CHECK_FALSE(topology.is_manifold());
}

TEST_CASE("analyze_topology: measures area, volume and loop length", "[topology]") {
  const Topology sphere = analyze_topology(corpus::icosphere(5));
  CHECK(sphere.components.at(0).area == Approx(4 * std::numbers::pi).epsilon(2e-3));
  CHECK(sphere.components.at(0).volume == Approx(4 * std::numbers::pi / 3).epsilon(2e-3));
  TriangleMesh square = corpus::terrain(4);
  for (Vec3& p : square.positions) p.z = 0;
  corpus::translate(square, {1e7, 0, 0});
  const Topology flat = analyze_topology(square);
  CHECK(flat.components.at(0).area == Approx(1));
  CHECK(flat.boundary_loops.at(0).length == Approx(4));
  CHECK(flat.boundary_loops.at(0).edge_count == 16);
}
