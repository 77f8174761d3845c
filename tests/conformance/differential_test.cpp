// SPDX-License-Identifier: Apache-2.0
// The library and the reference decoder on bytes that nobody has written down: prefixes, changed bits with
// and without repaired checksums, changed fields of the header, random valid streams.
#include <catch2/catch.hpp>

#include "tests/conformance/vectors.h"
#include "tests/support/header_bytes.h"
#include "tests/support/reference_comparison.h"
#include "tests/support/repair_checksums.h"
#include "tests/support/stream_generator.h"

using namespace nmc::test;

namespace {

/// Small limits, so that hostile counts stay cheap for a decoder that does not care for speed.
nmc_limits small_limits() {
  nmc_limits limits = nmc_default_limits();
  limits.max_vertices = 30000;
  return limits;
}

std::vector<Vector> small_vectors(std::size_t largest) {
  std::vector<Vector> small;
  for (Vector& vector : read_vectors()) {
    if (vector.bytes.size() <= largest) small.push_back(std::move(vector));
  }
  return small;
}

}  // namespace

TEST_CASE("differential: library and reference agree about every prefix of every small vector",
          "[conformance][differential]") {
  std::size_t count = 0;
  for (const Vector& vector : small_vectors(250)) {
    for (std::size_t size = 0; size < vector.bytes.size(); ++size, ++count) {
      const std::vector<std::uint8_t> prefix(vector.bytes.begin(),
                                             vector.bytes.begin() + static_cast<std::ptrdiff_t>(size));
      INFO(vector.id << ", the first " << size << " bytes");
      REQUIRE(difference(prefix, vector.limits) == "");
    }
  }
  CHECK(count > 3000);
}

TEST_CASE("differential: library and reference agree about changed bytes", "[conformance][differential]") {
  const std::vector<Vector> vectors = small_vectors(1200);
  const nmc_limits limits = small_limits();
  for (std::uint64_t seed = 1; seed <= 3000; ++seed) {
    RandomIntegers random(seed);
    const Vector& vector = vectors[random.below(vectors.size())];
    if (vector.bytes.size() < 10) continue;
    std::vector<std::uint8_t> changed = vector.bytes;
    const std::size_t first = random.chance(0.7) ? 5 : 0;
    for (std::size_t k = 1 + random.below(6); k > 0; --k) {
      std::uint8_t& byte = changed[first + random.below(changed.size() - first)];
      byte = random.chance(0.5) ? static_cast<std::uint8_t>(random.below(256))
                                : static_cast<std::uint8_t>(byte ^ (1u << random.below(8)));
    }
    if (random.chance(0.2)) changed.resize(1 + random.below(changed.size()));
    if (random.chance(0.9)) repair_checksums(changed.data(), changed.size());
    INFO(vector.id << ", seed " << seed);
    REQUIRE(difference(changed, limits) == "");
  }
}

TEST_CASE("differential: library and reference agree about random valid streams",
          "[conformance][differential]") {
  for (std::uint64_t seed = 1000; seed < 1120; ++seed) {
    const GeneratedStream stream = generate(random_recipe(seed));
    INFO(stream.name);
    REQUIRE(difference(stream.bytes, nmc_default_limits()) == "");
  }
}

TEST_CASE("differential: library and reference agree about headers with fields out of range",
          "[conformance][differential]") {
  for (std::uint64_t seed = 1; seed <= 3000; ++seed) {
    RandomIntegers random(seed);
    HeaderFields header;
    const auto wild = [&]() -> std::uint64_t { return std::uint64_t{1} << random.below(64); };
    header.flags = random.chance(0.7) ? static_cast<std::uint8_t>(random.below(16)) : std::uint8_t{0};
    if (random.chance(0.2)) header.frame = static_cast<std::uint8_t>(random.below(256));
    if (random.chance(0.1)) header.step_mantissa = wild();
    if (random.chance(0.1)) header.step_exponent = random.between(-170, 110);
    if (random.chance(0.1)) header.origin[random.below(3)] = static_cast<std::int64_t>(wild());
    if (random.chance(0.1)) header.extent[random.below(3)] = wild();
    if (random.chance(0.1)) header.base_vertex_count = wild();
    if (random.chance(0.1)) header.base_face_count = wild();
    if (random.chance(0.3)) header.level_count = static_cast<std::uint8_t>(random.below(17));
    header.step_codes.assign(header.level_count, 60);
    header.quality_layer_count = static_cast<std::uint8_t>(random.below(18));
    if (header.flags & 8) {
      for (int k = 1; k < header.quality_layer_count; ++k)
        header.ratios.push_back(static_cast<std::uint8_t>(random.below(random.chance(0.1) ? 20 : 6)));
    }
    for (int l = 0; l < header.level_count; ++l)
      header.tensions.push_back(static_cast<std::uint8_t>(random.below(random.chance(0.05) ? 12 : 9)));
    if (random.chance(0.1)) header.row_count = random.below(4);
    if (random.chance(0.1)) header.rows[0].size = wild();
    if (random.chance(0.1)) header.rows[0].level = static_cast<std::uint8_t>(random.below(16));
    if (random.chance(0.1)) header.extra = Bytes(1 + random.below(3));
    Bytes bytes = header.bytes();
    if (random.chance(0.2)) bytes[5 + random.below(bytes.size() - 5)] ^= 0x80;  // misspelt or longer numbers
    if (random.chance(0.9)) repair_checksums(bytes.data(), bytes.size());
    INFO("seed " << seed);
    REQUIRE(difference(bytes, nmc_default_limits()) == "");
  }
}
