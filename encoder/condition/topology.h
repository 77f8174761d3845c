// SPDX-License-Identifier: Apache-2.0
// What kind of surface a triangle mesh is: components, Euler characteristic, genus, boundary loops.
#ifndef NMC_ENCODER_CONDITION_TOPOLOGY_H_
#define NMC_ENCODER_CONDITION_TOPOLOGY_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "encoder/core/triangle_mesh.h"

namespace nmc {

/// Genus of a component that has none: not a manifold, or not orientable.
inline constexpr long kNoGenus = -1;

/// Triangles that hang together by edges.
struct ComponentTopology {
  std::size_t vertex_count = 0;  // umbrellas: a vertex that joins two sheets counts twice
  std::size_t edge_count = 0;
  std::size_t triangle_count = 0;
  std::size_t boundary_loop_count = 0;
  std::size_t non_manifold_edge_count = 0;  // more than two triangles
  std::uint32_t first_triangle = 0;         // the lowest triangle index
  bool orientable = true;
  long genus = 0;     // (2 - loops - Euler characteristic) / 2, or kNoGenus
  double area = 0;    // square units
  double volume = 0;  // signed; of closed, consistently oriented components, otherwise 0
  BoundingBox box;
  long euler_characteristic() const {
    return static_cast<long>(vertex_count) - static_cast<long>(edge_count) +
           static_cast<long>(triangle_count);
  }
  bool is_closed() const { return boundary_loop_count == 0 && non_manifold_edge_count == 0; }
};

/// A closed chain of edges with one triangle each.
struct BoundaryLoop {
  std::uint32_t component = 0;
  std::uint32_t first_half_edge = 0;  // 3 * triangle + corner; the lowest of the loop
  std::size_t edge_count = 0;
  double length = 0;
};

struct Topology {
  std::vector<ComponentTopology> components;         // ordered by first_triangle
  std::vector<std::uint32_t> component_of_triangle;  // one per triangle
  std::vector<BoundaryLoop> boundary_loops;          // ordered by first_half_edge
  std::size_t vertex_count = 0;                      // vertices that a triangle uses
  std::size_t edge_count = 0;
  std::size_t boundary_edge_count = 0;
  std::size_t non_manifold_edge_count = 0;
  std::size_t non_manifold_vertex_count =
      0;                                   // joining several umbrellas (edges with many triangles join them)
  std::size_t misoriented_edge_count = 0;  // two triangles that run the same way along it
  bool is_manifold() const { return non_manifold_edge_count == 0 && non_manifold_vertex_count == 0; }
  bool is_oriented_manifold() const { return is_manifold() && misoriented_edge_count == 0; }
  long total_genus() const;  // over the components that have one
};

/// Any indexed mesh, manifold or not; equal positions with different indices are different vertices. Every
/// index must be in range and no triangle may repeat one. O(n log n), about 60 bytes per triangle.
Topology analyze_topology(const std::vector<Vec3>& positions, const std::vector<Triangle>& triangles);
Topology analyze_topology(const TriangleMesh& mesh);

}  // namespace nmc

#endif  // NMC_ENCODER_CONDITION_TOPOLOGY_H_
