// SPDX-License-Identifier: Apache-2.0
#include "encoder/sphere/sphere_surface.h"

#include <algorithm>
#include <utility>

#include "encoder/sphere/tangent_frame.h"

namespace nmc {

SphereParameterizedSurface::SphereParameterizedSurface(std::shared_ptr<const TriangleMesh> surface,
                                                       std::vector<Vec3> sphere_positions)
    : ParameterizedSurface(surface), index_(sphere_positions, surface->triangles) {}

SurfaceLocation SphereParameterizedSurface::locate(const SurfaceParameter& u) const {
  // The secant triangles of a bijection are star-shaped around the centre: the ray meets them once. No
  // triangle covers a hemisphere, so none comes near the centre.
  SurfacePoint hit = index_.first_hit({0, 0, 0}, to_unit_vector(u), 0, 2);
  if (!hit.found()) hit = index_.closest_point(to_unit_vector(u));
  SurfaceLocation location;
  location.triangle = hit.triangle;
  std::copy(std::begin(hit.barycentric), std::end(hit.barycentric), std::begin(location.barycentric));
  return location;
}

SurfaceParameter SphereParameterizedSurface::parameter(const SurfaceLocation& location) const {
  const Triangle& t = index_.triangles()[location.triangle];
  const std::vector<Vec3>& x = index_.positions();
  return to_parameter(normalized(location.barycentric[0] * x[t[0]] + location.barycentric[1] * x[t[1]] +
                                 location.barycentric[2] * x[t[2]]));
}

bool SphereParameterizedSurface::make_chart(std::uint32_t, std::span<const SurfaceParameter> points,
                                            LocalChart& chart, std::span<ChartPoint> at) const {
  Vec3 sum;
  for (const SurfaceParameter& p : points) sum += to_unit_vector(p);
  chart.face = kNoFace;
  chart.origin = normalized(sum);
  const TangentFrame frame = tangent_frame(chart.origin);
  chart.axis_x = frame.u;
  chart.axis_y = frame.v;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!to_chart(chart, points[i], at[i])) return false;
  return true;
}

bool SphereParameterizedSurface::to_chart(const LocalChart& chart, const SurfaceParameter& u,
                                          ChartPoint& at) const {
  constexpr double kCosineOf80Degrees = 0.17364817766693033;
  const Vec3 x = to_unit_vector(u);
  const double height = dot(x, chart.origin);
  if (height < kCosineOf80Degrees) return false;
  at = from_cartesian(dot(x, chart.axis_x) / height, dot(x, chart.axis_y) / height);
  return true;
}

bool SphereParameterizedSurface::to_chart(const LocalChart& chart, const SurfaceLocation& location,
                                          ChartPoint& at) const {
  return to_chart(chart, parameter(location), at);
}

SurfaceParameter SphereParameterizedSurface::from_chart(const LocalChart& chart, const ChartPoint& at) const {
  const auto [x, y] = to_cartesian(at);
  return to_parameter(normalized(chart.origin + x * chart.axis_x + y * chart.axis_y));
}

}  // namespace nmc
