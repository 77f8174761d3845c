// SPDX-License-Identifier: Apache-2.0
// A surface parameterized over the unit sphere, as the normal mesh construction sees it.
//
// The sphere has no cones and no seams: every neighbourhood up to a hemisphere is laid out by gnomonic
// projection from its middle, in which the piecewise linear map of section 4.3.1 of the thesis is exactly
// linear on every triangle and straight lines are the same in all charts.
#ifndef NMC_ENCODER_SPHERE_SPHERE_SURFACE_H_
#define NMC_ENCODER_SPHERE_SPHERE_SURFACE_H_

#include <memory>
#include <vector>

#include "encoder/normal_mesh/parameterized_surface.h"
#include "encoder/spatial/surface_index.h"
#include "encoder/sphere/sphere_parameterization.h"

namespace nmc {

/// Parameters are unit vectors in SurfaceParameter::x, y, z.
inline Vec3 to_unit_vector(const SurfaceParameter& u) { return {u.x, u.y, u.z}; }
inline SurfaceParameter to_parameter(const Vec3& unit_vector) {
  return {kNoFace, unit_vector.x, unit_vector.y, unit_vector.z};
}

/// Immutable; all queries may run concurrently. Memory: about 200 bytes per triangle.
class SphereParameterizedSurface : public ParameterizedSurface {
 public:
  /// `sphere_positions` is a bijection: SphereParameterization::positions, one unit vector per vertex of
  /// `surface`.
  SphereParameterizedSurface(std::shared_ptr<const TriangleMesh> surface, std::vector<Vec3> sphere_positions);

  SurfaceLocation locate(const SurfaceParameter& u) const override;
  SurfaceParameter parameter(const SurfaceLocation& location) const override;
  /// False where a point is more than 80 degrees from the middle of all of them.
  bool make_chart(std::uint32_t base_face, std::span<const SurfaceParameter> points, LocalChart& chart,
                  std::span<ChartPoint> at) const override;
  bool to_chart(const LocalChart& chart, const SurfaceParameter& u, ChartPoint& at) const override;
  bool to_chart(const LocalChart& chart, const SurfaceLocation& location, ChartPoint& at) const override;
  SurfaceParameter from_chart(const LocalChart& chart, const ChartPoint& at) const override;

  const std::vector<Vec3>& sphere_positions() const { return index_.positions(); }

 private:
  SurfaceIndex index_;  // of the secant triangles on the sphere
};

}  // namespace nmc

#endif  // NMC_ENCODER_SPHERE_SPHERE_SURFACE_H_
