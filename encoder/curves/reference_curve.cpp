// SPDX-License-Identifier: Apache-2.0
#include "encoder/curves/reference_curve.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "encoder/core/error.h"

namespace nmc {

ReferenceCurve::ReferenceCurve(std::vector<Vec3> points, bool is_closed)
    : points_(std::move(points)), is_closed_(is_closed) {
  if (points_.size() < (is_closed ? 3u : 2u))
    throw Error(ExitCode::kInvalidInput, "a curve needs at least 2 points, a closed one 3");
  const std::size_t segment_count = points_.size() - (is_closed ? 0 : 1);
  knots_.push_back(0);
  for (std::size_t i = 0; i < segment_count; ++i)
    knots_.push_back(knots_.back() + distance(points_[i], points_[(i + 1) % points_.size()]));
  length_ = knots_.back();
  if (!(length_ > 0) || !std::isfinite(length_))
    throw Error(ExitCode::kInvalidInput, "a curve needs a finite length");
  for (double& knot : knots_) knot /= length_;
  knots_.back() = 1;
}

std::size_t ReferenceCurve::segment_of(double u) const {
  const auto after = std::upper_bound(knots_.begin(), knots_.end(), u);
  const std::size_t index = static_cast<std::size_t>(after - knots_.begin());
  return std::clamp<std::size_t>(index, 1, knots_.size() - 1) - 1;
}

Vec3 ReferenceCurve::operator()(double u) const {
  u = is_closed_ ? u - std::floor(u) : std::clamp(u, 0.0, 1.0);
  const std::size_t i = segment_of(u);
  const double span = knots_[i + 1] - knots_[i];
  const double share = span > 0 ? (u - knots_[i]) / span : 0;
  return (1 - share) * points_[i] + share * points_[(i + 1) % points_.size()];
}

void ReferenceCurve::knots_between(double from, double to, std::vector<double>& at) const {
  at.clear();
  const double period = is_closed_ ? std::floor(from) : 0;
  for (int turn = 0; turn < (is_closed_ ? 3 : 1); ++turn) {
    const double shift = period + turn;
    auto knot = std::upper_bound(knots_.begin(), knots_.end(), from - shift);
    for (; knot != knots_.end() && *knot + shift < to; ++knot) {
      // The last knot of a turn is the first one of the next.
      if (is_closed_ && knot + 1 == knots_.end()) break;
      at.push_back(*knot + shift);
    }
    // The first knot of the next turn is found by that turn's own search, unless it coincides with `from`.
    if (shift + 1 >= to) break;
  }
}

void ReferenceCurve::crossings(const Vec3& point, const Vec3& tangent, double from, double to,
                               std::vector<double>& at) const {
  at.clear();
  std::vector<double> knots;
  knots_between(from, to, knots);
  knots.push_back(to);
  double u = from, height = dot((*this)(from)-point, tangent);
  for (const double next : knots) {
    const double next_height = dot((*this)(next)-point, tangent);
    // Half-open, so that a crossing at a knot is found once.
    if ((height < 0) != (next_height < 0)) {
      const double share = height / (height - next_height);
      at.push_back(u + share * (next - u));
    }
    u = next;
    height = next_height;
  }
}

double ReferenceCurve::distance_to(const Vec3& point) const {
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < knots_.size(); ++i) {
    const Vec3 &a = points_[i], edge = points_[(i + 1) % points_.size()] - a;
    const double square = squared_norm(edge);
    const double share = square > 0 ? std::clamp(dot(point - a, edge) / square, 0.0, 1.0) : 0;
    best = std::min(best, squared_norm(point - a - share * edge));
  }
  return std::sqrt(best);
}

}  // namespace nmc
