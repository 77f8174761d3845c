// SPDX-License-Identifier: Apache-2.0
// Finds the coarsest quantizer step with which one candidate reaches a target.
#ifndef NMC_ENCODER_PIPELINE_TARGET_SEARCH_H_
#define NMC_ENCODER_PIPELINE_TARGET_SEARCH_H_

#include <functional>
#include <optional>
#include <vector>

#include "encoder/pipeline/candidate.h"
#include "encoder/pipeline/encode_options.h"

namespace nmc {

struct TargetSearchOptions {
  int maximum_trials = 5;
  /// A trial that uses at least this share of what the target allows ends the search.
  double good_enough = 0.985;
  /// Bytes that another candidate needs for the target: a search that would clearly end above them is given up.
  /// 0: none.
  std::size_t bytes_to_beat = 0;
  TrialOptions trial;
};

struct TargetSearchResult {
  std::optional<Trial> best;     // the cheapest trial that meets the target (for a size: the most exact one)
  std::optional<Trial> nearest;  // the one that comes nearest to it, when none meets it
  std::vector<Trial> trials;     // all, in order, without their meshes
};

/// What a target asks of a trial: at most 1 when it is met.
double target_ratio(const Target& target, const Trial& trial);

/// Brings the places of `trial` beyond a maximum error within it, where a few integers can; those of a final trial are
/// sought as densely as the last measurement does.
void repair_maximum_error(const Candidate& candidate, const Target& target, const StreamDescription& description,
                          const TrialOptions& options, Trial& trial);

/// One trial with `step`, its spikes repaired as the target asks: every place beyond a maximum error; for the other
/// targets those far beyond the mean, where that pays.
Trial try_step(Candidate& candidate, const Target& target, const StreamDescription& description, double step,
               const TrialOptions& options);

/// Bytes go with the error to this power, near enough to compare two trials whose errors differ by a third.
inline constexpr double kBytesOverError = -1.05;

/// Whether spikes were repaired at a fair price: a smaller maximum, for bytes that the RMS error gives back but for
/// 2 %.
bool repair_pays(const Trial& trial, const Trial& repaired);

/// What try_step() does at its end where the target is no maximum error: brings back places many RMS errors away, where
/// that is cheap. A final trial is looked at more closely.
Trial repair_spikes(const Candidate& candidate, const Target& target, const StreamDescription& description,
                    const TrialOptions& options, Trial trial);

/// What quantization adds to the error of the fit, as one trial has shown it: rms^2 = floor^2 + noise^2. The noise goes
/// with a power of the step below one, as ever more coefficients are zero already, and falls with more vertices.
struct QuantizationNoise {
  double noise = 0.125, step = 1;  // in the same units; a first guess is proportional
  double vertex_count = 0;         // of the candidate; 0: of none
};

/// `is_first`: of the candidate's trials. Later ones keep correspondences, and that lowers the noise a little.
QuantizationNoise noise_of(const Candidate& candidate, const Trial& trial, bool is_first);
/// The step with which `candidate` should reach an RMS error in its first or a later trial.
double step_for_rms(const Candidate& candidate, double rms, const QuantizationNoise& known, bool is_first);

/// An RMS error is sought by that law of squares, inside a bracket by secants in logarithms; a size by secants alone.
/// `first_step` is a guess. For a maximum error trials are repaired where they miss it (Candidate::repair).
TargetSearchResult search_target(Candidate& candidate, const Target& target, const StreamDescription& description,
                                 double first_step, const TargetSearchOptions& options);

}  // namespace nmc

#endif  // NMC_ENCODER_PIPELINE_TARGET_SEARCH_H_
