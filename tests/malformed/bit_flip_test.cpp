// SPDX-License-Identifier: Apache-2.0
// Bits changed on their way are found by checksums; the second half repairs the checksums, as a hostile
// writer would, so that what is inside the chunks is reached.
#include <catch2/catch.hpp>

#include "tests/malformed/tiny_streams.h"
#include "tests/support/repair_checksums.h"
#include "tests/support/stream_decoding.h"

using namespace nmc;
using namespace nmc::test;

namespace {

/// Decodes and draws whatever is left of the mesh; the limits keep hostile counts small.
Decoding decode_and_look(const std::vector<std::uint8_t>& bytes) {
  nmc_limits limits = nmc_default_limits();
  limits.max_memory = 8 << 20;
  nmc_decoder* decoder = nullptr;
  REQUIRE(nmc_decoder_create(&decoder, &limits, nullptr) == NMC_OK);
  const Decoding decoding = decode_with(decoder, bytes);
  for (std::uint32_t level = 0; level <= 3; ++level) CHECK(mesh_is_sound(decoder, level));
  nmc_decoder_destroy(&decoder);
  return decoding;
}

}  // namespace

TEST_CASE("bit flips: each is found, and the rows before it stand", "[malformed][flips]") {
  for (const GeneratedStream& stream : tiny_streams()) {
    const Decoding whole = decode(stream.bytes);
    for (std::size_t i = 0; i < stream.bytes.size(); ++i) {
      for (int bit = 0; bit < 8; ++bit) {
        std::vector<std::uint8_t> changed = stream.bytes;
        changed[i] = static_cast<std::uint8_t>(changed[i] ^ (1u << bit));
        const Decoding decoding = decode_and_look(changed);
        INFO(stream.name << ", byte " << i << " bit " << bit << ": " << decoding);
        REQUIRE(decoding.status < 0);
        REQUIRE(decoding.layers.size() < whole.layers.size());
        for (std::size_t k = 0; k < decoding.layers.size(); ++k)
          REQUIRE(decoding.layers[k] == whole.layers[k]);
        std::size_t untouched = 0;
        while (untouched < stream.layers.size() && stream.layers[untouched].end_offset <= i) ++untouched;
        REQUIRE(decoding.layers.size() == untouched);
      }
    }
  }
}

TEST_CASE("bit flips: with checksums repaired every outcome is a sound mesh or a clean error",
          "[malformed][flips]") {
  int errors = 0, meshes = 0;
  for (const GeneratedStream& stream : tiny_streams()) {
    for (std::size_t i = 5; i < stream.bytes.size(); ++i) {
      for (int bit = 0; bit < 8; ++bit) {
        std::vector<std::uint8_t> changed = stream.bytes;
        changed[i] = static_cast<std::uint8_t>(changed[i] ^ (1u << bit));
        repair_checksums(changed.data(), changed.size());
        const Decoding decoding = decode_and_look(changed);
        (decoding.status == NMC_OK ? meshes : errors) += 1;
      }
    }
  }
  INFO(errors << " errors, " << meshes << " meshes");
  CHECK(errors > 500);
  CHECK(meshes > 500);
}

TEST_CASE("random bytes in place of payloads: a sound mesh or a clean error", "[malformed][flips]") {
  for (const GeneratedStream& stream : tiny_streams()) {
    for (std::uint64_t seed = 1; seed <= 1500; ++seed) {
      RandomIntegers random(seed);
      std::vector<std::uint8_t> changed = stream.bytes;
      const std::size_t count = 1 + random.below(30);
      for (std::size_t k = 0; k < count; ++k) {
        changed[5 + random.below(changed.size() - 5)] = static_cast<std::uint8_t>(random.below(256));
      }
      if (random.chance(0.9)) repair_checksums(changed.data(), changed.size());
      decode_and_look(changed);
    }
  }
}
