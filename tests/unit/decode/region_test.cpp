// SPDX-License-Identifier: Apache-2.0
// Regions of a stream: fetched alone, left out, and what that leaves.
#include <catch2/catch.hpp>
#include <cstring>
#include <set>
#include <vector>

#include "decoder/tool/cut_stream.h"
#include "libnmc/include/nmc/nmc.hpp"
#include "tests/support/stream_decoding.h"
#include "tests/support/stream_generator.h"

using namespace nmc;
using namespace nmc::test;

namespace {

GeneratedStream divided_stream(std::uint64_t seed, int quality_layers = 1) {
  StreamRecipe recipe;
  recipe.base = grid(6, 5, true);
  recipe.level_count = 3;
  recipe.quality_layer_count = quality_layers;
  recipe.largest_coordinate = 1000;
  recipe.tangential_density = 0.1;
  recipe.region_count = 4;
  recipe.regions_share_rows = false;
  recipe.seed = seed;
  return generate(recipe);
}

/// A reader that is fed the rows that `wants(row)` says yes to, and skips the others.
template <class Wants>
void read_rows(const GeneratedStream& stream, const Wants& wants, StreamReader& reader) {
  nmc_event event{};
  nmc_info info{};
  std::size_t at = 0;
  while (reader.next(event) == NMC_NEED_MORE_INPUT) REQUIRE(reader.feed(std::span(stream.bytes).subspan(at++, 1)) == NMC_OK);
  REQUIRE(reader.info(info) == NMC_OK);
  REQUIRE(at == info.header_size);
  for (std::uint32_t i = 0; i < info.layer_count; ++i) {
    nmc_layer row{};
    REQUIRE(reader.layer(i, row) == NMC_OK);
    if (wants(row)) {
      REQUIRE(reader.feed(std::span(stream.bytes).subspan(at, row.end_offset - at)) == NMC_OK);
      REQUIRE(reader.next(event) == NMC_OK);
      REQUIRE(event == NMC_EVENT_LAYER);
    } else {
      REQUIRE(reader.skip_layer() == NMC_OK);
    }
    at = row.end_offset;
  }
  REQUIRE(reader.next(event) == NMC_OK);
  REQUIRE(event == NMC_EVENT_END);
}

std::vector<float> offsets_of(StreamReader& reader, std::uint32_t level) {
  std::uint32_t vertex_count = 0, face_count = 0;
  REQUIRE(reader.mesh_size(level, vertex_count, face_count) == NMC_OK);
  std::vector<float> offsets(vertex_count);
  REQUIRE(nmc_decoder_read_offsets(reader.get(), level, offsets.data(), nullptr, vertex_count) == NMC_OK);
  return offsets;
}

}  // namespace

TEST_CASE("regions: one fetched alone has the offsets that it has in the whole, and the others have none", "[regions]") {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const GeneratedStream stream = divided_stream(seed, seed % 3 == 0 ? 2 : 1);
    StreamReader whole, part;
    read_rows(stream, [](const nmc_layer&) { return true; }, whole);
    read_rows(stream, [](const nmc_layer& row) { return row.region <= 0; }, part);
    const std::vector<float> all = offsets_of(whole, 3), some = offsets_of(part, 3);
    std::size_t equal = 0, missing = 0, other = 0;
    for (std::size_t v = 0; v < all.size(); ++v)
      ++(some[v] == all[v] ? equal : some[v] == 0 ? missing : other);
    INFO("seed " << seed << ": " << equal << " equal, " << missing << " missing, " << other << " other");
    CHECK(other == 0);
    CHECK(equal > 0);
  }
}

TEST_CASE("regions: rows left out while reading, or cut out of the file, leave the same mesh", "[regions]") {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const GeneratedStream stream = divided_stream(seed, seed % 2 == 0 ? 3 : 1);
    StreamReader skipping;
    read_rows(stream, [](const nmc_layer& row) { return row.region != 1; }, skipping);
    nmc_info info{};
    REQUIRE(skipping.info(info) == NMC_OK);
    Array<std::uint8_t> bytes;
    REQUIRE(cut_to_regions(stream.bytes, info.layer_count - 1, [](std::uint32_t region) { return region != 1; }, bytes)
                .ok());
    StreamReader cut;
    REQUIRE(cut.feed(std::span<const std::uint8_t>(bytes.data(), bytes.size())) == NMC_OK);
    nmc_event event{};
    while (cut.next(event) == NMC_OK) {
    }
    REQUIRE(cut.finish() == NMC_OK);
    std::uint64_t a = 0, b = 0;
    REQUIRE(skipping.position_hash(3, a) == NMC_OK);
    REQUIRE(cut.position_hash(3, b) == NMC_OK);
    INFO("seed " << seed);
    CHECK(a == b);
    REQUIRE(skipping.state_hash(a) == NMC_OK);
    REQUIRE(cut.state_hash(b) == NMC_OK);
    CHECK(a == b);
  }
}

TEST_CASE("regions: every base face lies in one, and every one has faces", "[regions]") {
  StreamReader reader;
  std::vector<std::uint8_t> regions(60);
  CHECK(reader.read_regions(regions) == NMC_ERR_ARGUMENT);
  read_rows(divided_stream(3), [](const nmc_layer&) { return true; }, reader);
  REQUIRE(reader.read_regions(regions) == NMC_OK);
  CHECK(std::set<int>(regions.begin(), regions.end()) == std::set<int>{0, 1, 2, 3});
  std::vector<std::uint8_t> too_few(59);
  CHECK(reader.read_regions(too_few) == NMC_ERR_ARGUMENT);
}

TEST_CASE("regions: only a region's row of which nothing has been fed can be left out", "[regions]") {
  const GeneratedStream stream = divided_stream(5);
  StreamReader reader;
  nmc_event event{};
  nmc_layer row{};
  CHECK(reader.skip_layer() == NMC_ERR_STATE);
  REQUIRE(reader.feed(std::span(stream.bytes)) == NMC_OK);
  REQUIRE(reader.next(event) == NMC_OK);
  CHECK(reader.skip_layer() == NMC_ERR_STATE);  // the base mesh
  std::uint32_t i = 0;
  while (reader.layer(i, row) == NMC_OK && row.region < 0) {
    REQUIRE(reader.next(event) == NMC_OK);
    ++i;
  }
  REQUIRE(row.region >= 0);
  CHECK(reader.skip_layer() == NMC_ERR_STATE);  // its bytes are there
  while (reader.next(event) == NMC_OK) {
  }
  CHECK(reader.finish() == NMC_OK);
  CHECK(reader.skip_layer() == NMC_ERR_STATE);  // no row is left
}
