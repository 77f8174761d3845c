// SPDX-License-Identifier: Apache-2.0
// The spatial index on real scans and CAD models.
#include <catch2/catch.hpp>

#include "encoder/core/parallel.h"
#include "encoder/read/mesh_reader.h"
#include "encoder/spatial/surface_index.h"
#include "tests/corpus_mesh.h"
#include "tests/unit/spatial/test_meshes.h"

namespace nmc {
namespace {

TEST_CASE("corpus: closest_point agrees with brute force on a scan and on CAD") {
  for (const char* name : {"bimba.off", "fandisk.obj", "ADIS16480.stl"}) {
    const auto path = test::corpus_mesh(name);
    if (!path) continue;
    const TriangleMesh mesh = read_mesh(*path);
    const BoundingBox box = bounding_box(mesh);
    const SurfaceIndex index(mesh);
    test::Random random(31);
    for (int i = 0; i < 60; ++i) {
      // Half of the points far from the surface, half within a thousandth of the diagonal.
      const Vec3& vertex = mesh.positions[random.bits() % mesh.vertex_count()];
      const Vec3 point = i % 2 == 0 ? box.center() + box.diagonal() * random.point()
                                    : vertex + 1e-3 * box.diagonal() * random.point();
      CAPTURE(name, i);
      REQUIRE(index.closest_point(point).t ==
              Approx(test::brute_force_distance(mesh, point)).epsilon(1e-9).margin(1e-14 * box.diagonal()));
    }
  }
}

TEST_CASE("corpus: every line crosses a closed surface an even number of times") {
  for (const char* name : {"horse.ply", "botijo.obj", "fandisk.obj", "ADIS16480.stl"}) {
    const auto path = test::corpus_mesh(name);
    if (!path) continue;
    const TriangleMesh mesh = read_mesh(*path);
    const BoundingBox box = bounding_box(mesh);
    const SurfaceIndex index(mesh);
    constexpr std::size_t kLines = 20'000;
    std::vector<Vec3> ends(2 * kLines);
    test::Random random(77);
    for (Vec3& end : ends) end = box.center() + 0.6 * box.diagonal() * random.point();
    std::vector<std::size_t> hit_count(kLines);
    parallel_for(kLines, [&](std::size_t i) {
      std::vector<SurfacePoint> hits;
      index.all_hits(ends[2 * i], ends[2 * i + 1] - ends[2 * i], -1e3, 1e3, 1'000'000, hits);
      hit_count[i] = hits.size();
    });
    std::size_t odd = 0, total = 0;
    for (const std::size_t count : hit_count) {
      odd += count % 2;
      total += count;
    }
    CAPTURE(name, total);
    CHECK(odd == 0);
    CHECK(total > kLines / 10);
  }
}

TEST_CASE("corpus: a ray along the normal through a vertex of a scan meets the surface there once") {
  const auto path = test::corpus_mesh("bimba.off");
  if (!path) return;
  const TriangleMesh mesh = read_mesh(*path);
  const double reach = 1e-5 * bounding_box(mesh).diagonal();
  const std::vector<Vec3> normals = vertex_normals(mesh);
  // Where a triangle around the vertex faces away from the normal, the line may touch the surface without
  // crossing it.
  std::vector<bool> faces_normal(mesh.vertex_count(), true);
  for (const Triangle& triangle : mesh.triangles) {
    const Vec3& a = mesh.positions[triangle[0]];
    const Vec3 normal = normalized(cross(mesh.positions[triangle[1]] - a, mesh.positions[triangle[2]] - a));
    for (const std::uint32_t corner : triangle) {
      if (dot(normal, normals[corner]) < 0.01) faces_normal[corner] = false;
    }
  }
  const SurfaceIndex index(mesh);
  std::vector<SurfacePoint> hits;
  std::size_t tested = 0, missed = 0, doubled = 0;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    if (!faces_normal[v]) continue;
    index.all_hits(mesh.positions[v] + reach * normals[v], normals[v], -2 * reach, 0, 100, hits);
    ++tested;
    missed += hits.empty();
    doubled += hits.size() > 1;
  }
  CHECK(tested > mesh.vertex_count() * 9 / 10);
  CHECK(missed == 0);
  CHECK(doubled == 0);
}

}  // namespace
}  // namespace nmc
