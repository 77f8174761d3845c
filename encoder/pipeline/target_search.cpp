// SPDX-License-Identifier: Apache-2.0
#include "encoder/pipeline/target_search.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "encoder/measure/compare_meshes.h"

namespace nmc {

double target_ratio(const Target& target, const Trial& trial) {
  switch (target.kind) {
    case TargetKind::kMaximumError:
      return trial.error.maximum / target.value;
    case TargetKind::kRmsError:
      return trial.error.rms / target.value;
    case TargetKind::kSize:
      return static_cast<double>(trial.byte_count) / target.value;
  }
  return 0;
}

bool repair_pays(const Trial& trial, const Trial& repaired) {
  if (repaired.error.maximum >= trial.error.maximum) return false;
  const double rms_gain = std::log(trial.error.rms / repaired.error.rms);
  const double size_loss = std::log(static_cast<double>(repaired.byte_count) / static_cast<double>(trial.byte_count));
  // Along the usual curve, bytes go with the error to the power of -1 or so; spikes count a little by themselves.
  return size_loss < rms_gain + 0.02;
}

namespace {

/// The final measurement finds nothing between the vertices that the repair has not seen.
void sample_as_measured(const Candidate& candidate, MaximumRepairOptions& repair) {
  const LevelTopology& finest = candidate.hierarchy().level(candidate.hierarchy().level_count());
  repair.input_sample_count = usual_sample_count(candidate.reference().mesh.triangle_count());
  repair.mesh_sample_count = usual_sample_count(finest.face_count);
}

}  // namespace

Trial repair_spikes(const Candidate& candidate, const Target& target, const StreamDescription& description,
                    const TrialOptions& options, Trial trial) {
  // A lost tip of a limb weighs as much in the mean as all the rest, and takes a few integers to bring back. Distances
  // of so many RMS errors are no longer noise of the quantization.
  const double spike_multiple = options.is_final ? 8 : 12, worth_a_look = options.is_final ? 1 : 1.3;
  const double spike = spike_multiple * (target.kind == TargetKind::kSize ? trial.error.rms : target.value);
  if (trial.error.maximum <= worth_a_look * spike) return trial;
  Trial repaired = trial;
  MaximumRepairOptions repair;
  repair.tolerance = spike;
  repair.margin = 1;
  if (options.is_final) {
    repair.maximum_rounds = 16;
    sample_as_measured(candidate, repair);
  } else {
    repair.maximum_rounds = 4;
    repair.patience = 2;  // these may stay, other than places beyond an asked maximum
  }
  candidate.repair(repair, description, options, repaired);
  return repair_pays(trial, repaired) ? repaired : trial;
}

void repair_maximum_error(const Candidate& candidate, const Target& target, const StreamDescription& description,
                          const TrialOptions& options, Trial& trial) {
  MaximumRepairOptions repair;
  repair.tolerance = target.value;
  repair.maximum_rounds = 24;
  repair.starts_again = true;
  if (options.is_final)
    sample_as_measured(candidate, repair);
  else
    repair.input_sample_count = repair.mesh_sample_count = usual_sample_count(0);
  candidate.repair(repair, description, options, trial);
}

Trial try_step(Candidate& candidate, const Target& target, const StreamDescription& description, double step,
               const TrialOptions& options) {
  Trial trial = candidate.quantize(step, description, options);
  if (target.kind == TargetKind::kMaximumError) {
    if (target_ratio(target, trial) > 1) repair_maximum_error(candidate, target, description, options, trial);
    return trial;
  }
  return repair_spikes(candidate, target, description, options, std::move(trial));
}

namespace {

/// Whether the trial, brought to the target along the usual curve, would take clearly more bytes than another way.
bool is_beaten(const Target& target, const Trial& trial, double ratio, std::size_t bytes_to_beat) {
  if (bytes_to_beat == 0 || target.kind != TargetKind::kRmsError || std::abs(std::log(ratio)) > 0.3) return false;
  const double expected = static_cast<double>(trial.byte_count) * std::pow(1 / ratio, kBytesOverError);
  return expected > 1.015 * static_cast<double>(bytes_to_beat);
}

/// Correspondences of a step that is not far from the next one's.
constexpr double kNearStep = 0.45;  // logarithm

double floor_of(const Candidate& candidate) { return candidate.statistics().fit.final_rms; }

double vertex_count_of(const Candidate& candidate) {
  return candidate.hierarchy().level(candidate.coded_level_count()).vertex_count;
}

/// The maximum depends on a handful of places, and hardly on the step until that is far too fine. So the step follows
/// the number of places beyond the tolerance, and the last of them are repaired one by one.
TargetSearchResult search_maximum_error(Candidate& candidate, const Target& target,
                                        const StreamDescription& description, double first_step,
                                        const TargetSearchOptions& options) {
  TargetSearchResult result;
  std::optional<double> meets, fails;  // steps
  double step = first_step;
  for (int i = 0; i < options.maximum_trials; ++i) {
    TrialOptions trial_options = options.trial;
    trial_options.keep_correspondences =
        !result.trials.empty() && std::abs(std::log(step / result.trials.back().normal_step)) < kNearStep;
    Trial trial = try_step(candidate, target, description, step, trial_options);
    const std::size_t byte_count = trial.byte_count;
    Trial record = trial;
    record.mesh = {};
    record.coarser_layers.clear();
    result.trials.push_back(std::move(record));
    const double ratio = target_ratio(target, trial);
    (ratio <= 1 ? meets : fails) = step;
    if (ratio <= 1) {
      if (!result.best || trial.byte_count < result.best->byte_count) result.best = std::move(trial);
    } else if (!result.nearest || ratio < target_ratio(target, *result.nearest)) {
      result.nearest = std::move(trial);
    }
    // Only finer steps can help a trial that misses, and they cost more.
    if (ratio > 1 && options.bytes_to_beat > 0 && byte_count >= options.bytes_to_beat) break;
    if (meets && fails) {
      if (*fails / *meets < 1.25) break;
      step = std::sqrt(*meets * *fails);
    } else {
      step *= meets ? 1.6 : 0.55;
    }
  }
  return result;
}

/// The noise of a first trial over that of a later one with the same step; this and the powers below as measured over
/// the trials of six scans at 0.1 to 0.005 % of the diagonal.
constexpr double kFirstTrialNoise = 1.015;
constexpr double kNoiseOverStep = 0.68, kNoiseOverVertices = -0.25;

}  // namespace

QuantizationNoise noise_of(const Candidate& candidate, const Trial& trial, bool is_first) {
  const double rms = trial.error.rms, floor = floor_of(candidate);
  const double squared = std::max(rms * rms - floor * floor, 0.1 * rms * rms);
  return {std::sqrt(squared) / (is_first ? kFirstTrialNoise : 1), trial.normal_step, vertex_count_of(candidate)};
}

double step_for_rms(const Candidate& candidate, double rms, const QuantizationNoise& known, bool is_first) {
  const double floor = std::min(floor_of(candidate), 0.95 * rms);
  double wanted = std::sqrt(rms * rms - floor * floor);
  if (known.vertex_count == 0) return wanted * known.step / known.noise;
  if (is_first) wanted /= kFirstTrialNoise;
  const double fewer = std::pow(vertex_count_of(candidate) / known.vertex_count, kNoiseOverVertices);
  const double at_known_step = known.noise * std::clamp(fewer, 0.85, 1.18);
  return known.step * std::clamp(std::pow(wanted / at_known_step, 1 / kNoiseOverStep), 0.35, 3.0);
}

TargetSearchResult search_target(Candidate& candidate, const Target& target, const StreamDescription& description,
                                 double first_step, const TargetSearchOptions& options) {
  if (target.kind == TargetKind::kMaximumError) {
    return search_maximum_error(candidate, target, description, first_step, options);
  }
  TargetSearchResult result;
  const bool is_size = target.kind == TargetKind::kSize;
  // Error grows with the step, size falls with it; `exponent` is the usual power.
  const double exponent = is_size ? -0.65 : 0.62;
  struct Point {
    double log_step, log_ratio;
  };
  std::optional<Point> meets, fails;
  double log_step = std::log(first_step);
  // Two more trials are granted to a search that has a bracket but would end far inside the target.
  constexpr int kMoreTrials = 2;
  constexpr double kFarInside = 0.93;
  for (int i = 0; i < options.maximum_trials + kMoreTrials; ++i) {
    if (i >= options.maximum_trials && (!result.best || target_ratio(target, *result.best) >= kFarInside)) break;
    TrialOptions trial_options = options.trial;
    trial_options.keep_correspondences =
        !result.trials.empty() && std::abs(log_step - std::log(result.trials.back().normal_step)) < kNearStep;
    Trial trial = try_step(candidate, target, description, std::exp(log_step), trial_options);
    const QuantizationNoise noise = noise_of(candidate, trial, result.trials.empty());
    const double ratio = std::max(target_ratio(target, trial), 1e-12);
    const Point point{std::log(trial.normal_step), std::log(ratio)};
    Trial record = trial;
    record.mesh = {};
    record.coarser_layers.clear();
    result.trials.push_back(std::move(record));
    const bool met = ratio <= 1;
    const auto better = [&](const std::optional<Trial>& old) {
      if (!old) return true;
      if (!met) return ratio < target_ratio(target, *old);
      return is_size ? trial.error.rms < old->error.rms : trial.byte_count < old->byte_count;
    };
    std::optional<Trial>& slot = met ? result.best : result.nearest;
    if (better(slot)) slot = std::move(trial);
    const std::optional<Point> last = met ? meets : fails;
    (met ? meets : fails) = point;
    if (met && ratio >= options.good_enough) break;
    if (is_beaten(target, result.trials.back(), ratio, options.bytes_to_beat)) break;
    const double aim = std::log(0.5 * (1 + options.good_enough));

    if (meets && fails) {
      // Secant inside the bracket, aimed a little below the target; kept away from the ends of the bracket.
      double part = (aim - meets->log_ratio) / (fails->log_ratio - meets->log_ratio);
      part = std::clamp(std::isfinite(part) ? part : 0.5, 0.12, 0.88);
      log_step = meets->log_step + part * (fails->log_step - meets->log_step);
    } else if (!is_size && !last) {
      const double next = step_for_rms(candidate, std::exp(aim) * target.value, noise, false);
      log_step = point.log_step + std::clamp(std::log(next) - point.log_step, -2.0, 2.0);
    } else {
      double slope = exponent;
      if (last && std::abs(point.log_step - last->log_step) > 1e-6) {
        slope = (point.log_ratio - last->log_ratio) / (point.log_step - last->log_step);
        // A finer step that no longer helps: the candidate's own floor is above the target.
        if (!met && !is_size && slope < 0.08 && ratio > 1.05) break;
        const double sign = is_size ? -1 : 1;
        slope = sign * std::clamp(sign * slope, 0.3, 1.2);
      }
      const double move = (aim - point.log_ratio) / slope;
      log_step = point.log_step + std::clamp(move, -2.0, 2.0);
    }
  }
  return result;
}

}  // namespace nmc
