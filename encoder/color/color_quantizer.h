// SPDX-License-Identifier: Apache-2.0
// Colours at the vertices of a hierarchy to the integers of an attribute, by rate and distortion.
//
// The closed loop of libnmc/common/coded_attribute.h is run with its own models: at every vertex the
// corrections that minimize squared error + lambda * bits are taken, the bits being those of the adaptive
// models at that moment. G. Sullivan, T. Wiegand. Rate-distortion optimization for video compression. IEEE
// Signal Processing Mag. 15(6), 1998.
#ifndef NMC_ENCODER_COLOR_COLOR_QUANTIZER_H_
#define NMC_ENCODER_COLOR_COLOR_QUANTIZER_H_

#include <functional>
#include <vector>

#include "encoder/color/color_fit.h"
#include "libnmc/common/attribute.h"
#include "libnmc/common/subdivision.h"

namespace nmc {

struct ColorQuantizerOptions {
  double luma_step = 8;  // of the finest level, 1 ... 255
  double level_ratio =
      0.8;  // step of a level over that of the next finer one: errors of coarse levels spread
  double orange_ratio = 2.4;  // steps of the two chroma components over that of luma
  double green_ratio = 2.0;
  double lambda_factor = 0.07;  // lambda over luma_step^2; 0: nearest integers
};

struct QuantizedColors {
  AttributeDescriptor descriptor;
  std::vector<std::vector<std::int32_t>> corrections;  // [level]: 3 for each vertex that the level adds
  std::vector<RgbValue> decoded;                       // what a decoder makes of them, per vertex
  double bits = 0;
};

/// `colors`: one per vertex of level `level_count`; `level(l)` is the topology of level l < level_count.
/// O(vertices), one thread.
QuantizedColors quantize_colors(const std::vector<RgbValue>& colors, int level_count,
                                const std::function<const LevelTopology&(int)>& level,
                                const ColorQuantizerOptions& options);

}  // namespace nmc

#endif  // NMC_ENCODER_COLOR_COLOR_QUANTIZER_H_
