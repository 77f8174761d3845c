// SPDX-License-Identifier: Apache-2.0
// Normal curves: polylines refined level by level by scalars along predicted normals.
//
// Based on: I. Friedel, thesis, sections 2.2 (interpolating), 3.4 (variational), 2.4.4 (curves in space)
// and 3.7.1 (sombrero functions).
#ifndef NMC_ENCODER_CURVES_NORMAL_CURVE_H_
#define NMC_ENCODER_CURVES_NORMAL_CURVE_H_

#include <array>
#include <cstdint>
#include <vector>

#include "encoder/curves/curve_prediction.h"
#include "encoder/curves/reference_curve.h"

namespace nmc {

enum class CurveFit {
  kInterpolating,  // new vertices lie on the reference (INC)
  kVariational,    // all vertices slide along their normal lines to the least squares solution of the level
                   // (VNC)
  kSombrero,   // the details are multiples of 1/4 [-1, 2, -1] around new vertices: the thesis's experiment,
               // which does not converge
  kVectorial,  // least squares without the restriction to normal lines (VVC)
};

struct NormalCurveOptions {
  int dimension = 2;  // 2: one scalar per vertex; 3: two
  CurvePredictor predictor = CurvePredictor::kFourPoint;
  CurveFit fit = CurveFit::kInterpolating;
  /// How far a crossing may lie from the middle of the segment's parameter interval, relative to half of it:
  /// 1 accepts everything between the ends, 0.43 keeps the middle.
  double aperture = 0.43;
  int level_count = 5;
};

/// What the code holds for one vertex on one level.
struct CurveDetail {
  std::array<double, 2> normal{};  // along the vertex's own normals; the second one only in space
  double tangential = 0;           // new vertices only; zero where normal
};

struct NormalCurveLevel {
  std::vector<Vec3> positions;
  std::vector<double>
      parameters;  // p^l: where on the reference each vertex belongs; never changed afterwards
  std::vector<CurveFrame> frames;       // of each vertex since its insertion: its normal line
  std::vector<CurveDetail> details;     // of this level: all vertices (variational), or the odd ones only
  std::vector<std::uint8_t> is_normal;  // 0 where a vectorial detail was needed
  std::size_t non_normal_count = 0;     // of the vertices inserted on this level
};

struct NormalCurve {
  bool is_closed = true;
  NormalCurveOptions options;
  std::vector<NormalCurveLevel> levels;  // 0 is the base
};

/// `base_parameters` ascend, span less than one period, and name the base vertices R(u); an open curve's are
/// 0 ... 1. Even vertices of a level are the vertices of the coarser one, at twice their index.
NormalCurve build_normal_curve(const ReferenceCurve& reference, const std::vector<double>& base_parameters,
                               const NormalCurveOptions& options);

/// The finest polyline from the base positions and the details alone: what a decoder does. Equals
/// curve.levels.back().positions up to rounding.
std::vector<Vec3> reconstruct(const NormalCurve& curve);

/// Root of the mean squared distance of R(p(t)) and S(t) over the reference's length: the norm that is
/// minimized.
double parametric_error(const ReferenceCurve& reference, const NormalCurveLevel& level, bool is_closed);

/// Root of the mean squared distance between the curves as sets, the larger of the two directions. A polyline
/// that leaves out a detail is near the reference, but the reference is not near it. O(product of the numbers
/// of points).
double geometric_error(const ReferenceCurve& reference, const NormalCurveLevel& level, bool is_closed);

}  // namespace nmc

#endif  // NMC_ENCODER_CURVES_NORMAL_CURVE_H_
