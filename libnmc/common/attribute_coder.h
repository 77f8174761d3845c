// SPDX-License-Identifier: Apache-2.0
// The model of attribute values: which decisions describe the corrections of one vertex, and in which
// contexts (spec 10.5). Integers throughout, and a template over the coder, as coefficient_coder.h is.
#ifndef NMC_COMMON_ATTRIBUTE_CODER_H_
#define NMC_COMMON_ATTRIBUTE_CODER_H_

#include <cstdint>

#include "libnmc/common/attribute.h"
#include "libnmc/common/coefficient_coder.h"
#include "libnmc/common/context_mixing.h"

namespace nmc {

/// Largest magnitude of a correction: enough to reach any value with a step of 1 (spec 8).
inline constexpr std::int32_t kMaximumCorrection = (1 << 15) - 1;

/// What is known around a vertex when it is coded (spec 10.5.1).
struct AttributeContexts {
  int level_class = 0;  // 0 ... 7
  int near_count = 0;   // 0 ... 4
  struct Component {
    int near = 11;       // class of the mean deviation near by in steps; 11: none is known
    int gradient = 0;    // class of the difference along the edge, 0 ... 10
    int curvature = 11;  // class of the difference between along and across, 11: at a boundary
    int near_sign = 0;   // -1, 0, 1: of the sum of the deviations near by
    int curvature_sign = 0;
  } component[kMaximumComponentCount];
};

class AttributeModel {
 public:
  void reset();

  /// Codes the corrections of one vertex, one per component. Encoders set them, decoders start from zeros.
  /// With kLearns false nothing is remembered: that is how an encoder asks for costs.
  template <bool kLearns, class Coder>
  void code_vertex(Coder& coder, const AttributeContexts& contexts, int component_count,
                   std::int32_t* corrections);

 private:
  static constexpr int kLevelClasses = 8;
  static constexpr int kUnary = 14;
  static constexpr int kOthers = 9;  // classes of the components that are coded already

  /// Whether any component differs from its prediction.
  struct OpenStates {
    AdaptiveBit by_near[kLevelClasses][12][5];
    AdaptiveBit by_shape[11][12];
    AdaptiveBit by_chroma[12][12];
    AdaptiveBit by_gradient[12][11];
    AdaptiveBit by_history[16][12];
    MixerWeights mixer[kLevelClasses];
  };
  struct ComponentStates {
    AdaptiveBit zero_by_near[kLevelClasses][12][5];
    AdaptiveBit zero_by_shape[11][12];
    AdaptiveBit zero_by_others[12][kOthers];
    AdaptiveBit zero_by_gradient[12][11];
    AdaptiveBit zero_by_level[kLevelClasses][kOthers];
    MixerWeights zero_mixer[kLevelClasses];
    AdaptiveBit sign_by_near[3][3];
    AdaptiveBit sign_by_others[3][3][3];
    AdaptiveBit sign_by_shape[3][12];
    MixerWeights sign_mixer;
    AdaptiveBit more_by_near[12][kUnary];
    AdaptiveBit more_by_gradient[11][kUnary];
    AdaptiveBit more_by_others[kOthers][kUnary];
    AdaptiveBit more_by_level[kLevelClasses][kUnary];
    MixerWeights more_mixer[kUnary];
    NumberModel escape;
  };

  OpenStates open_;
  ComponentStates components_[kMaximumComponentCount];
  std::uint32_t history_;  // whether the last vertices were open, newest in bit 0
};

// ---- implementation ----

namespace attribute_internal {

template <bool kLearns, int kInputs, class Coder>
int code_mixed(Coder& coder, MixedBit<kInputs> bit, MixerWeights& mixer, int value,
               std::uint32_t count_limit) {
  value = coder.code(value, bit.probability(mixer));
  if constexpr (kLearns) bit.update(value, mixer, count_limit);
  return value;
}

}  // namespace attribute_internal

template <bool kLearns, class Coder>
void AttributeModel::code_vertex(Coder& coder, const AttributeContexts& contexts, int component_count,
                                 std::int32_t* corrections) {
  using attribute_internal::code_mixed;
  using coefficient_internal::magnitude_of;
  using coefficient_internal::sign_of;
  const int level = contexts.level_class;
  const AttributeContexts::Component& first = contexts.component[0];
  int chroma_near = 0;
  for (int c = 1; c < component_count; ++c) {
    if (contexts.component[c].near > chroma_near) chroma_near = contexts.component[c].near;
  }
  int open = 0;
  for (int c = 0; c < component_count; ++c) open |= corrections[c] != 0;
  open = code_mixed<kLearns>(
      coder,
      MixedBit<5>(open_.by_near[level][first.near][contexts.near_count],
                  open_.by_shape[first.gradient][first.curvature], open_.by_chroma[first.near][chroma_near],
                  open_.by_gradient[first.near][first.gradient],
                  open_.by_history[history_ & 15][chroma_near]),
      open_.mixer[level], open, kSignificanceCountLimit);
  if constexpr (kLearns) history_ = 2 * history_ + static_cast<std::uint32_t>(open);
  if (!open) {
    for (int c = 0; c < component_count; ++c) corrections[c] = 0;
    return;
  }

  bool any = false;
  for (int c = 0; c < component_count; ++c) {
    ComponentStates& states = components_[c];
    const AttributeContexts::Component& around = contexts.component[c];
    // Components beyond the third look back as the third does.
    const auto small = [&](int i) {
      const std::int32_t m = magnitude_of(corrections[i]);
      return static_cast<int>(m < 2 ? m : 2);
    };
    const int others = c == 0 ? 0 : c == 1 ? small(0) : 3 * small(0) + small(1);
    const bool is_known_nonzero = c == component_count - 1 && !any;
    if (!is_known_nonzero) {
      const int significant =
          code_mixed<kLearns>(coder,
                              MixedBit<5>(states.zero_by_near[level][around.near][contexts.near_count],
                                          states.zero_by_shape[around.gradient][around.curvature],
                                          states.zero_by_others[around.near][others],
                                          states.zero_by_gradient[around.near][around.gradient],
                                          states.zero_by_level[level][others]),
                              states.zero_mixer[level], corrections[c] != 0, kSignificanceCountLimit);
      if (!significant) {
        corrections[c] = 0;
        continue;
      }
    }
    any = true;

    const int sign_0 = c > 0 ? sign_of(corrections[0]) : 0, sign_1 = c > 1 ? sign_of(corrections[1]) : 0;
    const int negative =
        code_mixed<kLearns>(coder,
                            MixedBit<3>(states.sign_by_near[around.near_sign + 1][around.curvature_sign + 1],
                                        states.sign_by_others[sign_0 + 1][sign_1 + 1][around.near_sign + 1],
                                        states.sign_by_shape[around.curvature_sign + 1][around.curvature]),
                            states.sign_mixer, corrections[c] < 0, kSignificanceCountLimit);

    const std::uint32_t excess = static_cast<std::uint32_t>(magnitude_of(corrections[c])) - 1;
    std::uint32_t m = 0;
    while (m < kUnary) {
      const int more = code_mixed<kLearns>(
          coder,
          MixedBit<4>(states.more_by_near[around.near][m], states.more_by_gradient[around.gradient][m],
                      states.more_by_others[others][m], states.more_by_level[level][m]),
          states.more_mixer[m], excess > m, kMagnitudeCountLimit);
      if (!more) break;
      ++m;
    }
    constexpr std::uint32_t kLargestExcess = static_cast<std::uint32_t>(kMaximumCorrection) - 1;
    if (m == kUnary) {
      if constexpr (kLearns) {
        const std::uint32_t escaped = states.escape.code(coder, excess - kUnary);
        m = escaped < kLargestExcess - kUnary ? escaped + kUnary : kLargestExcess;
      } else {
        NumberModel copy = states.escape;
        copy.code(coder, excess - kUnary);
        m = excess;
      }
    }
    const std::int32_t magnitude = static_cast<std::int32_t>(m) + 1;
    corrections[c] = negative ? -magnitude : magnitude;
  }
}

}  // namespace nmc

#endif  // NMC_COMMON_ATTRIBUTE_CODER_H_
