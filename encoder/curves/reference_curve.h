// SPDX-License-Identifier: Apache-2.0
// The curve that a normal curve approximates: a polyline with a parameter, in the plane or in space.
#ifndef NMC_ENCODER_CURVES_REFERENCE_CURVE_H_
#define NMC_ENCODER_CURVES_REFERENCE_CURVE_H_

#include <cstddef>
#include <vector>

#include "libnmc/common/vec3.h"

namespace nmc {

/// Immutable. The parameter is the arc length over the total length: 0 at the first point, 1 at the last one,
/// or back at the first one of a closed curve. Closed curves accept any real parameter and repeat with
/// period 1.
class ReferenceCurve {
 public:
  /// Planar curves have z = 0 everywhere. A closed curve does not repeat its first point. Throws nmc::Error
  /// (kInvalidInput) for fewer than 2 points (closed: 3), or without length.
  ReferenceCurve(std::vector<Vec3> points, bool is_closed);

  bool is_closed() const { return is_closed_; }
  double length() const { return length_; }
  const std::vector<Vec3>& points() const { return points_; }
  /// The parameter of each point, ascending, and 1 at the end of a closed curve.
  const std::vector<double>& knots() const { return knots_; }

  /// R(u). O(log n).
  Vec3 operator()(double u) const;

  /// The parameters between `from` and `to` (from < to <= from + 1) where R crosses the hyperplane through
  /// `point` with normal `tangent`, ascending; in the plane that is the normal line of a segment with this
  /// tangent. O(log n + points between).
  void crossings(const Vec3& point, const Vec3& tangent, double from, double to,
                 std::vector<double>& at) const;

  /// The parameters of all points strictly between `from` and `to`, ascending.
  void knots_between(double from, double to, std::vector<double>& at) const;

  /// The nearest point of the whole curve. O(n).
  double distance_to(const Vec3& point) const;

 private:
  std::size_t segment_of(double u_in_period) const;

  std::vector<Vec3> points_;
  std::vector<double> knots_;
  double length_ = 0;
  bool is_closed_;
};

}  // namespace nmc

#endif  // NMC_ENCODER_CURVES_REFERENCE_CURVE_H_
