// SPDX-License-Identifier: Apache-2.0
#include "encoder/pipeline/target_search.h"

#include <catch2/catch.hpp>

namespace nmc {
namespace {

Trial trial_of(double rms, double maximum, std::size_t byte_count) {
  Trial trial;
  trial.error = {rms, maximum};
  trial.byte_count = byte_count;
  return trial;
}

TEST_CASE("repaired spikes: kept where they cost little", "[target]") {
  const Trial trial = trial_of(1e-4, 1.66e-3, 5000);
  CHECK(repair_pays(trial, trial_of(1e-4, 1e-3, 5050)));
  CHECK_FALSE(repair_pays(trial, trial_of(1e-4, 1e-3, 5200)));
  CHECK(repair_pays(trial, trial_of(0.9e-4, 1e-3, 5400)));
}

TEST_CASE("repaired spikes: never kept where the largest error has grown", "[target]") {
  const Trial trial = trial_of(1e-4, 1.66e-3, 5000);
  CHECK_FALSE(repair_pays(trial, trial_of(1e-4, 1.72e-3, 5010)));
  CHECK_FALSE(repair_pays(trial, trial_of(0.999e-4, 1.66e-3, 4990)));
}

}  // namespace
}  // namespace nmc
