// SPDX-License-Identifier: Apache-2.0
#include "encoder/normal_mesh/curve_piercing.h"

#include <algorithm>

namespace nmc {

BaseCurve::BaseCurve(const ParameterizedSurface& map, const LevelTopology& base, std::uint32_t edge) {
  face_ = base.edge_faces[2 * edge];
  while (base.face_edges[3 * face_ + static_cast<std::uint32_t>(corner_)] != edge) ++corner_;
  for (const CurveKnot& knot : map.curve(face_, corner_)) {
    shares_.push_back(knot.share);
    points_.push_back(map.surface().positions[knot.vertex]);
  }
}

std::size_t BaseCurve::segment_of(double share) const {
  const auto after = std::upper_bound(shares_.begin(), shares_.end(), share);
  const auto i = static_cast<std::size_t>(after - shares_.begin());
  return std::clamp<std::size_t>(i, 1, std::max<std::size_t>(1, shares_.size() - 1)) - 1;
}

Vec3 BaseCurve::point(double share) const {
  const std::size_t i = segment_of(share);
  if (i + 1 >= shares_.size()) return points_.empty() ? Vec3{} : points_.back();
  const double length = shares_[i + 1] - shares_[i];
  const double t = length > 0 ? std::clamp((share - shares_[i]) / length, 0.0, 1.0) : 0.0;
  return points_[i] + t * (points_[i + 1] - points_[i]);
}

std::vector<BaseCurve> base_curves(const ParameterizedSurface& map, const LevelTopology& base) {
  std::vector<BaseCurve> curves;
  if (!base.has_curves()) return curves;
  curves.resize(base.edge_count);
  for (std::uint32_t e = 0; e < base.edge_count; ++e)
    if (base.is_curve(e)) curves[e] = BaseCurve(map, base, e);
  return curves;
}

}  // namespace nmc
