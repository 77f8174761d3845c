// SPDX-License-Identifier: Apache-2.0
// Probabilities of binary decisions: adaptive bits, and a few of them mixed in the logistic domain (spec 5.2).
//
// Based on: M. Mahoney. Adaptive weighing of context models for lossless data compression. TR CS-2005-16, Florida
// Tech, 2005 (logistic mixing, here in integers throughout: encoder and decoder agree on every machine).
#ifndef NMC_COMMON_CONTEXT_MIXING_H_
#define NMC_COMMON_CONTEXT_MIXING_H_

#include <cstdint>

namespace nmc {

/// Probability of a one, learned from the bits seen: 22 bits of probability, 10 bits of count.
/// The step is 1 / (count + 1.5) until the count reaches its limit.
struct AdaptiveBit {
  std::uint32_t state = 1u << 31;

  std::uint32_t probability_16() const { return state >> 16; }
  std::uint32_t count() const { return state & 1023u; }
  void update(int bit, std::uint32_t count_limit);
};

/// ln(p / (1 - p)) in 1/256, for a 16-bit probability; within [-2047, 2047].
int stretch(std::uint32_t probability_16);

/// The inverse: a 16-bit probability in [22, 65514] for x in 1/256, clamped to [-2047, 2047].
std::uint32_t squash(int x);

/// Number of adaptive bits that one mixer joins at most; one more input is a constant.
inline constexpr int kMaximumMixerInputs = 8;

/// Weights of one mixer, in 1/65536.
struct MixerWeights {
  std::int32_t weight[kMaximumMixerInputs + 1];
  std::int32_t rate;  // learning rate, in 1/16384; falls as the mixer learns
};

/// One mixed decision: remembers its inputs between probability and update.
class MixedBit {
 public:
  /// A mixer of `input_count` adaptive bits starts with equal weights.
  static void reset(MixerWeights& weights, int input_count);

  /// Adds one adaptive bit to the mix.
  void add(AdaptiveBit& bit) {
    inputs_[count_] = &bit;
    ++count_;
  }
  /// Sixteen-bit probability of a one.
  std::uint32_t probability(const MixerWeights& weights);
  /// Teaches the weights and all inputs.
  void update(int bit, MixerWeights& weights, std::uint32_t count_limit);

 private:
  AdaptiveBit* inputs_[kMaximumMixerInputs];
  int stretched_[kMaximumMixerInputs + 1];
  int count_ = 0;
  std::uint32_t probability_ = 0;
};

}  // namespace nmc

#endif  // NMC_COMMON_CONTEXT_MIXING_H_
