// SPDX-License-Identifier: Apache-2.0
// Rays and closest points on a triangle mesh. Embree proposes triangles, double precision decides.
//
// Embree works in single precision and its kernels differ between processors, so its answer is only a set of
// candidate triangles: every candidate is recomputed here in double, and ties go to the lowest triangle
// index.
#ifndef NMC_ENCODER_SPATIAL_SURFACE_INDEX_H_
#define NMC_ENCODER_SPATIAL_SURFACE_INDEX_H_

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "encoder/core/triangle_mesh.h"

namespace nmc {

inline constexpr std::uint32_t kNoTriangle = 0xffffffffu;

/// Where a ray or a closest-point query meets a triangle.
struct SurfacePoint {
  std::uint32_t triangle = kNoTriangle;  // kNoTriangle: nothing found
  double barycentric[3] = {0, 0, 0};     // >= 0, sum 1, of the triangle's corners in order
  Vec3 position;                         // the point itself
  double t = 0;                          // rays: parameter along the direction; closest point: distance
  bool found() const { return triangle != kNoTriangle; }
};

/// Immutable after construction; all queries may run concurrently. Keeps its own copy of the geometry.
/// Triangles with a corner that is not finite are never found. Memory: about 100 bytes per triangle.
/// Construction O(n log n).
class SurfaceIndex {
 public:
  explicit SurfaceIndex(const TriangleMesh& mesh);
  SurfaceIndex(const std::vector<Vec3>& positions, const std::vector<Triangle>& triangles);
  ~SurfaceIndex();
  SurfaceIndex(SurfaceIndex&&) noexcept;
  SurfaceIndex& operator=(SurfaceIndex&&) noexcept;

  /// All intersections of origin + t * direction with t in [t_minimum, t_maximum], sorted by t, at most
  /// `maximum_count`; hits on a shared edge or vertex are merged to one (lowest triangle index). `direction`
  /// need not be of unit length and t is in units of it. Both sides of a triangle count.
  void all_hits(const Vec3& origin, const Vec3& direction, double t_minimum, double t_maximum,
                int maximum_count, std::vector<SurfacePoint>& hits) const;

  /// The nearest of them.
  SurfacePoint first_hit(const Vec3& origin, const Vec3& direction, double t_minimum, double t_maximum) const;

  /// The exact closest point (double precision) within `maximum_distance`; not found where none is nearer.
  SurfacePoint closest_point(const Vec3& point,
                             double maximum_distance = std::numeric_limits<double>::infinity()) const;

  /// Whether any point of the mesh is within `distance`: the same answer as closest_point(point, distance).found(),
  /// but the first triangle near enough ends the search.
  bool is_within(const Vec3& point, double distance) const;

  const std::vector<Vec3>& positions() const;
  const std::vector<Triangle>& triangles() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace nmc

#endif  // NMC_ENCODER_SPATIAL_SURFACE_INDEX_H_
