// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "libnmc/common/coefficient_coder.h"
#include "libnmc/decode/range_decoder.h"
#include "libnmc/encode/range_encoder.h"
#include "tests/support/random_base_mesh.h"

using namespace nmc;

namespace {

struct Decision {
  int bit;
  std::uint32_t probability;
};

std::vector<Decision> random_decisions(std::uint64_t seed, int count) {
  test::RandomIntegers random(seed);
  std::vector<Decision> decisions;
  for (int i = 0; i < count; ++i) {
    const std::uint32_t p = random.chance(0.1)   ? 1
                            : random.chance(0.1) ? 65535
                                                 : static_cast<std::uint32_t>(random.between(1, 65535));
    decisions.push_back({random.chance(p / 65536.0) ? 1 : 0, p});
  }
  return decisions;
}

Array<std::uint8_t> encode(const std::vector<Decision>& decisions) {
  Array<std::uint8_t> bytes;
  RangeEncoder encoder(bytes);
  for (const Decision& d : decisions) encoder.code(d.bit, d.probability);
  encoder.finish();
  return bytes;
}

}  // namespace

TEST_CASE("range coder: every decision comes back, and the payload is as long as the counter says",
          "[range]") {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const auto decisions = random_decisions(seed, static_cast<int>(seed * 7 % 400));
    const Array<std::uint8_t> bytes = encode(decisions);
    BitCounter counter;
    for (const Decision& d : decisions) counter.code(d.bit, d.probability);
    INFO("seed " << seed << ", " << decisions.size() << " decisions, " << bytes.size()
                 << " bytes, counter says " << counter.bits() / 8);
    CHECK(static_cast<double>(bytes.size()) <= counter.bits() / 8 * 1.001 + 4);
    RangeDecoder decoder(bytes.data(), bytes.size());
    std::size_t wrong = 0;
    for (const Decision& d : decisions) wrong += decoder.code(0, d.probability) != d.bit;
    CHECK(wrong == 0);
    CHECK(decoder.check().ok());
    CHECK(decoder.consumed());
  }
}

TEST_CASE("range coder: an improbable bit costs its information and not more", "[range]") {
  Array<std::uint8_t> bytes;
  RangeEncoder encoder(bytes);
  for (int i = 0; i < 100; ++i) encoder.code(1, 1);  // sixteen bits each
  encoder.finish();
  CHECK(bytes.size() >= 199);
  CHECK(bytes.size() <= 204);
  RangeDecoder decoder(bytes.data(), bytes.size());
  for (int i = 0; i < 100; ++i) REQUIRE(decoder.code(0, 1) == 1);
}

TEST_CASE("range coder: reading far beyond the end is told", "[range][malformed]") {
  const auto decisions = random_decisions(3, 500);
  const Array<std::uint8_t> bytes = encode(decisions);
  RangeDecoder decoder(bytes.data(), bytes.size() / 2);
  for (const Decision& d : decisions) decoder.code(0, d.probability);
  CHECK(decoder.overrun());
  CHECK(decoder.check().code() == StatusCode::kCorrupt);
  RangeDecoder empty(nullptr, 0);
  for (int i = 0; i < 1000; ++i) empty.code(0, 32768);
  CHECK(empty.overrun());
}

TEST_CASE("number model: all lengths come back, at the ends of the range too", "[range]") {
  std::vector<std::uint32_t> numbers = {0, 0xffffffffu, 1, 0xfffffffeu, 0x80000000u, 0x7fffffffu};
  test::RandomIntegers random(7);
  for (int i = 0; i < 2000; ++i)
    numbers.push_back(static_cast<std::uint32_t>(random.between(0, 0xffffffffll)) >> random.below(32));
  Array<std::uint8_t> bytes;
  {
    RangeEncoder encoder(bytes);
    NumberModel model;
    forget_all_bits(model);
    for (const std::uint32_t n : numbers) REQUIRE(model.code(encoder, n) == n);
    encoder.finish();
  }
  RangeDecoder decoder(bytes.data(), bytes.size());
  NumberModel model;
  forget_all_bits(model);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    INFO("number " << i);
    REQUIRE(model.code(decoder, 0u) == numbers[i]);
  }
}

TEST_CASE("adaptive bits: the state stays a probability after any history", "[range]") {
  for (const std::uint32_t limit : {1u, 120u, 250u, kLargestCountLimit}) {
    AdaptiveBit always{AdaptiveBit::kUntrained}, never = always;
    for (int i = 0; i < 20000; ++i) {
      always.update(1, limit);
      never.update(0, limit);
    }
    CHECK(always.probability_16() > 65000);
    CHECK(never.probability_16() < 500);
    CHECK(always.count() == limit);
  }
}

TEST_CASE("logistic mixing: squash and stretch are inverse and monotonous", "[range]") {
  std::uint32_t last = 0;
  for (int x = -2100; x <= 2100; ++x) {
    const std::uint32_t p = squash(x);
    CHECK(p >= last);
    last = p;
    if (x < -1500 || x > 1500) continue;
    INFO("x " << x << " -> " << p << " -> " << stretch(p));
    CHECK(std::abs(stretch(p) - x) <= 1 + 4096 / static_cast<int>(std::min(p, 65536 - p) / 16 + 1));
  }
}

TEST_CASE("logistic mixing: what is mixed learns the better of its inputs", "[range]") {
  test::RandomIntegers random(5);
  AdaptiveBit informed[2], blind;
  forget_all_bits(informed);
  forget_all_bits(blind);
  MixerWeights weights;
  weights.reset(2);
  BitCounter mixed, alone;
  for (int i = 0; i < 20000; ++i) {
    const int context = random.chance(0.5) ? 1 : 0;
    const int bit = random.chance(context ? 0.95 : 0.05) ? 1 : 0;
    MixedBit<2> decision(informed[context], blind);
    mixed.code(bit, decision.probability(weights));
    decision.update(bit, weights, 250);
    alone.code(bit, 32768);
  }
  // The entropy of 0.05 is 0.286 bits.
  CHECK(mixed.bits() / 20000 < 0.30);
  CHECK(alone.bits() / 20000 == Approx(1.0));
}
