// SPDX-License-Identifier: Apache-2.0
#include "libnmc/common/trained_states.h"

#include <catch2/catch.hpp>
#include <memory>
#include <string>

#include "libnmc/common/base_mesh_coder.h"
#include "libnmc/common/coefficient_coder.h"

namespace nmc {

namespace {

/// States named by a text of spec appendix D; -1 where a letter is none.
long named_states(const std::string& text) {
  long count = 0, number = 0;
  for (const char c : text) {
    if (c >= '0' && c <= '9') {
      number = 10 * number + (c - '0');
      continue;
    }
    if (std::string(kTrainedAlphabet).find(c) == std::string::npos) return -1;
    count += number + 1;
    number = 0;
  }
  return count + number;
}

struct Counter {
  long states = 0, trained = 0;
  void operator()(const AdaptiveBit* first, int states_per_level, int level_count, int told_apart) {
    states += states_per_level * told_apart;
    for (int i = 0; i < states_per_level * level_count; ++i) trained += first[i].count() == kTrainedCount;
  }
};

}  // namespace

TEST_CASE("The texts of trained states name every state that starts trained") {
  BaseMeshModel base;
  Counter base_counter;
  base.visit_trained_states(base_counter);
  CHECK(named_states(kTrainedBaseStates) == base_counter.states);
  CHECK(base_counter.trained > 0);

  const auto coefficients = std::make_unique<CoefficientModel>();
  Counter counter;
  coefficients->visit_trained_states(counter);
  CHECK(named_states(kTrainedCoefficientStates) == counter.states);
  CHECK(counter.trained > 0);
}

TEST_CASE("Resetting a model brings the trained states back, or takes them away") {
  const auto model = std::make_unique<CoefficientModel>();
  Counter fresh, untrained, again;
  model->visit_trained_states(fresh);
  model->reset_untrained();
  model->visit_trained_states(untrained);
  CHECK(untrained.trained == 0);
  model->reset();
  model->visit_trained_states(again);
  CHECK(again.trained == fresh.trained);
}

TEST_CASE("A letter is a probability and a count, a number a gap, and higher levels repeat the last") {
  AdaptiveBit states[8];
  TrainedStateReader reader("T2!");
  reader(states, 2, 4, 2);
  CHECK(states[0].probability_16() == 32768);
  CHECK(states[0].count() == kTrainedCount);
  CHECK(states[1].count() == 0);
  CHECK(states[2].count() == 0);
  CHECK(states[3].probability_16() == squash(-kLargestLetter * kLetterScale));
  for (int i = 4; i < 8; ++i) CHECK(states[i].state == states[i - 2].state);
}

}  // namespace nmc
