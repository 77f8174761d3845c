// SPDX-License-Identifier: Apache-2.0
// The generated corpus is what its names say.
#include "corpus/generate/shapes.h"

#include <catch2/catch.hpp>

#include "encoder/condition/condition.h"
#include "tests/unit/condition/oriented_manifold.h"

using namespace nmc;

TEST_CASE("corpus shapes: are clean manifolds that look outward, but for the ones that cannot be",
          "[corpus-shapes]") {
  for (const corpus::CatalogueEntry& entry : corpus::catalogue()) {
    CAPTURE(entry.name);
    const TriangleMesh mesh = entry.make();
    const bool is_orientable = entry.name != "moebius" && entry.name != "klein_bottle";
    ConditionOptions options;
    options.repair = is_orientable ? Repair::kStrict : Repair::kAuto;
    const ConditionedMesh result = condition(mesh, options);
    CHECK(result.mesh.triangle_count() == mesh.triangle_count());
    if (is_orientable) CHECK(test::difference(result.mesh, mesh) == "");
    CHECK((result.report.cut_edges == 0) == is_orientable);
  }
}

TEST_CASE("corpus shapes: subdivided meshes have the size asked for and the topology they had",
          "[corpus-shapes]") {
  for (const std::size_t count : {500u, 1281u, 5000u, 77777u}) {
    CAPTURE(count);
    const TriangleMesh torus = corpus::torus(16, 10);
    const TriangleMesh fine = corpus::subdivide(torus, count, 1e-4);
    CHECK(fine.triangle_count() >= count);
    CHECK(fine.triangle_count() <= count + 2);
    const Topology topology = analyze_topology(fine);
    CHECK(topology.is_oriented_manifold());
    CHECK(topology.total_genus() == 1);
    CHECK(topology.components.at(0).area == Approx(surface_area(torus)).epsilon(0.05));
  }
  const TriangleMesh bowl = corpus::subdivide(corpus::disk_with_holes(9), 20000, 0);
  CHECK(analyze_topology(bowl).boundary_loops.size() == 10);
  CHECK(analyze_topology(bowl).is_oriented_manifold());
}

TEST_CASE("corpus shapes: the zone sphere is continuous where its waves meet", "[corpus-shapes]") {
  const TriangleMesh sphere = corpus::zone_sphere(6);
  double largest = 0, smallest = 2;
  for (const Vec3& p : sphere.positions) {
    largest = std::max(largest, norm(p));
    smallest = std::min(smallest, norm(p));
  }
  CHECK(largest == Approx(1.02).margin(1e-3));
  CHECK(smallest == Approx(0.98).margin(1e-3));
}
