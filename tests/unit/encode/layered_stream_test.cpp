// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>

#include "tests/support/stream_decoding.h"
#include "tests/support/stream_generator.h"

using namespace nmc;
using namespace nmc::test;

namespace {

void check_decodes_to(const GeneratedStream& stream) {
  const Decoding decoding = decode(stream.bytes);
  INFO(stream.name << ", " << stream.bytes.size() << " bytes: " << decoding);
  REQUIRE(decoding.status == NMC_OK);
  REQUIRE(decoding.layers.size() == stream.layers.size());
  for (std::size_t i = 0; i < stream.layers.size(); ++i) {
    INFO("row " << i << " of " << stream.layers.size());
    CHECK(decoding.layers[i].end_offset == stream.layers[i].end_offset);
    CHECK(decoding.layers[i].state_hash == stream.layers[i].state_hash);
    CHECK(decoding.layers[i].position_hash == stream.layers[i].position_hash);
  }
}

}  // namespace

TEST_CASE("stream: a decoder holds after every row what the encoder held", "[stream]") {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) check_decodes_to(generate(random_recipe(seed)));
}

TEST_CASE("stream: one to four quality layers", "[stream]") {
  for (int layers = 1; layers <= 4; ++layers) {
    StreamRecipe recipe;
    recipe.name = std::to_string(layers) + " layers";
    recipe.base = grid(4, 3, true);
    recipe.level_count = 3;
    recipe.quality_layer_count = layers;
    check_decodes_to(generate(recipe));
  }
}

TEST_CASE("stream: coefficients at both ends of their range, in every layer", "[stream]") {
  for (const double tangential : {0.0, 0.5}) {
    for (int layers = 1; layers <= 3; ++layers) {
      StreamRecipe recipe;
      recipe.name = "extremes";
      recipe.base = creased_bipyramid();
      recipe.level_count = 2;
      recipe.quality_layer_count = layers;
      recipe.density = 1;
      recipe.largest_coefficient = kMaximumMagnitude;
      recipe.tangential_density = tangential;
      recipe.seed = 17;
      check_decodes_to(generate(recipe));
    }
  }
}

TEST_CASE("stream: tangential lists, creases and curves together", "[stream]") {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    StreamRecipe recipe;
    recipe.name = "curves " + std::to_string(seed);
    recipe.base = grid(4, 3, false);
    recipe.level_count = 3;
    recipe.quality_layer_count = 1 + static_cast<int>(seed % 3);
    recipe.has_creases = true;
    recipe.tangential_density = seed % 2 ? 0.02 : 0.6;
    recipe.seed = seed;
    check_decodes_to(generate(recipe));
  }
}

TEST_CASE("stream: a level of zeros costs a few bytes", "[stream]") {
  StreamRecipe recipe;
  recipe.base = grid(6, 6, true);
  recipe.level_count = 4;
  recipe.density = 0;
  const GeneratedStream stream = generate(recipe);
  check_decodes_to(stream);
  const std::uint64_t finest = stream.layers[4].end_offset - stream.layers[3].end_offset;
  INFO("the finest level has " << 108 * 64 << " coefficients in " << finest << " bytes");
  CHECK(finest < 40);
}
