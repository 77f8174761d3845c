// SPDX-License-Identifier: Apache-2.0
// What a header says of the values that vertices carry besides their positions, colours above all (spec 10).
#ifndef NMC_COMMON_ATTRIBUTE_H_
#define NMC_COMMON_ATTRIBUTE_H_

#include <cstdint>

namespace nmc {

// spec 8
inline constexpr int kMaximumAttributeCount = 4;
inline constexpr int kMaximumComponentCount = 4;
inline constexpr int kMaximumAttributeBits =
    14;  // values, and differences of values, fit 16 bits with a sign
inline constexpr int kMaximumAttributeLevelCount = 15;  // level 0 and the 14 finer ones

/// Meaning of an attribute (spec 10.1). Decoders hand values of other kinds through.
enum class AttributeKind : std::uint8_t {
  kColor = 1,        // red, green, blue as sRGB, then opacity where there is a fourth component
  kApplication = 64  // from here on: known to the application alone
};

/// How the vertices that are new on one level are predicted and quantized.
struct AttributeLevel {
  std::uint8_t step[kMaximumComponentCount] = {1, 1, 1, 1};  // 1 ... 255
  int opposite_share = 0;  // -4 ... 11: weight in 1/16 of each opposite corner; of each end 8 less that many
  int near_share = 0;      // 0 ... 15: weight in 1/16 of the mean deviation of the edges near by
};
inline constexpr int kLowestOppositeShare = -4, kHighestOppositeShare = 11, kHighestNearShare = 15;

struct AttributeDescriptor {
  std::uint8_t kind = static_cast<std::uint8_t>(AttributeKind::kColor);
  int component_count = 3;
  int bit_count = 8;             // of each component, 0 ... 2^bit_count - 1
  bool is_decorrelated = false;  // the first three components are coded as luma and chroma
  int finest_level = 0;          // values are coded for levels 0 ... finest_level and predicted beyond
  AttributeLevel levels[kMaximumAttributeLevelCount];

  bool is_color() const { return kind == static_cast<std::uint8_t>(AttributeKind::kColor); }
  std::int32_t largest_value() const { return (1 << bit_count) - 1; }
  /// Bounds of component `component` as it is coded.
  std::int32_t coded_minimum(int component) const {
    return is_decorrelated && (component == 1 || component == 2) ? -largest_value() : 0;
  }
};

/// Red, green, blue to luma and two chroma differences, exactly invertible (spec 10.2).
/// H. Malvar, G. Sullivan. YCoCg-R: a color space with RGB reversibility and low dynamic range. JVT-I014r3,
/// 2003.
inline void luma_chroma_from_rgb(const std::int32_t rgb[3], std::int32_t coded[3]) {
  const std::int32_t co = rgb[0] - rgb[2];
  const std::int32_t t = rgb[2] + (co >> 1);
  const std::int32_t cg = rgb[1] - t;
  coded[0] = t + (cg >> 1);
  coded[1] = co;
  coded[2] = cg;
}

/// The inverse, held within 0 ... `largest` where quantization leads beyond.
inline void rgb_from_luma_chroma(const std::int32_t coded[3], std::int32_t largest, std::int32_t rgb[3]) {
  const std::int32_t t = coded[0] - (coded[2] >> 1);
  const std::int32_t blue = t - (coded[1] >> 1);
  const std::int32_t values[3] = {blue + coded[1], coded[2] + t, blue};
  for (int k = 0; k < 3; ++k) rgb[k] = values[k] < 0 ? 0 : values[k] > largest ? largest : values[k];
}

}  // namespace nmc

#endif  // NMC_COMMON_ATTRIBUTE_H_
