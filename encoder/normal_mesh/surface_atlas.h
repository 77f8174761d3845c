// SPDX-License-Identifier: Apache-2.0
// Evaluates a Parameterization in both directions: domain point to surface point, surface point to chart.
//
// Every base face keeps the surface triangles that overlap it, each with the isometry that lays it out in the
// chart of that face, under a small bounding-box tree. The overlap is found by walking: from the chart in
// which the map names the triangle, across every base edge that a stretch of the triangle crosses. So a
// triangle with a corner at a cone enters only the faces on its own side of the cone; unfolding its corners
// one by one into all faces around the cone would lay it out on the wrong side.
//
// Based on: the atlas of Khodakovsky, Litke, Schroeder, "Globally smooth parameterizations with low
// distortion" (2003), section 3; bounding-box tree: Kay, Kajiya, "Ray tracing complex scenes" (1986), split
// at the median.
#ifndef NMC_ENCODER_NORMAL_MESH_SURFACE_ATLAS_H_
#define NMC_ENCODER_NORMAL_MESH_SURFACE_ATLAS_H_

#include <atomic>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "encoder/domain/parameterization.h"

namespace nmc {

/// A point of a triangle of a surface.
struct SurfaceLocation {
  std::uint32_t triangle = kNoFace;
  double barycentric[3] = {0, 0, 0};  // >= 0, sum 1, of the triangle's corners in order
};

/// A surface vertex on a base edge.
struct CurveKnot {
  double share;  // of the base edge, from its first corner (k+1 of the face that was asked) to its second
  std::uint32_t vertex;  // of the surface
};

/// Refers to the parameterization, which must outlive it. Immutable after construction; queries may run
/// concurrently. Memory: about 40 bytes per surface triangle. Construction O(n log n), parallel.
class SurfaceAtlas {
 public:
  explicit SurfaceAtlas(const Parameterization& parameterization);

  const Parameterization& parameterization() const { return *parameterization_; }

  /// The surface point at a domain point. O(log of the triangles per base face). Where rounding or a fold
  /// leaves a point between triangles, the nearest point of the nearest triangle of that face. At a cone its
  /// surface vertex, exactly. Never fails on a face that has triangles; every face has.
  SurfaceLocation locate(const DomainPoint& point) const;

  /// The domain point of a surface point.
  DomainPoint domain_point(const SurfaceLocation& location) const;

  /// The same in the chart of `face`, along the shortest dual path from the triangle's own chart; nullopt
  /// beyond BaseDomain::kUnfoldHops faces.
  std::optional<ChartPoint> chart_point(const SurfaceLocation& location, std::uint32_t face) const;

  /// The surface vertices on edge k of base face f from corner k+1 to corner k+2, both ends included, when
  /// the edge is a boundary or crease; empty otherwise. Their polyline is the image of the edge.
  std::vector<CurveKnot> curve(std::uint32_t f, int k) const;

  /// Surface triangles that the map turns over or flattens to nothing.
  std::size_t folded_triangle_count() const { return folded_triangle_count_; }
  /// Pairs of a base face and a triangle that overlaps it.
  std::size_t entry_count() const { return entries_.size(); }
  /// Queries so far that no triangle contained within 1e-9 of a base edge.
  std::uint64_t nearest_triangle_count() const { return nearest_triangle_count_.load(); }

 private:
  struct Entry {
    std::uint32_t triangle;
    ChartMap map;  // from the triangle's chart to the face's
  };
  /// Children of an inner node: the next node and `link`. A leaf holds `count` entries from `link` on.
  struct Node {
    float low_u, low_v, high_u, high_v;
    std::uint32_t link;
    std::uint32_t count;
  };
  struct Best;

  std::array<ChartPoint, 3> corners(const Entry& entry) const;
  void overlapped_faces(std::uint32_t triangle, std::vector<std::uint32_t>& faces,
                        std::vector<ChartMap>& maps) const;
  void build_tree(std::uint32_t face, std::vector<Node>& nodes);
  void gather_curves();

  const Parameterization* parameterization_;
  std::vector<Entry> entries_;               // by face
  std::vector<std::uint32_t> face_entries_;  // first entry of each face
  std::vector<Node> nodes_;                  // by face, depth first
  std::vector<std::uint32_t> face_nodes_;    // first node of each face
  std::vector<SurfaceLocation> cones_;       // of the base vertices
  std::vector<CurveKnot> knots_;             // by edge slot 3f + k of the lower of the two faces
  std::vector<std::uint32_t> slot_knots_;    // first knot of each slot
  std::size_t folded_triangle_count_ = 0;
  mutable std::atomic<std::uint64_t> nearest_triangle_count_{0};
};

}  // namespace nmc

#endif  // NMC_ENCODER_NORMAL_MESH_SURFACE_ATLAS_H_
