// SPDX-License-Identifier: Apache-2.0
#include "encoder/color/color_quantizer.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "encoder/core/error.h"
#include "libnmc/common/coded_attribute.h"
#include "libnmc/encode/range_encoder.h"

namespace nmc {

namespace {

using LumaChroma = std::array<float, 3>;

/// The transform of libnmc/common/attribute.h without its roundings.
LumaChroma luma_chroma(const RgbValue& rgb) {
  const float co = rgb[0] - rgb[2];
  const float t = rgb[2] + co / 2;
  const float cg = rgb[1] - t;
  return {t + cg / 2, co, cg};
}

/// Squared RGB error, summed over the channels, of errors in luma and chroma.
double rgb_error(double y, double co, double cg) {
  return 3 * y * y + 0.5 * co * co + 0.75 * cg * cg - y * cg;
}

std::uint8_t step_byte(double step) {
  return static_cast<std::uint8_t>(std::clamp(std::lround(step), 1l, 255l));
}

/// The shares of spec 10.4 that predict best, by least squares over the luma of one level.
void fit_shares(const std::vector<LumaChroma>& values, const LevelTopology& coarse, AttributeLevel& level) {
  const auto ends = [&](std::uint32_t e) {
    return values[coarse.edge_vertices[2 * e]][0] + values[coarse.edge_vertices[2 * e + 1]][0];
  };
  const auto across = [&](std::uint32_t e) {
    if (coarse.is_boundary(e)) return ends(e);
    return values[coarse.opposite_vertex(e, coarse.edge_faces[2 * e])][0] +
           values[coarse.opposite_vertex(e, coarse.edge_faces[2 * e + 1])][0];
  };
  double product = 0, square = 0;
  for (std::uint32_t e = 0; e < coarse.edge_count; ++e) {
    const double bend = across(e) - ends(e), error = values[coarse.vertex_count + e][0] - 0.5 * ends(e);
    product += bend * error;
    square += bend * bend;
  }
  level.opposite_share = square > 0
                             ? static_cast<int>(std::clamp<long>(std::lround(16 * product / square),
                                                                 kLowestOppositeShare, kHighestOppositeShare))
                             : 0;
  std::vector<float> deviations(coarse.edge_count);
  for (std::uint32_t e = 0; e < coarse.edge_count; ++e) {
    const double interpolated = 0.5 * ends(e) + level.opposite_share / 16.0 * (across(e) - ends(e));
    deviations[e] = static_cast<float>(values[coarse.vertex_count + e][0] - interpolated);
  }
  product = square = 0;
  for (std::uint32_t e = 0; e < coarse.edge_count; ++e) {
    double sum = 0;
    int count = 0;
    for (int side = 0; side < 2; ++side) {
      const std::uint32_t face = coarse.edge_faces[2 * e + side];
      for (std::uint32_t k = 0; k < 3 && face != kNone; ++k) {
        const std::uint32_t other = coarse.face_edges[3 * face + k];
        if (other >= e) continue;
        sum += deviations[other];
        ++count;
      }
    }
    if (count == 0) continue;
    product += sum / count * deviations[e];
    square += sum / count * (sum / count);
  }
  level.near_share =
      square > 0
          ? static_cast<int>(std::clamp<long>(std::lround(16 * product / square), 0, kHighestNearShare))
          : 0;
}

/// Chooses the corrections of one vertex after the other.
class Chooser {
 public:
  Chooser(const std::vector<LumaChroma>& values, double lambda) : values_(values), lambda_(lambda) {}

  void begin_level(const AttributeLevel& level, std::vector<std::int32_t>& corrections) {
    level_ = &level;
    corrections_ = &corrections;
  }

  void operator()(std::uint32_t vertex, const std::int32_t* prediction, const AttributeContexts& contexts,
                  AttributeModel& model, std::int32_t* chosen) const {
    std::array<double, 3> error;
    bool any = false;
    for (std::size_t c = 0; c < 3; ++c) {
      error[c] = double{values_[vertex][c]} - prediction[c];
      chosen[c] = static_cast<std::int32_t>(std::lround(error[c] / level_->step[c]));
      any |= chosen[c] != 0;
    }
    if (any && lambda_ > 0) reduce(error, contexts, model, chosen);
    corrections_->insert(corrections_->end(), chosen, chosen + 3);
  }

 private:
  double cost(const std::array<double, 3>& error, const AttributeContexts& contexts, AttributeModel& model,
              const std::int32_t* corrections) const {
    BitCounter bits;
    std::int32_t copy[3] = {corrections[0], corrections[1], corrections[2]};
    model.code_vertex<false>(bits, contexts, 3, copy);
    return rgb_error(error[0] - corrections[0] * level_->step[0], error[1] - corrections[1] * level_->step[1],
                     error[2] - corrections[2] * level_->step[2]) +
           lambda_ * bits.bits();
  }

  /// Tries zero, and each component one nearer to zero.
  void reduce(const std::array<double, 3>& error, const AttributeContexts& contexts, AttributeModel& model,
              std::int32_t* chosen) const {
    double best = cost(error, contexts, model, chosen);
    for (int c = 2; c >= 0; --c) {
      if (chosen[c] == 0) continue;
      const std::int32_t old = chosen[c];
      chosen[c] += old > 0 ? -1 : 1;
      const double reduced = cost(error, contexts, model, chosen);
      if (reduced < best) {
        best = reduced;
      } else {
        chosen[c] = old;
      }
    }
    const std::int32_t zero[3] = {0, 0, 0};
    if (cost(error, contexts, model, zero) < best) std::fill(chosen, chosen + 3, 0);
  }

  const std::vector<LumaChroma>& values_;
  double lambda_;
  const AttributeLevel* level_ = nullptr;
  std::vector<std::int32_t>* corrections_ = nullptr;
};

void check(const Status& status) {
  if (!status.ok()) throw Error(ExitCode::kLimit, status.message() ? status.message() : "out of memory");
}

}  // namespace

QuantizedColors quantize_colors(const std::vector<RgbValue>& colors, int level_count,
                                const std::function<const LevelTopology&(int)>& level,
                                const ColorQuantizerOptions& options) {
  std::vector<LumaChroma> values(colors.size());
  for (std::size_t v = 0; v < colors.size(); ++v) values[v] = luma_chroma(colors[v]);

  QuantizedColors result;
  AttributeDescriptor& descriptor = result.descriptor;
  descriptor.is_decorrelated = true;
  descriptor.finest_level = level_count;
  for (int l = 0; l <= level_count; ++l) {
    AttributeLevel& parameters = descriptor.levels[l];
    const double step = options.luma_step * std::pow(options.level_ratio, level_count - l);
    parameters.step[0] = step_byte(step);
    parameters.step[1] = step_byte(step * options.orange_ratio);
    parameters.step[2] = step_byte(step * options.green_ratio);
    if (l > 0) fit_shares(values, level(l - 1), parameters);
  }

  CodedAttribute attribute;
  BitCounter counter;
  Chooser chooser(values, options.lambda_factor * options.luma_step * options.luma_step);
  result.corrections.resize(static_cast<std::size_t>(level_count) + 1);
  for (int l = 0; l <= level_count; ++l) {
    chooser.begin_level(descriptor.levels[l], result.corrections[static_cast<std::size_t>(l)]);
    check(l == 0 ? attribute.code_base(counter, descriptor, nullptr, level(0), chooser)
                 : attribute.code_level(counter, descriptor, l, level(l - 1), chooser));
  }
  result.bits = counter.bits();

  const std::int16_t* coded = attribute.values();
  result.decoded.resize(colors.size());
  for (std::size_t v = 0; v < colors.size(); ++v) {
    const std::int32_t own[3] = {coded[3 * v], coded[3 * v + 1], coded[3 * v + 2]};
    std::int32_t rgb[3];
    rgb_from_luma_chroma(own, descriptor.largest_value(), rgb);
    for (std::size_t k = 0; k < 3; ++k) result.decoded[v][k] = static_cast<float>(rgb[k]);
  }
  return result;
}

}  // namespace nmc
