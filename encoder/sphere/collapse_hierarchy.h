// SPDX-License-Identifier: Apache-2.0
// Half-edge collapses of a closed genus-0 surface, down to a tetrahedron and back up again.
//
// Based on: M. Garland, P. Heckbert, "Surface Simplification Using Quadric Error Metrics", SIGGRAPH 1997;
// H. Hoppe, "Progressive Meshes", SIGGRAPH 1996 (the reversible sequence). Half-edges, not edges: the
// vertices of every coarser mesh are vertices of the input.
#ifndef NMC_ENCODER_SPHERE_COLLAPSE_HIERARCHY_H_
#define NMC_ENCODER_SPHERE_COLLAPSE_HIERARCHY_H_

#include <cstdint>
#include <vector>

#include "encoder/core/triangle_mesh.h"

namespace nmc {

struct CollapseHierarchyOptions {
  /// Weight of |edge|^4 against the quadric error, both in units of the bounding-box diagonal. Large values
  /// keep the vertices evenly spread (a good multigrid hierarchy), small ones follow the shape (a good
  /// simplification).
  double edge_length_weight = 1e-2;
  /// Collapses to a vertex of more neighbors are put off as long as others exist.
  int preferred_maximum_valence = 12;
  /// Unit vectors of the vertices, or null. With them every triangle stays counter-clockwise on the sphere,
  /// and no sliver there, as long as that is possible. Must outlive the hierarchy.
  const std::vector<Vec3>* sphere_positions = nullptr;
};

/// A compact copy of the current mesh.
struct HierarchyLevel {
  std::vector<std::uint32_t> vertices;  // input index of each vertex, ascending
  std::vector<Triangle> triangles;      // indices into `vertices`
};

class CollapseHierarchy {
 public:
  /// Throws nmc::Error (kUnsupported) unless the mesh is one closed, oriented, edge-manifold component of
  /// genus 0 whose vertices are all used, and (kInvalidInput) where coordinates are not finite. O(n).
  CollapseHierarchy(const std::vector<Vec3>& positions, const std::vector<Triangle>& triangles,
                    const CollapseHierarchyOptions& options = {});

  /// Collapses until `vertex_count` (at least 4) vertices are left. O(n log n), about 4 us per vertex.
  void collapse_to(std::uint32_t vertex_count);

  /// Undoes the last collapse and returns the vertex that it brings back. O(its valence).
  std::uint32_t undo();

  std::uint32_t live_count() const { return live_count_; }
  bool can_undo() const { return !collapses_.empty(); }
  bool is_live(std::uint32_t vertex) const { return half_edge_[vertex] != kDead; }

  /// The neighbors of a live vertex, counter-clockwise seen from outside.
  void link(std::uint32_t vertex, std::vector<std::uint32_t>& neighbors) const;

  HierarchyLevel level() const;

 private:
  static constexpr std::uint32_t kDead = 0xffffffffu;

  struct Quadric {
    double a[10] = {};
    Quadric& operator+=(const Quadric& other);
    double value(const Vec3& p) const;
  };
  struct Candidate {
    double cost;
    std::uint32_t from, to, stamp;
    bool operator<(const Candidate& other) const;
  };

  // Half-edge 3 f + k runs from corner k of face f to corner k + 1.
  static std::uint32_t next(std::uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
  static std::uint32_t previous(std::uint32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }
  std::uint32_t target(std::uint32_t h) const { return origin_[next(h)]; }
  // The next half-edge with the same origin, counter-clockwise.
  std::uint32_t rotate(std::uint32_t h) const { return opposite_[previous(h)]; }

  void connect(const std::vector<Triangle>& triangles);
  double cost(std::uint32_t from, std::uint32_t to) const;
  std::uint32_t valence(std::uint32_t vertex) const;
  bool is_allowed(std::uint32_t half_edge, bool check_normals) const;
  void push_best(std::uint32_t vertex, bool only_allowed, bool check_normals);
  void collapse(std::uint32_t half_edge);
  std::uint32_t find_half_edge(std::uint32_t from, std::uint32_t to) const;

  CollapseHierarchyOptions options_;
  std::vector<Vec3> positions_;  // scaled to a bounding box of unit diagonal
  std::vector<std::uint32_t> origin_, opposite_;
  std::vector<std::uint32_t> half_edge_;  // one leaving each vertex; kDead after its collapse
  std::vector<bool> face_is_dead_;
  std::vector<Quadric> quadrics_;
  std::vector<std::uint32_t> stamps_;
  std::vector<Candidate> heap_;
  std::vector<std::uint32_t> collapses_;  // the half-edge of each, whose dead faces keep what undo() needs
  mutable std::vector<std::uint32_t> marks_;
  mutable std::uint32_t mark_ = 0;
  std::uint32_t live_count_ = 0;
};

}  // namespace nmc

#endif  // NMC_ENCODER_SPHERE_COLLAPSE_HIERARCHY_H_
