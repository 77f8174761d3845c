// SPDX-License-Identifier: Apache-2.0
// A parameterized input surface as the normal mesh sees it: R(u), its inverse, and flat pictures of
// neighbourhoods.
//
// The construction of a normal mesh does not care whether parameters live on glued triangles or on a sphere.
// It asks for points of the surface, for the parameter of a point, and for a local chart in which midpoints,
// distances and orientations can be judged (thesis section 2.3: "local flattening of the input domain").
#ifndef NMC_ENCODER_NORMAL_MESH_PARAMETERIZED_SURFACE_H_
#define NMC_ENCODER_NORMAL_MESH_PARAMETERIZED_SURFACE_H_

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "encoder/core/subdivision_hierarchy.h"
#include "encoder/core/triangle_mesh.h"
#include "encoder/domain/base_domain.h"
#include "encoder/domain/parameterization.h"
#include "encoder/normal_mesh/surface_atlas.h"

namespace nmc {

/// A parameter value. On a base domain: a face and its lattice coordinates x, y (z unused). On the sphere: a
/// unit vector (face unused).
struct SurfaceParameter {
  std::uint32_t face = kNoFace;
  double x = 0, y = 0, z = 0;
};
inline SurfaceParameter to_parameter(const DomainPoint& p) { return {p.face, p.at.u, p.at.v, 0}; }
inline DomainPoint to_domain_point(const SurfaceParameter& p) { return {p.face, {p.x, p.y}}; }

/// A flat picture of a neighbourhood of the domain. What the members mean is the map's own business.
struct LocalChart {
  std::uint32_t face = kNoFace;
  Vec3 origin, axis_x, axis_y;
};

/// Immutable; all queries may run concurrently.
class ParameterizedSurface {
 public:
  virtual ~ParameterizedSurface() = default;
  ParameterizedSurface(const ParameterizedSurface&) = delete;
  ParameterizedSurface& operator=(const ParameterizedSurface&) = delete;

  /// The surface point R(u).
  virtual SurfaceLocation locate(const SurfaceParameter& u) const = 0;
  /// The parameter of a surface point.
  virtual SurfaceParameter parameter(const SurfaceLocation& location) const = 0;

  /// Lays out `points` (two or three, the ends of an edge or the corners of a face) in one chart. `base_face`
  /// is the ancestor of the edge or face in the base mesh: on a base domain its chart is taken, from which
  /// every point that belongs to a descendant is at most a step or two away. (The shortest way between two
  /// *points* may lead round the wrong side of a cone of few faces.) False where the points are too far
  /// apart.
  virtual bool make_chart(std::uint32_t base_face, std::span<const SurfaceParameter> points,
                          LocalChart& chart, std::span<ChartPoint> at) const = 0;
  /// Coordinates in `chart`; false where the point is too far away.
  virtual bool to_chart(const LocalChart& chart, const SurfaceParameter& u, ChartPoint& at) const = 0;
  virtual bool to_chart(const LocalChart& chart, const SurfaceLocation& location, ChartPoint& at) const = 0;
  virtual SurfaceParameter from_chart(const LocalChart& chart, const ChartPoint& at) const = 0;

  /// The input polyline that is the image of edge k of base face f, where that edge is a boundary or a
  /// crease.
  virtual std::vector<CurveKnot> curve(std::uint32_t f, int k) const;
  /// The parameter that lies at `share` of the way from corner k+1 to corner k+2 of base face f, and back.
  virtual SurfaceParameter on_base_edge(std::uint32_t f, int k, double share) const;
  virtual double share_of_base_edge(std::uint32_t f, int k, const SurfaceParameter& u) const;

  const TriangleMesh& surface() const { return *surface_; }
  Vec3 position(const SurfaceLocation& location) const;
  /// Unit normal of the triangle.
  Vec3 face_normal(std::uint32_t triangle) const;
  /// Unit normal interpolated over the triangle, but not across edges sharper than about 60 degrees.
  Vec3 smooth_normal(const SurfaceLocation& location) const;

 protected:
  explicit ParameterizedSurface(std::shared_ptr<const TriangleMesh> surface);

 private:
  std::shared_ptr<const TriangleMesh> surface_;
  std::vector<Vec3> vertex_normals_;
};

/// The base mesh of a normal mesh together with the parameters of its vertices: S^0 and p^0 of the thesis.
struct ParameterizedBase {
  std::vector<Triangle> faces;
  std::vector<Vec3> positions;
  std::vector<SurfaceParameter> parameters;
  std::vector<std::uint8_t> creases;  // one byte per edge of level 0 as libnmc numbers them; empty: none
};

/// On a base domain. Refers to the parameterization, which must outlive it.
class DomainParameterizedSurface : public ParameterizedSurface {
 public:
  explicit DomainParameterizedSurface(const Parameterization& parameterization);

  SurfaceLocation locate(const SurfaceParameter& u) const override;
  SurfaceParameter parameter(const SurfaceLocation& location) const override;
  bool make_chart(std::uint32_t base_face, std::span<const SurfaceParameter> points, LocalChart& chart,
                  std::span<ChartPoint> at) const override;
  bool to_chart(const LocalChart& chart, const SurfaceParameter& u, ChartPoint& at) const override;
  bool to_chart(const LocalChart& chart, const SurfaceLocation& location, ChartPoint& at) const override;
  SurfaceParameter from_chart(const LocalChart& chart, const ChartPoint& at) const override;
  std::vector<CurveKnot> curve(std::uint32_t f, int k) const override;
  SurfaceParameter on_base_edge(std::uint32_t f, int k, double share) const override;
  double share_of_base_edge(std::uint32_t f, int k, const SurfaceParameter& u) const override;

  const SurfaceAtlas& atlas() const { return atlas_; }

 private:
  const Parameterization* parameterization_;
  SurfaceAtlas atlas_;
};

/// Base vertices at their surface vertices, parameters at the cones.
ParameterizedBase base_of(const Parameterization& parameterization);

}  // namespace nmc

#endif  // NMC_ENCODER_NORMAL_MESH_PARAMETERIZED_SURFACE_H_
