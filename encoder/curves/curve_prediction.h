// SPDX-License-Identifier: Apache-2.0
// Where the new vertex of a segment is expected, and the normal directions there.
//
// Based on: I. Daubechies, O. Runborg, W. Sweldens, "Normal Multiresolution Approximation of Curves", Constr.
// Approx. 20, 2004; I. Friedel, thesis, sections 2.2 and 2.4.4.
#ifndef NMC_ENCODER_CURVES_CURVE_PREDICTION_H_
#define NMC_ENCODER_CURVES_CURVE_PREDICTION_H_

#include <array>
#include <cstddef>
#include <vector>

#include "libnmc/common/vec3.h"

namespace nmc {

enum class CurvePredictor {
  kMidpoint,   // 1/2 [1, 1]
  kFourPoint,  // 1/16 [-1, 9, 9, -1]
  kSixPoint,   // 1/256 [3, -25, 150, 150, -25, 3]
};

/// The predicted middle of segment i, from vertex i to i + 1 (closed curves: cyclic). Near the ends of an
/// open curve the shorter stencils take over.
Vec3 predict_position(const std::vector<Vec3>& vertices, std::size_t segment, bool is_closed,
                      CurvePredictor predictor);

/// Unit tangent and normals. In the plane normal[0] is the tangent turned left and normal[1] is zero; in
/// space the two normals follow from the tangent alone by Gram-Schmidt against the coordinate axis that it
/// leaves most.
struct CurveFrame {
  Vec3 tangent;
  std::array<Vec3, 2> normal;
};
CurveFrame curve_frame(const Vec3& direction, int dimension);

}  // namespace nmc

#endif  // NMC_ENCODER_CURVES_CURVE_PREDICTION_H_
