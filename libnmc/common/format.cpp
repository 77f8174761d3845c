// SPDX-License-Identifier: Apache-2.0
#include "libnmc/common/format.h"

#include <cmath>

namespace nmc {

namespace {

// 2^(k / 8), the nearest doubles (spec table B.3).
constexpr double kEighthRoots[8] = {1.0,
                                    1.0905077326652577,
                                    1.189207115002721,
                                    1.2968395546510096,
                                    1.4142135623730951,
                                    1.5422108254079407,
                                    1.681792830507429,
                                    1.8340080864093424};

/// Exact: only the exponent changes as long as the result is a normal number.
double times_power_of_two(double value, int exponent) {
  for (; exponent > 0; --exponent) value *= 2;
  for (; exponent < 0; ++exponent) value *= 0.5;
  return value;
}

}  // namespace

double Header::grid_step() const {
  return times_power_of_two(static_cast<double>(step_mantissa), step_exponent);
}

double Header::diagonal() const {
  const double x = static_cast<double>(extent[0]), y = static_cast<double>(extent[1]),
               z = static_cast<double>(extent[2]);
  return grid_step() * std::sqrt((x * x + y * y) + z * z);
}

int Header::color_attribute() const {
  for (int i = 0; i < attribute_count; ++i) {
    if (attributes[i].is_color()) return i;
  }
  return -1;
}

std::uint32_t Header::ratio_after(int layer) const {
  std::uint32_t ratio = 1;
  for (int k = layer + 1; k < quality_layer_count; ++k) ratio *= layer_ratio[k];
  return ratio;
}

LevelQuantizer Header::quantizer(int level, int layer) const {
  LevelQuantizer q;
  q.normal_step = step_from_code(grid_step(), step_code[level]) * static_cast<double>(ratio_after(layer));
  q.tangential_step = step_from_code(q.normal_step, tangential_code);
  q.tension = {static_cast<double>(tension_code[level]) * 0.25};
  return q;
}

double step_from_code(double grid_step, std::uint8_t code) {
  const int eighths = static_cast<int>(code) - 64;
  const int whole = eighths >> 3;
  return times_power_of_two(grid_step * kEighthRoots[eighths & 7], whole);
}

std::uint16_t error_to_code(double error, double diagonal) {
  if (!(error >= 0) || !(diagonal > 0)) return kUnknownError;
  if (error == 0) return kUnknownError - 1;
  const double code = std::floor(-2048 * std::log2(error / diagonal));
  int result = code < 0 ? 0 : code > 65534 ? 65534 : static_cast<int>(code);
  while (result > 0 && error_from_code(static_cast<std::uint16_t>(result), diagonal) < error) --result;
  return static_cast<std::uint16_t>(result);
}

double error_from_code(std::uint16_t code, double diagonal) {
  // 2^(-2^k / 2048) for the bits k of the fraction: no library function, so tools print the same on every
  // machine.
  constexpr double kRoots[11] = {
      0.9996616064962437, 0.9993233275026507, 0.9986471128909702, 0.9972960560854701,
      0.9945994234836332, 0.9892280131939755, 0.9785720620877001, 0.9576032806985737,
      0.9170040432046712, 0.8408964152537145, 0.7071067811865476,
  };
  if (code == kUnknownError) return 0;
  double factor = 1;
  for (int k = 0; k < 11; ++k) {
    if (code & (1u << k)) factor *= kRoots[k];
  }
  return diagonal * times_power_of_two(factor, -(code >> 11));
}

}  // namespace nmc
