// SPDX-License-Identifier: Apache-2.0
#include "encoder/color/color_stream.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "encoder/core/error.h"
#include "libnmc/common/format.h"

namespace nmc {

namespace {

constexpr double kPeakSquared = 255.0 * 255.0;
/// Beyond this nothing is seen, and rounding to bytes does not allow for it.
constexpr double kLargestPsnr = 99;

double psnr_of(double mean_squared) {
  return mean_squared > 0 ? std::min(kLargestPsnr, 10 * std::log10(kPeakSquared / mean_squared))
                          : kLargestPsnr;
}

/// The mesh on all levels, those beyond the geometry's made of midpoints.
class Levels {
 public:
  Levels(const SubdivisionHierarchy& hierarchy, const std::vector<Vec3>& positions)
      : hierarchy_(hierarchy), positions_(positions) {}

  int geometry_level() const { return hierarchy_.level_count(); }
  const LevelTopology& topology(int level) const {
    return level <= geometry_level() ? hierarchy_.level(level)
                                     : extra_[static_cast<std::size_t>(level - geometry_level() - 1)];
  }
  std::size_t vertex_count(int level) const {
    if (level <= last_level()) return topology(level).vertex_count;
    const LevelTopology& last = topology(last_level());
    return std::size_t{last.vertex_count} + last.edge_count;  // asked for one level beyond at most
  }
  int last_level() const { return geometry_level() + static_cast<int>(extra_.size()); }

  void ensure(int level) {
    while (last_level() < level) {
      const LevelTopology& coarse = topology(last_level());
      for (std::uint32_t e = 0; e < coarse.edge_count; ++e) {
        positions_.push_back(
            0.5 * (positions_[coarse.edge_vertices[2 * e]] + positions_[coarse.edge_vertices[2 * e + 1]]));
      }
      LevelTopology fine;
      if (!subdivide(coarse, false, fine).ok()) throw Error(ExitCode::kLimit, "out of memory");
      extra_.push_back(std::move(fine));
    }
  }
  /// Of the last level.
  const std::vector<Vec3>& positions() const { return positions_; }

 private:
  const SubdivisionHierarchy& hierarchy_;
  std::vector<Vec3> positions_;
  std::vector<LevelTopology> extra_;
};

/// The best colours that the vertices of one level can carry.
struct Fitted {
  Fitted(const Levels& levels, int fitted_level, int sampled_level, const ColorSamples& samples)
      : level(fitted_level),
        fit(samples, levels.topology(fitted_level), sampled_level - fitted_level),
        colors(fit.solve()),
        mean_squared(fit.mean_squared_error(colors)) {}

  int level;
  ColorFit fit;
  std::vector<RgbValue> colors;
  double mean_squared;
};

struct Trial {
  QuantizedColors colors;
  double mean_squared = 0, luma_step = 0;
  int level = 0;
};

Trial quantize(const Levels& levels, const Fitted& fitted, double luma_step) {
  ColorQuantizerOptions options;
  options.luma_step = luma_step;
  Trial trial;
  trial.colors = quantize_colors(
      fitted.colors, fitted.level, [&](int l) -> const LevelTopology& { return levels.topology(l); },
      options);
  trial.mean_squared = fitted.fit.mean_squared_error(trial.colors.decoded);
  trial.luma_step = luma_step;
  trial.level = fitted.level;
  return trial;
}

/// Steps 2^(k/8): one to the next is 0.75 dB.
double step_of(int k) { return std::exp2(k / 8.0); }
constexpr int kFinestStep = 0, kCoarsestStep = 48;

/// The coarsest step whose trial is `good`, or the finest step there is.
template <class Good>
Trial coarsest_step(const Levels& levels, const Fitted& fitted, const Good& good) {
  int low = kFinestStep, high = kCoarsestStep + 1;  // low: taken to be good
  std::optional<Trial> best;
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    Trial trial = quantize(levels, fitted, step_of(middle));
    if (good(trial)) {
      best = std::move(trial);
      low = middle;
    } else {
      high = middle;
    }
  }
  return best ? std::move(*best) : quantize(levels, fitted, step_of(kFinestStep));
}

/// The finest step within `bytes`, or the coarsest there is.
Trial finest_step(const Levels& levels, const Fitted& fitted, double bytes) {
  int low = kFinestStep - 1, high = kCoarsestStep;  // high: taken to fit
  std::optional<Trial> best;
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    Trial trial = quantize(levels, fitted, step_of(middle));
    if (trial.colors.bits <= 8 * bytes) {
      best = std::move(trial);
      high = middle;
    } else {
      low = middle;
    }
  }
  return best ? std::move(*best) : quantize(levels, fitted, step_of(kCoarsestStep));
}

}  // namespace

ColorResult code_colors(const SubdivisionHierarchy& hierarchy, const std::vector<Vec3>& positions,
                        const SurfaceIndex& input, const std::vector<RgbByte>& input_colors,
                        const ColorOptions& options) {
  Levels levels(hierarchy, positions);
  const double wanted = kPeakSquared * std::pow(10, -options.psnr_db / 10);
  const std::size_t largest =
      std::max(levels.vertex_count(levels.geometry_level()), input_colors.size() * 3 / 2);

  // Two levels at most are compared: the coarsest that can carry the colours, and the next, whose step is
  // coarser.
  constexpr double kNearlyAll = 0.92;  // of the error allowed; more leaves next to nothing for quantization
  std::unique_ptr<Trial> best;
  std::unique_ptr<Fitted> fitted;
  double resolution = 0;
  auto samples = std::make_unique<ColorSamples>(levels.topology(levels.last_level()), levels.positions(),
                                                input, input_colors);
  for (int level = 0; level <= kMaximumLevelCount; ++level) {
    if (level > levels.last_level()) {
      levels.ensure(level);
      fitted.reset();
      samples =
          std::make_unique<ColorSamples>(levels.topology(level), levels.positions(), input, input_colors);
    }
    fitted = std::make_unique<Fitted>(levels, level, levels.last_level(), *samples);
    const bool carries = fitted->mean_squared <= kNearlyAll * wanted;
    if (carries) {
      Trial trial = coarsest_step(levels, *fitted, [&](const Trial& t) { return t.mean_squared <= wanted; });
      const bool is_second = best != nullptr;
      const bool is_met = trial.mean_squared <= wanted;
      if (!best || (is_met && (best->mean_squared > wanted || trial.colors.bits < best->colors.bits))) {
        best = std::make_unique<Trial>(std::move(trial));
        resolution = fitted->mean_squared;
      }
      if (is_second) break;
    }
    if (level == kMaximumLevelCount || levels.vertex_count(level + 1) > largest) break;
  }
  if (!best) {
    // Too coarse: what quantization adds shall be small beside what the spacing costs.
    resolution = fitted->mean_squared;
    const double allowed = 1.26 * resolution;
    best = std::make_unique<Trial>(
        coarsest_step(levels, *fitted, [&](const Trial& t) { return t.mean_squared <= allowed; }));
  }
  if (options.maximum_bytes && best->colors.bits > 8 * *options.maximum_bytes) {
    // Coarser levels with finer steps, or the other way round: the better one of all.
    best.reset();
    for (int level = 0; level <= levels.geometry_level(); ++level) {
      const Fitted on_level(levels, level, levels.last_level(), *samples);
      Trial trial = finest_step(levels, on_level, *options.maximum_bytes);
      const bool fits = trial.colors.bits <= 8 * *options.maximum_bytes;
      if (!best || (fits && trial.mean_squared < best->mean_squared)) {
        best = std::make_unique<Trial>(std::move(trial));
        resolution = on_level.mean_squared;
      }
      if (!fits) break;
    }
  }

  ColorResult result;
  result.report.psnr_db = psnr_of(best->mean_squared);
  result.report.resolution_psnr_db = psnr_of(resolution);
  result.report.byte_estimate = best->colors.bits / 8;
  result.report.finest_level = best->level;
  result.report.luma_step = best->luma_step;
  result.report.is_met = best->mean_squared <= wanted;
  result.report.vertex_count = static_cast<std::uint32_t>(best->colors.decoded.size());
  result.stream.descriptor = best->colors.descriptor;
  result.stream.corrections = std::move(best->colors.corrections);
  return result;
}

}  // namespace nmc
