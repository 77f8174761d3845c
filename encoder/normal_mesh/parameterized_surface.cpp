// SPDX-License-Identifier: Apache-2.0
#include "encoder/normal_mesh/parameterized_surface.h"

#include <utility>

namespace nmc {

ParameterizedSurface::ParameterizedSurface(std::shared_ptr<const TriangleMesh> surface)
    : surface_(std::move(surface)), vertex_normals_(vertex_normals(*surface_)) {}

std::vector<CurveKnot> ParameterizedSurface::curve(std::uint32_t, int) const { return {}; }
SurfaceParameter ParameterizedSurface::on_base_edge(std::uint32_t, int, double) const { return {}; }
double ParameterizedSurface::share_of_base_edge(std::uint32_t, int, const SurfaceParameter&) const {
  return 0;
}

Vec3 ParameterizedSurface::position(const SurfaceLocation& location) const {
  const Triangle& t = surface_->triangles[location.triangle];
  return location.barycentric[0] * surface_->positions[t[0]] +
         location.barycentric[1] * surface_->positions[t[1]] +
         location.barycentric[2] * surface_->positions[t[2]];
}

Vec3 ParameterizedSurface::face_normal(std::uint32_t triangle) const {
  const Triangle& t = surface_->triangles[triangle];
  const Vec3& a = surface_->positions[t[0]];
  return normalized(cross(surface_->positions[t[1]] - a, surface_->positions[t[2]] - a));
}

Vec3 ParameterizedSurface::smooth_normal(const SurfaceLocation& location) const {
  // At an edge of 64 degrees the vertex normal leaves both faces' normals by 32 degrees.
  constexpr double kCosineOfSharpness = 0.85;
  const Vec3 flat = face_normal(location.triangle);
  const Triangle& t = surface_->triangles[location.triangle];
  Vec3 sum;
  for (int k = 0; k < 3; ++k) {
    const Vec3& n = vertex_normals_[t[k]];
    sum += location.barycentric[k] * (dot(n, flat) < kCosineOfSharpness ? flat : n);
  }
  return normalized(sum, flat);
}

DomainParameterizedSurface::DomainParameterizedSurface(const Parameterization& parameterization)
    : ParameterizedSurface(parameterization.surface),
      parameterization_(&parameterization),
      atlas_(parameterization) {}

SurfaceLocation DomainParameterizedSurface::locate(const SurfaceParameter& u) const {
  return atlas_.locate(to_domain_point(u));
}

SurfaceParameter DomainParameterizedSurface::parameter(const SurfaceLocation& location) const {
  return to_parameter(atlas_.domain_point(location));
}

bool DomainParameterizedSurface::make_chart(std::uint32_t base_face, std::span<const SurfaceParameter> points,
                                            LocalChart& chart, std::span<ChartPoint> at) const {
  chart.face = base_face;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!to_chart(chart, points[i], at[i])) return false;
  return true;
}

bool DomainParameterizedSurface::to_chart(const LocalChart& chart, const SurfaceParameter& u,
                                          ChartPoint& at) const {
  const auto p = parameterization_->domain.unfold(to_domain_point(u), chart.face);
  if (!p) return false;
  at = *p;
  return true;
}

bool DomainParameterizedSurface::to_chart(const LocalChart& chart, const SurfaceLocation& location,
                                          ChartPoint& at) const {
  const auto p = atlas_.chart_point(location, chart.face);
  if (!p) return false;
  at = *p;
  return true;
}

SurfaceParameter DomainParameterizedSurface::from_chart(const LocalChart& chart, const ChartPoint& at) const {
  return to_parameter(parameterization_->domain.normalize(chart.face, at));
}

std::vector<CurveKnot> DomainParameterizedSurface::curve(std::uint32_t f, int k) const {
  return atlas_.curve(f, k);
}

SurfaceParameter DomainParameterizedSurface::on_base_edge(std::uint32_t f, int k, double share) const {
  const ChartPoint on_grid = snap_to_grid({share, 0});
  const double s = on_grid.u, r = 1 - s;  // exact on the grid
  return k == 0   ? SurfaceParameter{f, r, s, 0}
         : k == 1 ? SurfaceParameter{f, 0, r, 0}
                  : SurfaceParameter{f, s, 0, 0};
}

double DomainParameterizedSurface::share_of_base_edge(std::uint32_t f, int k,
                                                      const SurfaceParameter& u) const {
  const auto at = parameterization_->domain.unfold(to_domain_point(u), f);
  if (!at) return 0.5;
  return k == 0 ? at->v : k == 1 ? 1 - at->v : at->u;
}

ParameterizedBase base_of(const Parameterization& parameterization) {
  const BaseDomain& domain = parameterization.domain;
  ParameterizedBase base;
  base.faces = domain.faces();
  base.positions = parameterization.base_positions;
  for (std::uint32_t v = 0; v < domain.vertex_count(); ++v)
    base.parameters.push_back(to_parameter(domain.cone_point(v)));

  bool has_creases = false;
  for (std::uint32_t f = 0; f < base.faces.size() && !has_creases; ++f)
    for (int k = 0; k < 3; ++k) has_creases = has_creases || domain.edge_tag(f, k) == EdgeTag::kCrease;
  if (!has_creases) return base;
  const SubdivisionHierarchy level_zero(base.faces, static_cast<std::uint32_t>(base.positions.size()), 0);
  const LevelTopology& topology = level_zero.level(0);
  base.creases.assign(topology.edge_count, 0);
  for (std::uint32_t f = 0; f < base.faces.size(); ++f) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      if (domain.edge_tag(f, static_cast<int>(k)) == EdgeTag::kCrease)
        base.creases[topology.face_edges[3 * f + k]] = 1;
    }
  }
  return base;
}

}  // namespace nmc
