// SPDX-License-Identifier: Apache-2.0
// The energy of a whole triangulated sphere: value, Riemannian gradient and Hessian.
//
// Based on: I. Friedel, thesis, section 4.3; the Hessian follows from the chain rule over the squared edge
// lengths: for a = |x_j - x_k|^2 on the unit sphere, d a / d x_j = -2 x_k (tangential part), the mixed second
// derivative is -2 and the diagonal one is +2 x_j . x_k times the identity of the tangent plane.
#ifndef NMC_ENCODER_SPHERE_SPHERE_PROBLEM_H_
#define NMC_ENCODER_SPHERE_SPHERE_PROBLEM_H_

#include <array>
#include <cstdint>
#include <vector>

#include "encoder/core/triangle_mesh.h"
#include "encoder/sphere/spherical_energy.h"
#include "encoder/sphere/tangent_frame.h"

namespace nmc {

/// Two coordinates in a vertex's tangent frame.
using Tangent2 = std::array<double, 2>;

/// Which vertices share an edge, in both directions, with one slot per edge for its block of the Hessian.
struct VertexGraph {
  std::vector<std::uint32_t> offsets;     // vertex v has neighbors [offsets[v], offsets[v + 1])
  std::vector<std::uint32_t> neighbors;   // ascending per vertex
  std::vector<std::uint32_t> edge_slots;  // parallel to neighbors
  std::uint32_t edge_count = 0;

  std::uint32_t vertex_count() const { return static_cast<std::uint32_t>(offsets.size() - 1); }
};

VertexGraph vertex_graph(std::uint32_t vertex_count, const std::vector<Triangle>& triangles);

/// A symmetric matrix of 2 x 2 blocks with the pattern of a VertexGraph.
struct BlockMatrix {
  std::vector<std::array<double, 3>> diagonal;  // xx, xy, yy per vertex
  std::vector<std::array<double, 4>>
      off_diagonal;  // per edge slot, row-major: rows of the lower vertex index

  double mean_diagonal() const;
  /// result = matrix * vector, in parallel and identical for any number of threads.
  void multiply(const VertexGraph& graph, const std::vector<Tangent2>& vector,
                std::vector<Tangent2>& result) const;
};

enum class HessianKind {
  kExact,      // the Riemannian Hessian: quadratic convergence, may be indefinite
  kProjected,  // positive semi-definite by construction, linear convergence
};

/// Immutable but for the arguments; the functions may be called concurrently.
class SphereProblem {
 public:
  /// `reference` is the input surface: closed, genus 0, oriented. Its area is scaled to 4 pi. O(n).
  SphereProblem(const std::vector<Vec3>& reference, std::vector<Triangle> triangles,
                const SphereEnergyWeights& weights);

  std::uint32_t vertex_count() const { return graph_.vertex_count(); }
  const std::vector<Triangle>& triangles() const { return triangles_; }
  const SphereEnergyWeights& weights() const { return weights_; }
  const std::vector<ReferenceTriangle>& references() const { return references_; }
  const VertexGraph& graph() const { return graph_; }
  /// The triangles around a vertex, in no particular order: corner_offsets()[v] .. [v + 1) of corners(), each
  /// 3 * triangle + corner.
  const std::vector<std::uint32_t>& corner_offsets() const { return corner_offsets_; }
  const std::vector<std::uint32_t>& corners() const { return corners_; }

  /// Positions are unit vectors. Infinite where a triangle reaches a hemisphere.
  double energy(const std::vector<Vec3>& positions) const;

  /// Also the Riemannian gradient, one tangent vector of space per vertex.
  double gradient(const std::vector<Vec3>& positions, std::vector<Vec3>& gradient) const;

  /// Also the Hessian, in the given frames.
  double hessian(const std::vector<Vec3>& positions, const std::vector<TangentFrame>& frames,
                 HessianKind kind, std::vector<Tangent2>& gradient, BlockMatrix& hessian) const;

  /// Triangles that are not safely counter-clockwise in double precision.
  std::size_t flipped_count(const std::vector<Vec3>& positions) const;

  /// How often the triangles cover the sphere: their solid angles over 4 pi, rounded. A long step can keep
  /// every triangle counter-clockwise and still wrap a part of the mesh around; then this is not 1.
  int covering_degree(const std::vector<Vec3>& positions) const;

 private:
  struct LocalHessian;

  SphereEnergyWeights weights_;
  std::vector<Triangle> triangles_;
  std::vector<ReferenceTriangle> references_;
  VertexGraph graph_;
  std::vector<std::uint32_t> corner_offsets_, corners_;
  std::vector<std::array<std::uint32_t, 3>> triangle_edges_;  // edge slot opposite to each corner
  std::vector<std::array<std::uint32_t, 2>> edge_corners_;    // the two corners opposite to an edge
};

/// Whether the triangle is counter-clockwise by more than the rounding error of the test.
bool is_safely_oriented(const Vec3& x0, const Vec3& x1, const Vec3& x2);

/// sqrt of the sum of squares, with parallel_sum's fixed order.
double norm(const std::vector<Vec3>& vectors);
double dot(const std::vector<Vec3>& a, const std::vector<Vec3>& b);
double dot(const std::vector<Tangent2>& a, const std::vector<Tangent2>& b);

}  // namespace nmc

#endif  // NMC_ENCODER_SPHERE_SPHERE_PROBLEM_H_
