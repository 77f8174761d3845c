// SPDX-License-Identifier: Apache-2.0
#include "libnmc/common/context_mixing.h"

namespace nmc {

namespace {

// 65536 / (1 + exp(-x)) at x = -8, -7.75, ..., 8, rounded (spec table B.1).
constexpr std::uint16_t kSquash[65] = {
    22, 28, 36, 47, 60, 77, 98, 126, 162, 208, 267, 342, 439, 562, 720, 922,
    1179, 1506, 1921, 2446, 3108, 3938, 4971, 6249, 7812, 9702, 11955, 14595, 17625, 21025, 24743, 28693,
    32768, 36843, 40793, 44511, 47911, 50941, 53581, 55834, 57724, 59287, 60565, 61598, 62428, 63090, 63615, 64030,
    64357, 64614, 64816, 64974, 65097, 65194, 65269, 65328, 65374, 65410, 65438, 65459, 65476, 65489, 65500, 65508,
    65514};

// 65536 / (count + 1.5), rounded down.
constexpr std::uint32_t reciprocal(std::uint32_t count) { return 131072u / (2 * count + 3); }

// Keeps the weighted sum far from overflow whatever bits come.
constexpr std::int64_t kLargestWeight = 1 << 22;

struct StretchTable {
  std::int16_t value[4096];
};

/// Inverts squash: value[p >> 4] is the smallest x with squash(x) >= p.
constexpr StretchTable make_stretch_table() {
  StretchTable table{};
  int filled = 0;
  for (int x = -2047; x <= 2047; ++x) {
    const int position = x + 2048, cell = position >> 6, within = position & 63;
    const int low = kSquash[cell], high = kSquash[cell + 1];
    const int p = (low * (64 - within) + high * within) >> 10;  // / 64 / 16
    while (filled <= p && filled < 4096) table.value[filled++] = static_cast<std::int16_t>(x);
  }
  while (filled < 4096) table.value[filled++] = 2047;
  return table;
}

constexpr StretchTable kStretch = make_stretch_table();

}  // namespace

void AdaptiveBit::update(int bit, std::uint32_t count_limit) {
  const std::uint32_t n = count();
  const std::int64_t probability = state >> 10;  // 22 bits
  const std::int64_t target = bit ? (1 << 22) - 1 : 0;
  const std::int64_t moved = probability + (((target - probability) * reciprocal(n)) >> 16);
  state = (static_cast<std::uint32_t>(moved) << 10) | (n < count_limit ? n + 1 : n);
}

int stretch(std::uint32_t probability_16) { return kStretch.value[probability_16 >> 4]; }

std::uint32_t squash(int x) {
  if (x > 2047) x = 2047;
  if (x < -2047) x = -2047;
  const int position = x + 2048, cell = position >> 6, within = position & 63;
  return static_cast<std::uint32_t>((kSquash[cell] * (64 - within) + kSquash[cell + 1] * within) >> 6);
}

void MixedBit::reset(MixerWeights& weights, int input_count) {
  for (int i = 0; i < input_count; ++i) weights.weight[i] = 90000 / input_count;  // 1.6 in total
  weights.weight[input_count] = 0;
  weights.rate = 800;
}

std::uint32_t MixedBit::probability(const MixerWeights& weights) {
  std::int64_t sum = 0;
  for (int i = 0; i < count_; ++i) {
    // An input that has seen nothing says nothing.
    { const int n = static_cast<int>(inputs_[i]->count()); stretched_[i] = stretch(inputs_[i]->probability_16()) * n / (n + 2); }
    sum += static_cast<std::int64_t>(weights.weight[i]) * stretched_[i];
  }
  stretched_[count_] = 77;
  sum += static_cast<std::int64_t>(weights.weight[count_]) * stretched_[count_];
  sum >>= 16;
  probability_ = squash(static_cast<int>(sum > 2047 ? 2047 : sum < -2047 ? -2047 : sum));
  return probability_;
}

void MixedBit::update(int bit, MixerWeights& weights, std::uint32_t count_limit) {
  const std::int64_t error = (bit ? 65536 : 0) - static_cast<std::int64_t>(probability_);
  for (int i = 0; i <= count_; ++i) {
    std::int64_t w = weights.weight[i] + ((error * stretched_[i] * weights.rate) >> 22);
    w = w > kLargestWeight ? kLargestWeight : w < -kLargestWeight ? -kLargestWeight : w;
    weights.weight[i] = static_cast<std::int32_t>(w);
  }
  if (weights.rate > 120) weights.rate -= (weights.rate - 100) >> 5;
  for (int i = 0; i < count_; ++i) inputs_[i]->update(bit, count_limit);
}

}  // namespace nmc
