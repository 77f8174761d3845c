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

/// One trial with `step`, its spikes repaired as the target asks: every place beyond a maximum error; for the other
/// targets those far beyond the mean, where that pays.
Trial try_step(Candidate& candidate, const Target& target, const StreamDescription& description, double step,
               const TrialOptions& options);

/// The step with which `candidate` should reach an RMS error, from the share of the step that quantization leaves as
/// error: rms^2 = floor^2 + (share step)^2, with the error of the fit as the floor.
double step_for_rms(const Candidate& candidate, double rms, double share);
/// That share, as a trial shows it.
double error_share(const Candidate& candidate, const Trial& trial);
inline constexpr double kUsualErrorShare = 0.125;

/// An RMS error is sought by that law of squares, inside a bracket by secants in logarithms; a size by secants alone.
/// `first_step` is a guess. For a maximum error trials are repaired where they miss it (Candidate::repair).
TargetSearchResult search_target(Candidate& candidate, const Target& target, const StreamDescription& description,
                                 double first_step, const TargetSearchOptions& options);

}  // namespace nmc

#endif  // NMC_ENCODER_PIPELINE_TARGET_SEARCH_H_
