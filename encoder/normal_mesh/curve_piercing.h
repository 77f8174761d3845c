// SPDX-License-Identifier: Apache-2.0
// Odd vertices on boundaries and creases: a curve normal mesh inside the surface normal mesh.
//
// The vertex stays on the input's curve: it is the point where the curve pierces the plane through the
// prediction that is orthogonal to the edge, so two scalars (normal and across) describe it.
//
// Based on: Friedel, sections 2.4.3 (boundaries on each level) and 2.4.4, Figure 2.9 (curves in space).
#ifndef NMC_ENCODER_NORMAL_MESH_CURVE_PIERCING_H_
#define NMC_ENCODER_NORMAL_MESH_CURVE_PIERCING_H_

#include <cstdint>
#include <vector>

#include "encoder/core/subdivision_hierarchy.h"
#include "encoder/normal_mesh/parameterized_surface.h"

namespace nmc {

/// The input polyline under one base edge, by share of the edge.
class BaseCurve {
 public:
  BaseCurve() = default;
  /// The image of base edge `edge` (of level 0 of the hierarchy).
  BaseCurve(const ParameterizedSurface& map, const LevelTopology& base, std::uint32_t edge);

  double share(const ParameterizedSurface& map, const SurfaceParameter& u) const {
    return map.share_of_base_edge(face_, corner_, u);
  }
  SurfaceParameter parameter(const ParameterizedSurface& map, double share) const {
    return map.on_base_edge(face_, corner_, share);
  }
  /// O(log knots).
  Vec3 point(double share) const;

  struct Crossing {
    bool found = false;
    double share = 0;
    Vec3 position;
  };
  /// The crossing with the plane through `origin` with normal `direction`, between shares `low` and `high`,
  /// that is nearest to their mean among those that `accept` (called with a Crossing) does not refuse.
  /// O(knots between).
  template <class Accept>
  Crossing cross_plane(const Vec3& origin, const Vec3& direction, double low, double high,
                       const Accept& accept) const;

 private:
  std::size_t segment_of(double share) const;

  std::uint32_t face_ = kNoFace;
  int corner_ = 0;
  std::vector<double> shares_;
  std::vector<Vec3> points_;
};

/// One per base edge; empty for those that are not curves. Empty as a whole where the mesh has no curves.
std::vector<BaseCurve> base_curves(const ParameterizedSurface& map, const LevelTopology& base);

template <class Accept>
BaseCurve::Crossing BaseCurve::cross_plane(const Vec3& origin, const Vec3& direction, double low, double high,
                                           const Accept& accept) const {
  Crossing best;
  const double middle = 0.5 * (low + high);
  double s0 = low;
  Vec3 x0 = point(low);
  double h0 = dot(x0 - origin, direction);
  for (std::size_t i = segment_of(low); s0 < high; ++i) {
    const bool last = i + 1 >= shares_.size() || shares_[i + 1] >= high;
    const double s1 = last ? high : shares_[i + 1];
    const Vec3 x1 = last ? point(high) : points_[i + 1];
    const double h1 = dot(x1 - origin, direction);
    if ((h0 <= 0) != (h1 <= 0)) {
      const double t = h0 / (h0 - h1);
      const Crossing crossing{true, s0 + t * (s1 - s0), x0 + t * (x1 - x0)};
      const auto deviation = [middle](double s) { return s < middle ? middle - s : s - middle; };
      if ((!best.found || deviation(crossing.share) < deviation(best.share)) && accept(crossing))
        best = crossing;
    }
    if (last) break;
    s0 = s1;
    x0 = x1;
    h0 = h1;
  }
  return best;
}

}  // namespace nmc

#endif  // NMC_ENCODER_NORMAL_MESH_CURVE_PIERCING_H_
