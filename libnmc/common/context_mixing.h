// SPDX-License-Identifier: Apache-2.0
// Probabilities of binary decisions: adaptive bits, and a few of them mixed in the logistic domain
// (spec 5.2).
//
// Based on: M. Mahoney. Adaptive weighing of context models for lossless data compression. TR CS-2005-16,
// Florida Tech, 2005 (logistic mixing, here in integers throughout: encoder and decoder agree on every
// machine).
//
// Everything is inline: these few lines are most of the time that decoding takes.
#ifndef NMC_COMMON_CONTEXT_MIXING_H_
#define NMC_COMMON_CONTEXT_MIXING_H_

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace nmc {

/// No adaptive bit counts further than this (spec 5.2).
inline constexpr std::uint32_t kLargestCountLimit = 255;

namespace mixing_internal {

/// What the number of bits seen means for an adaptive bit.
struct CountEffect {
  std::uint16_t reciprocal;  // 65536 / (count + 1.5), rounded down
  std::uint16_t confidence;  // 65536 count / (count + 2), rounded down
};
struct CountTable {
  CountEffect of[kLargestCountLimit + 1];
};

constexpr void fill(CountTable& table) {
  for (std::uint32_t n = 0; n <= kLargestCountLimit; ++n) {
    table.of[n] = {static_cast<std::uint16_t>(131072u / (2 * n + 3)),
                   static_cast<std::uint16_t>(65536u * n / (n + 2))};
  }
}

// 65536 / (1 + exp(-x)) at x = -8, -7.75, ..., 8, rounded (spec table B.1).
inline constexpr std::uint16_t kSquash[65] = {
    22,    28,    36,    47,    60,    77,    98,    126,   162,   208,   267,   342,   439,
    562,   720,   922,   1179,  1506,  1921,  2446,  3108,  3938,  4971,  6249,  7812,  9702,
    11955, 14595, 17625, 21025, 24743, 28693, 32768, 36843, 40793, 44511, 47911, 50941, 53581,
    55834, 57724, 59287, 60565, 61598, 62428, 63090, 63615, 64030, 64357, 64614, 64816, 64974,
    65097, 65194, 65269, 65328, 65374, 65410, 65438, 65459, 65476, 65489, 65500, 65508, 65514};

/// Inverts squash: value[p >> 4] is the smallest x with squash(x) >= p.
struct StretchTable {
  std::int16_t value[4096];
};

constexpr void fill(StretchTable& table) {
  int filled = 0;
  for (int x = -2047; x <= 2047; ++x) {
    const int position = x + 2048, cell = position >> 6, within = position & 63;
    const int low = kSquash[cell], high = kSquash[cell + 1];
    const int p = (low * (64 - within) + high * within) >> 10;  // / 64 / 16
    while (filled <= p && filled < 4096) table.value[filled++] = static_cast<std::int16_t>(x);
  }
  while (filled < 4096) table.value[filled++] = 2047;
}

#if defined(NMC_TABLES_MADE_AT_START)
// The WebAssembly module of decoder/wasm is loaded over a network and belongs to one thread: it does not ship
// these nine kilobytes but has them made by fill_mixing_tables() before its first decoder.
inline CountTable kCountTable;
inline StretchTable kStretch;
#else
extern const CountTable kCountTable;
extern const StretchTable kStretch;
#endif

// Keeps the weighted sum far from overflow whatever bits come.
inline constexpr std::int32_t kLargestWeight = 1 << 22;

}  // namespace mixing_internal

#if defined(NMC_TABLES_MADE_AT_START)
/// To be called before the first decision.
inline void fill_mixing_tables() {
  mixing_internal::fill(mixing_internal::kCountTable);
  mixing_internal::fill(mixing_internal::kStretch);
}
#endif

/// Probability of a one, learned from the bits seen: 22 bits of probability, 10 bits of count.
/// The step is 1 / (count + 1.5) until the count reaches its limit.
struct AdaptiveBit {
  /// Even odds, and nothing seen.
  static constexpr std::uint32_t kUntrained = 1u << 31;

  std::uint32_t state;

  std::uint32_t probability_16() const { return state >> 16; }
  std::uint32_t count() const { return state & 1023u; }
  /// `count_limit` is at most kLargestCountLimit.
  void update(int bit, std::uint32_t count_limit) {
    const std::uint32_t n = count();
    const std::int64_t probability = state >> 10;  // 22 bits
    const std::int64_t target = bit ? (1 << 22) - 1 : 0;
    const std::int64_t moved =
        probability + (((target - probability) * mixing_internal::kCountTable.of[n].reciprocal) >> 16);
    state = (static_cast<std::uint32_t>(moved) << 10) | (n + (n < count_limit ? 1u : 0u));
  }
};

/// ln(p / (1 - p)) in 1/256, for a 16-bit probability; within [-2047, 2047].
inline int stretch(std::uint32_t probability_16) {
  return mixing_internal::kStretch.value[probability_16 >> 4];
}

/// The inverse: a 16-bit probability in [22, 65514] for x in 1/256, clamped to [-2047, 2047].
constexpr std::uint32_t squash(int x) {
  using mixing_internal::kSquash;
  if (x > 2047) x = 2047;
  if (x < -2047) x = -2047;
  const int position = x + 2048, cell = position >> 6, within = position & 63;
  return static_cast<std::uint32_t>((kSquash[cell] * (64 - within) + kSquash[cell + 1] * within) >> 6);
}

/// Sets every adaptive bit of `model`, an object of 32-bit words, to one that has seen nothing, and every
/// other word to the same: the model sets its mixers and counters afterwards. One loop instead of one per
/// table.
template <class Model>
void forget_all_bits(Model& model) {
  static_assert(std::is_trivially_copyable_v<Model> && sizeof(Model) % sizeof(std::uint32_t) == 0);
  auto* const bytes = reinterpret_cast<unsigned char*>(&model);
  for (std::size_t i = 0; i < sizeof(Model); i += sizeof(std::uint32_t)) {
    std::memcpy(bytes + i, &AdaptiveBit::kUntrained, sizeof(std::uint32_t));
  }
}

/// Number of adaptive bits that one mixer joins at most; one more input is a constant.
inline constexpr int kMaximumMixerInputs = 8;

/// Weights of one mixer, in 1/65536. They are written as whole registers and read soon after: never across two lines of
/// the cache.
struct alignas(std::max_align_t) MixerWeights {
  std::int32_t weight[kMaximumMixerInputs + 4];
  std::int32_t rate;  // learning rate, in 1/16384; falls as the mixer learns

  /// Equal weights for `input_count` adaptive bits, 1.4 in total.
  void reset(int input_count) {
    for (std::int32_t& w : weight) w = 0;
    for (int i = 0; i < input_count; ++i) weight[i] = 90000 / input_count;
    rate = 800;
  }
};

/// One mixed decision over kInputs adaptive bits: remembers its inputs between probability and update.
template <int kInputs>
class MixedBit {
  static_assert(kInputs <= kMaximumMixerInputs);

 public:
  template <class... Bits>
  explicit MixedBit(Bits&... bits) : inputs_{&bits...} {
    static_assert(sizeof...(Bits) == kInputs);
  }

  /// Sixteen-bit probability of a one.
  std::uint32_t probability(const MixerWeights& weights) {
    // |weight| <= 2^22 and |stretched| < 2^11: nine products stay below 2^37.
    std::int64_t sum = static_cast<std::int64_t>(weights.weight[kInputs]) * kConstantInput;
    stretched_[kInputs] = kConstantInput;
    for (int i = kInputs + 1; i < kLanes; ++i) stretched_[i] = 0;
    for (int i = 0; i < kInputs; ++i) {
      // An input that has seen nothing says nothing.
      const AdaptiveBit bit = *inputs_[i];
      stretched_[i] =
          (stretch(bit.probability_16()) * mixing_internal::kCountTable.of[bit.count()].confidence) >> 16;
      sum += static_cast<std::int64_t>(weights.weight[i]) * stretched_[i];
    }
    sum >>= 16;
    probability_ = squash(static_cast<int>(sum > 2047 ? 2047 : sum < -2047 ? -2047 : sum));
    return probability_;
  }
  /// Teaches the weights and all inputs.
  void update(int bit, MixerWeights& weights, std::uint32_t count_limit) {
    // |error| <= 2^16 and rate <= 800, so `step` has 16 bits and its product with an input 27.
    const std::int32_t error = (bit ? 65536 : 0) - static_cast<std::int32_t>(probability_);
    const std::int32_t step = (error * weights.rate) >> 10;
    // Plain loops over a whole number of SIMD registers, apart from the adaptive bits, which the compiler
    // cannot tell from the weights.
    std::int32_t taught[kLanes];
    for (int i = 0; i < kLanes; ++i) {
      constexpr std::int32_t kLargest = mixing_internal::kLargestWeight;
      const std::int32_t w = weights.weight[i] + ((step * stretched_[i]) >> 12);
      taught[i] = w > kLargest ? kLargest : w < -kLargest ? -kLargest : w;
    }
    for (int i = 0; i < kLanes; ++i) weights.weight[i] = taught[i];
    for (int i = 0; i < kInputs; ++i) inputs_[i]->update(bit, count_limit);
    if (weights.rate > 120) weights.rate -= (weights.rate - 100) >> 5;
  }

 private:
  static constexpr std::int32_t kConstantInput = 77;
  static constexpr int kLanes = (kInputs + 4) / 4 * 4;

  AdaptiveBit* inputs_[kInputs];
  std::int32_t stretched_[kLanes];
  std::uint32_t probability_ = 0;
};

}  // namespace nmc

#endif  // NMC_COMMON_CONTEXT_MIXING_H_
