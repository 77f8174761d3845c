// SPDX-License-Identifier: Apache-2.0
// What adaptive bits and mixers know before the first bit (spec appendix D).
//
// A file of one or two kilobytes is over before its states have learnt much. So the states that such files
// meet start with what other meshes taught them: 4 % fewer bytes at 1 kB, 2 % at 5 kB. Small tables do: a
// probability is one letter, all trained states claim the same count, and from the third level on all levels
// start alike.
//
// Made by nmc-train-states (bench/train, whose README.md names the meshes); trained_states.cpp is its output.
#ifndef NMC_COMMON_TRAINED_STATES_H_
#define NMC_COMMON_TRAINED_STATES_H_

#include <cstdint>

#include "libnmc/common/context_mixing.h"

namespace nmc {

/// The count of every trained adaptive bit, and the learning rate of every trained mixer.
inline constexpr std::uint32_t kTrainedCount = 30;
inline constexpr std::int32_t kTrainedRate = 300;
/// A letter stands for a number in [-40, 40]; the probability is squash(51 times it).
inline constexpr int kLargestLetter = 40;
inline constexpr int kLetterScale = 51;
inline constexpr char kTrainedAlphabet[] =
    "!#$%&'()*+,-./:;<=>?@ABCDEFGHIJKLMNOPQRSTUVWXYZ[]^_abcdefghijklmnopqrstuvwxyz{|}~";
static_assert(sizeof(kTrainedAlphabet) == 2 * kLargestLetter + 2);

/// Levels told apart by the trained tables: 0, 1, and all others.
inline constexpr int kTrainedLevels = 3;

/// Rows of the mixers' table.
enum TrainedMixer : int {
  kMixSignificance = 0,  // + kind
  kMixSign = 4,          // + kind & 1
  kMixMagnitude = 6,     // + min(ones so far, 2)
  kMixHalfBlock = 9,
  kMixInnerBlock = 10,
  kMixIsNew = 11,
  kTrainedMixerCount = 12,
};

/// Trained states in the order in which the models visit theirs. A letter is a trained state, a decimal
/// number that many that start untrained.
extern const char kTrainedBaseStates[];
extern const char kTrainedCoefficientStates[];
/// Weights in units of 512: of the inputs in their order, then of the constant.
extern const std::int8_t kTrainedWeights[kTrainedMixerCount][kMaximumMixerInputs];

/// Sets states from one of the two strings: the visitor of the models' visit_trained_states().
class TrainedStateReader {
 public:
  explicit TrainedStateReader(const char* letters) : at_(letters) {}

  /// `states_per_level` states for each of `level_count` levels, of which the first `told_apart` have letters
  /// of their own; the others start as the last of these.
  void operator()(AdaptiveBit* states, int states_per_level, int level_count, int told_apart);

 private:
  void read(AdaptiveBit& state);

  const char* at_;
  int untrained_ = 0;  // states still covered by the number read last
};

/// The start of a mixer of `input_count` inputs.
void set_trained_weights(TrainedMixer row, int input_count, MixerWeights& weights);

}  // namespace nmc

#endif  // NMC_COMMON_TRAINED_STATES_H_
