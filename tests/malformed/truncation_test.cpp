// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>

#include "tests/malformed/tiny_streams.h"
#include "tests/support/stream_decoding.h"

using namespace nmc;
using namespace nmc::test;

namespace {

/// Rows of the table that the first `size` bytes hold.
std::size_t complete_rows(const GeneratedStream& stream, std::size_t size) {
  std::size_t count = 0;
  while (count < stream.layers.size() && stream.layers[count].end_offset <= size) ++count;
  return count;
}

}  // namespace

TEST_CASE("truncation: every prefix gives exactly the rows that the table promises",
          "[malformed][truncation]") {
  std::vector<GeneratedStream> streams = tiny_streams();
  for (std::uint64_t seed = 1; seed <= 8; ++seed) streams.push_back(generate(random_recipe(seed)));
  for (std::uint64_t seed = 9; seed <= 12; ++seed) {
    StreamRecipe recipe = random_recipe(seed);
    recipe.attribute_count = static_cast<int>(seed % 4) + 1;
    streams.push_back(generate(recipe));
  }
  for (const GeneratedStream& stream : streams) {
    for (std::size_t size = 0; size < stream.bytes.size(); ++size) {
      const Decoding decoding = decode({stream.bytes.data(), size});
      INFO(stream.name << ", " << size << " of " << stream.bytes.size() << " bytes: " << decoding);
      REQUIRE(decoding.status == NMC_ERR_TRUNCATED);
      REQUIRE(decoding.error.byte_offset == size);
      REQUIRE(decoding.layers.size() == complete_rows(stream, size));
      for (std::size_t i = 0; i < decoding.layers.size(); ++i) {
        REQUIRE(decoding.layers[i].state_hash == stream.layers[i].state_hash);
        REQUIRE(decoding.layers[i].position_hash == stream.layers[i].position_hash);
        REQUIRE(decoding.layers[i].attribute_hashes == stream.layers[i].attribute_hashes);
      }
    }
  }
}

TEST_CASE("truncation: bytes behind the last row are an error, and the mesh stands",
          "[malformed][truncation]") {
  for (const GeneratedStream& stream : tiny_streams()) {
    std::vector<std::uint8_t> longer = stream.bytes;
    longer.push_back(0);
    for (const std::vector<std::size_t>& pieces :
         {std::vector<std::size_t>{longer.size()}, {stream.bytes.size(), 1}, {1}}) {
      const Decoding decoding = decode(longer, pieces);
      INFO(stream.name << ": " << decoding);
      CHECK(decoding.status == NMC_ERR_CORRUPT);
      CHECK(decoding.error.byte_offset == stream.bytes.size());
      CHECK(decoding.has_ended);
      CHECK(decoding.layers.size() == stream.layers.size());
    }
  }
}

TEST_CASE("splits: any pieces give the same events", "[malformed][splits]") {
  for (const GeneratedStream& stream : tiny_streams()) {
    const Decoding whole = decode(stream.bytes);
    REQUIRE(whole.status == NMC_OK);
    for (std::size_t size = 1; size <= 40; ++size) {
      const Decoding pieces = decode(stream.bytes, {size});
      INFO(stream.name << " in pieces of " << size << ":\n" << pieces << "\nwhole:\n" << whole);
      CHECK(pieces == whole);
    }
    for (std::size_t cut = 0; cut < stream.bytes.size(); ++cut) {
      CHECK(decode(stream.bytes, {cut, stream.bytes.size()}) == whole);
    }
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
      RandomIntegers random(seed);
      std::vector<std::size_t> sizes;
      for (std::size_t sum = 0; sum < stream.bytes.size(); sum += sizes.back())
        sizes.push_back(random.below(30));
      CHECK(decode(stream.bytes, sizes) == whole);
    }
  }
}

TEST_CASE("reset: a decoder can be used again from every point of a stream", "[malformed][reset]") {
  const std::vector<GeneratedStream> streams = tiny_streams();
  nmc_decoder* decoder = nullptr;
  REQUIRE(nmc_decoder_create(&decoder, nullptr, nullptr) == NMC_OK);
  for (std::size_t i = 0; i < streams.size(); ++i) {
    const GeneratedStream& first = streams[i];
    const GeneratedStream& second = streams[(i + 1) % streams.size()];
    const Decoding expected = decode(second.bytes);
    for (std::size_t size = 0; size <= first.bytes.size(); size += 7) {
      std::vector<std::uint8_t> start(first.bytes.begin(),
                                      first.bytes.begin() + static_cast<std::ptrdiff_t>(size));
      if (size > 60) start[size - 1] ^= 0x55;  // reset ends errors too
      decode_with(decoder, start);
      REQUIRE(nmc_decoder_reset(decoder) == NMC_OK);
      const Decoding decoding = decode_with(decoder, second.bytes);
      INFO(first.name << " up to " << size << ", then " << second.name << ": " << decoding);
      REQUIRE(decoding == expected);
      REQUIRE(nmc_decoder_reset(decoder) == NMC_OK);
    }
  }
  nmc_decoder_destroy(&decoder);
}
