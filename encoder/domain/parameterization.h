// SPDX-License-Identifier: Apache-2.0
// A map of a surface onto a base domain: what the domain room hands to the normal mesh and to the fit.
#ifndef NMC_ENCODER_DOMAIN_PARAMETERIZATION_H_
#define NMC_ENCODER_DOMAIN_PARAMETERIZATION_H_

#include <cstdint>
#include <memory>
#include <vector>

#include "encoder/core/triangle_mesh.h"
#include "encoder/domain/base_domain.h"

namespace nmc {

/// How a surface triangle lies in the domain: maps[k] takes the coordinates of its corner k (in the chart of
/// vertex_points[corner].face) to the chart of `face`.
struct TriangleChart {
  std::uint32_t face = kNoFace;
  std::array<ChartMap, 3> maps;
};

/// A piecewise linear map: a triangle of `surface` goes to the straight triangle of its corners'
/// `vertex_points`, unfolded into the chart that `triangle_charts` names. These charts are part of the map:
/// around a cone two points can be joined by more than one straight triangle.
///
/// `surface` is the input surface, point for point, with a few of its edges and triangles split where the map
/// needs a vertex: its first `input_vertex_count` vertices are the input's in the same order. Build spatial
/// indices and atlases on `surface`, not on the input mesh.
///
/// A surface vertex sits at every base vertex (cone), and input boundaries and tagged creases run along base
/// edges.
struct Parameterization {
  std::shared_ptr<const TriangleMesh> surface;
  std::size_t input_vertex_count = 0;
  BaseDomain domain;
  std::vector<DomainPoint> vertex_points;      // one per vertex of `surface`
  std::vector<TriangleChart> triangle_charts;  // one per triangle of `surface`
  std::vector<std::uint32_t> base_vertex_ids;  // the surface vertex at each base vertex
  std::vector<Vec3> base_positions;            // surface->positions[base_vertex_ids[i]]

  /// The corners of a surface triangle in the chart of triangle_charts[triangle].face, counter-clockwise
  /// where the map is not folded. Exact.
  ChartTriangle unfold(std::uint32_t triangle) const {
    const TriangleChart& chart = triangle_charts[triangle];
    ChartTriangle result{chart.face, {}};
    for (int k = 0; k < 3; ++k)
      result.corners[k] = chart.maps[k](vertex_points[surface->triangles[triangle][k]].at);
    return result;
  }

  /// The domain point of a surface point given by barycentric coordinates of a triangle. Walks from a corner
  /// of the triangle, so a cone beside it is passed on the right side.
  DomainPoint domain_point(std::uint32_t triangle, const double barycentric[3]) const {
    const ChartTriangle corners = unfold(triangle);
    ChartPoint at;
    for (int k = 0; k < 3; ++k) at = at + barycentric[k] * corners.corners[k];
    // The chart is that of a corner which is no cone; where all are, the triangle is the base face itself.
    ChartPoint start{1.0 / 3, 1.0 / 3};
    for (int k = 0; k < 3; ++k) {
      const DomainPoint& corner = vertex_points[surface->triangles[triangle][k]];
      if (barycentric[k] == 1) return corner;
      if (corner.face == corners.face && corner.at == corners.corners[k] &&
          domain.cone_at(corner) == kNoVertex)
        start = corner.at;
    }
    return domain.walk(corners.face, start, at, nullptr);
  }
};

}  // namespace nmc

#endif  // NMC_ENCODER_DOMAIN_PARAMETERIZATION_H_
