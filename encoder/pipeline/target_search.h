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
  double good_enough = 0.97;
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

/// Error and size follow powers of the step, so the search is a secant method in logarithms that keeps a bracket.
/// `first_step` is a guess. For a maximum error trials are repaired where they miss it (Candidate::repair).
TargetSearchResult search_target(Candidate& candidate, const Target& target, const StreamDescription& description,
                                 double first_step, const TargetSearchOptions& options);

}  // namespace nmc

#endif  // NMC_ENCODER_PIPELINE_TARGET_SEARCH_H_
