// SPDX-License-Identifier: Apache-2.0
#include "libnmc/common/trained_states.h"

namespace nmc {

namespace {

/// The place of a letter in the alphabet: ASCII from '!' on, without the quotation mark, the digits, the
/// backslash and the backquote.
constexpr int letter_index(char letter) {
  return letter - '!' - (letter > '"') - (letter > '9' ? 10 : 0) - (letter > '\\') - (letter > '`');
}
static_assert([] {
  for (int i = 0; i <= 2 * kLargestLetter; ++i) {
    if (letter_index(kTrainedAlphabet[i]) != i) return false;
  }
  return true;
}());

bool is_digit(char c) { return c >= '0' && c <= '9'; }

}  // namespace

void TrainedStateReader::read(AdaptiveBit& state) {
  if (untrained_ == 0 && is_digit(*at_)) {
    while (is_digit(*at_)) untrained_ = 10 * untrained_ + (*at_++ - '0');
  }
  if (untrained_ > 0) {
    --untrained_;
    state.state = AdaptiveBit::kUntrained;
  } else {
    const std::uint32_t probability_16 = squash(kLetterScale * (letter_index(*at_++) - kLargestLetter));
    state.state = (probability_16 << 16) | kTrainedCount;
  }
}

void TrainedStateReader::operator()(AdaptiveBit* states, int states_per_level, int level_count,
                                    int told_apart) {
  for (int level = 0; level < level_count; ++level) {
    AdaptiveBit* const own = states + level * states_per_level;
    for (int i = 0; i < states_per_level; ++i) {
      if (level < told_apart)
        read(own[i]);
      else
        own[i] = own[i - states_per_level];
    }
  }
}

void set_trained_weights(TrainedMixer row, int input_count, MixerWeights& weights) {
  weights.reset(input_count);
  for (int i = 0; i <= input_count; ++i) weights.weight[i] = 512 * std::int32_t{kTrainedWeights[row][i]};
  weights.rate = kTrainedRate;
}

}  // namespace nmc
