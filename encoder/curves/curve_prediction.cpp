// SPDX-License-Identifier: Apache-2.0
#include "encoder/curves/curve_prediction.h"

#include <cmath>

namespace nmc {

Vec3 predict_position(const std::vector<Vec3>& vertices, std::size_t segment, bool is_closed,
                      CurvePredictor predictor) {
  const std::ptrdiff_t count = static_cast<std::ptrdiff_t>(vertices.size());
  const std::ptrdiff_t i = static_cast<std::ptrdiff_t>(segment);
  const auto has = [&](std::ptrdiff_t k) { return is_closed || (k >= 0 && k < count); };
  const auto at = [&](std::ptrdiff_t k) {
    return vertices[static_cast<std::size_t>(((k % count) + count) % count)];
  };
  if (predictor == CurvePredictor::kSixPoint && !(has(i - 2) && has(i + 3)))
    predictor = CurvePredictor::kFourPoint;
  if (predictor == CurvePredictor::kFourPoint && !(has(i - 1) && has(i + 2)))
    predictor = CurvePredictor::kMidpoint;
  switch (predictor) {
    case CurvePredictor::kSixPoint:
      return (150 * (at(i) + at(i + 1)) - 25 * (at(i - 1) + at(i + 2)) + 3 * (at(i - 2) + at(i + 3))) / 256;
    case CurvePredictor::kFourPoint:
      return (9 * (at(i) + at(i + 1)) - (at(i - 1) + at(i + 2))) / 16;
    case CurvePredictor::kMidpoint:
      break;
  }
  return 0.5 * (at(i) + at(i + 1));
}

CurveFrame curve_frame(const Vec3& direction, int dimension) {
  CurveFrame frame;
  frame.tangent = normalized(direction, {1, 0, 0});
  if (dimension == 2) {
    frame.normal[0] = {-frame.tangent.y, frame.tangent.x, 0};
    return frame;
  }
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (std::abs(frame.tangent[k]) < std::abs(frame.tangent[axis])) axis = k;
  Vec3 unit;
  unit[axis] = 1;
  frame.normal[0] = normalized(unit - dot(unit, frame.tangent) * frame.tangent);
  frame.normal[1] = cross(frame.tangent, frame.normal[0]);
  return frame;
}

}  // namespace nmc
