// SPDX-License-Identifier: Apache-2.0
#include "encoder/domain/simplify.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "encoder/domain/corner_table.h"

namespace {

using nmc::TriangleMesh;
using nmc::Vec3;

/// A box of n * n squares on each side, its corners the first points of a lattice.
TriangleMesh box(int n) {
  TriangleMesh mesh;
  std::map<std::array<int, 3>, std::uint32_t> index;
  const auto vertex = [&](const std::array<int, 3>& at) {
    const auto [found, is_new] = index.emplace(at, static_cast<std::uint32_t>(mesh.positions.size()));
    if (is_new) mesh.positions.push_back({1.0 * at[0], 1.0 * at[1], 1.0 * at[2]});
    return found->second;
  };
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {0, n}) {
      for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
          const auto at = [&](int u, int v) {
            std::array<int, 3> p{};
            p[static_cast<std::size_t>(axis)] = side;
            p[static_cast<std::size_t>((axis + 1) % 3)] = u;
            p[static_cast<std::size_t>((axis + 2) % 3)] = v;
            return vertex(p);
          };
          std::array<std::uint32_t, 4> q{at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)};
          if (side == 0) std::reverse(q.begin(), q.end());
          mesh.triangles.push_back({q[0], q[1], q[2]});
          mesh.triangles.push_back({q[0], q[2], q[3]});
        }
      }
    }
  }
  return mesh;
}

TriangleMesh square(int n) {
  TriangleMesh mesh;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) mesh.positions.push_back({1.0 * i, 1.0 * j, 0});
  const auto at = [n](int i, int j) { return static_cast<std::uint32_t>(i * (n + 1) + j); };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

double area(const TriangleMesh& mesh) {
  double sum = 0;
  for (const nmc::Triangle& t : mesh.triangles) {
    const Vec3& a = mesh.positions[t[0]];
    sum += 0.5 * norm(cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a));
  }
  return sum;
}

double volume(const TriangleMesh& mesh) {
  double sum = 0;
  for (const nmc::Triangle& t : mesh.triangles)
    sum += dot(mesh.positions[t[0]], cross(mesh.positions[t[1]], mesh.positions[t[2]])) / 6;
  return sum;
}

}  // namespace

TEST_CASE("a finely cut box is left with its eight corners") {
  const TriangleMesh fine = box(12);
  const TriangleMesh simple = nmc::simplify(fine, {8})[0];
  CHECK(simple.vertex_count() == 8);
  CHECK(simple.triangles.size() == 12);
  for (const Vec3& p : simple.positions)
    for (const double x : {p.x, p.y, p.z}) CHECK(std::abs(x - 12 * std::round(x / 12)) < 1e-3);
  CHECK(volume(simple) == Approx(12.0 * 12 * 12).epsilon(1e-4));
}

TEST_CASE("the outline of an open square stays") {
  const TriangleMesh simple = nmc::simplify(square(16), {4})[0];
  CHECK(simple.vertex_count() == 4);
  CHECK(area(simple) == Approx(256.0).epsilon(1e-4));
}

TEST_CASE("several sizes of one run are manifolds of the asked numbers of vertices, in the order asked") {
  const TriangleMesh fine = box(10);
  const std::vector<TriangleMesh> meshes = nmc::simplify(fine, {20, 200, 80});
  REQUIRE(meshes.size() == 3);
  CHECK(meshes[0].vertex_count() == 20);
  CHECK(meshes[1].vertex_count() == 200);
  CHECK(meshes[2].vertex_count() == 80);
  for (const TriangleMesh& mesh : meshes) {
    const nmc::CornerTable table(mesh.vertex_count(), mesh.triangles);  // throws where it is none
    CHECK(table.real_face_count() == 2 * mesh.vertex_count() - 4);      // closed, genus 0
  }
}

TEST_CASE("a count that cannot be reached gives the fewest vertices that can") {
  CHECK(nmc::simplify(box(6), {1})[0].vertex_count() == 4);
}

TEST_CASE("a base of a run of collapses has the vertices that its size says") {
  const TriangleMesh fine = box(10);
  const nmc::CollapseHistory history = nmc::maps_collapse(fine, {50, 300});
  for (std::size_t i = 0; i < 2; ++i) {
    const TriangleMesh base = nmc::mesh_of_base(history, i);
    CHECK(base.vertex_count() == history.surface->vertex_count() - history.base_step_counts[i]);
    CHECK(base.triangles.size() == 2 * base.vertex_count() - 4);
  }
}
