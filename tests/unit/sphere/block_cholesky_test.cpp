// SPDX-License-Identifier: Apache-2.0
#include "encoder/sphere/block_cholesky.h"

#include <catch2/catch.hpp>
#include <set>

#include "tests/unit/sphere/sphere_test_meshes.h"

using namespace nmc;

namespace {

BlockMatrix projected_hessian(const TriangleMesh& mesh, const SphereProblem& problem) {
  std::vector<TangentFrame> frames;
  for (const Vec3& x : mesh.positions) frames.push_back(tangent_frame(x));
  std::vector<Tangent2> gradient;
  BlockMatrix hessian;
  problem.hessian(mesh.positions, frames, HessianKind::kProjected, gradient, hessian);
  return hessian;
}

}  // namespace

TEST_CASE("the nested dissection holds every vertex once, with neighbors on one path to the root") {
  const TriangleMesh mesh = nmc_test::geodesic_sphere(5);
  const VertexGraph graph = vertex_graph(static_cast<std::uint32_t>(mesh.vertex_count()), mesh.triangles);
  const std::vector<DissectionNode> nodes = nested_dissection(graph, mesh.positions);
  std::vector<int> node_of(mesh.vertex_count(), -1);
  std::size_t assigned = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    for (const std::uint32_t v : nodes[i].vertices) {
      CHECK(node_of[v] == -1);
      node_of[v] = static_cast<int>(i);
      ++assigned;
    }
  CHECK(assigned == mesh.vertex_count());
  const auto is_ancestor = [&](int low, int high) {
    while (low >= 0 && low != high) low = nodes[static_cast<std::size_t>(low)].parent;
    return low == high;
  };
  std::size_t separated = 0;
  for (std::uint32_t v = 0; v < graph.vertex_count(); ++v)
    for (std::uint32_t i = graph.offsets[v]; i < graph.offsets[v + 1]; ++i) {
      const int a = node_of[v], b = node_of[graph.neighbors[i]];
      if (!is_ancestor(a, b) && !is_ancestor(b, a)) ++separated;
    }
  CHECK(separated == 0);
  // A sphere's separators grow with the square root of its vertices.
  CHECK(static_cast<double>(nodes.back().vertices.size()) <
        6 * std::sqrt(static_cast<double>(mesh.vertex_count())));
}

TEST_CASE("solving gives back the vector that was multiplied") {
  const TriangleMesh mesh = nmc_test::geodesic_sphere(4);
  const SphereProblem problem(mesh.positions, mesh.triangles, {});
  const BlockMatrix hessian = projected_hessian(mesh, problem);
  BlockCholesky cholesky(problem.graph(), mesh.positions);
  const double shift = 1e-3;
  REQUIRE(cholesky.factorize(hessian, shift));
  std::vector<Tangent2> expected(mesh.vertex_count()), right;
  for (std::size_t v = 0; v < expected.size(); ++v)
    expected[v] = {std::sin(static_cast<double>(v)), std::cos(3.0 * static_cast<double>(v))};
  hessian.multiply(problem.graph(), expected, right);
  for (std::size_t v = 0; v < expected.size(); ++v)
    for (std::size_t k = 0; k < 2; ++k) right[v][k] += shift * expected[v][k];
  const std::vector<Tangent2> solution = cholesky.solve(right);
  double worst = 0;
  for (std::size_t v = 0; v < expected.size(); ++v)
    for (std::size_t k = 0; k < 2; ++k) worst = std::max(worst, std::abs(solution[v][k] - expected[v][k]));
  CHECK(worst < 1e-9);
}

TEST_CASE("an indefinite matrix is reported, and the next factorization works again") {
  const TriangleMesh mesh = nmc_test::geodesic_sphere(3);
  const SphereProblem problem(mesh.positions, mesh.triangles, {});
  const BlockMatrix hessian = projected_hessian(mesh, problem);
  BlockCholesky cholesky(problem.graph(), mesh.positions);
  CHECK_FALSE(cholesky.factorize(hessian, -0.5 * hessian.mean_diagonal()));
  CHECK(cholesky.factorize(hessian, 1e-3));
}
