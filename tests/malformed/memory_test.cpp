// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cstdlib>

#include "tests/malformed/tiny_streams.h"
#include "tests/support/header_bytes.h"
#include "tests/support/stream_decoding.h"

using namespace nmc;
using namespace nmc::test;

namespace {

/// Fails at the k-th allocation and counts what is not given back.
struct FailingAllocator {
  long remaining = 0;
  long count = 0;
  long live = 0;

  nmc_allocator functions() {
    return {[](void* user, size_t size) -> void* {
              auto& self = *static_cast<FailingAllocator*>(user);
              ++self.count;
              if (self.remaining-- == 0) return nullptr;
              ++self.live;
              return std::malloc(size);
            },
            [](void* user, void* pointer) {
              --static_cast<FailingAllocator*>(user)->live;
              std::free(pointer);
            },
            this};
  }
};

/// Everything a client does with a stream, with an allocator that fails once at allocation `k`.
nmc_status decode_failing_at(const std::vector<std::uint8_t>& bytes, long k, FailingAllocator& allocator,
                             Decoding& decoding, bool& read_failed, bool& was_reached) {
  allocator.remaining = k;
  const nmc_allocator functions = allocator.functions();
  nmc_decoder* decoder = nullptr;
  decoding.status = nmc_decoder_create(&decoder, nullptr, &functions);
  if (decoding.status != NMC_OK) {
    was_reached = true;
    REQUIRE(decoder == nullptr);
    return decoding.status;
  }
  decoding = decode_with(decoder, bytes, {11});
  for (const DecodedLayer& layer : decoding.layers) read_failed |= layer.position_hash == 0;
  REQUIRE(mesh_is_sound(decoder, 2));
  nmc_info info{};
  if (nmc_decoder_info(decoder, &info) == NMC_OK && info.region_count > 0) {
    std::vector<std::uint8_t> regions(info.base_face_count);
    nmc_decoder_read_regions(decoder, regions.data(), info.base_face_count);
  }
  was_reached = allocator.remaining < 0;
  // What failed once works after a reset.
  REQUIRE(nmc_decoder_reset(decoder) == NMC_OK);
  allocator.remaining = -1;
  REQUIRE(decode_with(decoder, bytes).status == NMC_OK);
  nmc_decoder_destroy(&decoder);
  return decoding.status;
}

}  // namespace

TEST_CASE("allocation failure: at every allocation a clean status, nothing lost, and a reset helps",
          "[malformed][memory]") {
  for (const GeneratedStream& stream : tiny_streams()) {
    long k = 0;
    for (bool was_reached = true; was_reached; ++k) {
      REQUIRE(k < 10000);
      FailingAllocator allocator;
      Decoding decoding;
      bool read_failed = false;
      const nmc_status status =
          decode_failing_at(stream.bytes, k, allocator, decoding, read_failed, was_reached);
      INFO(stream.name << ", allocation " << k << ": " << decoding);
      REQUIRE(allocator.live == 0);
      REQUIRE((status == NMC_OK || status == NMC_ERR_NO_MEMORY));
      if (!was_reached) {
        CHECK(status == NMC_OK);
        CHECK(!read_failed);
        CHECK(decoding.layers.size() == stream.layers.size());
      }
    }
    INFO(stream.name << ": " << k << " allocations");
    CHECK(k > 30);
  }
}

TEST_CASE("hostile counts: a hundred bytes cannot make the decoder hold a mebibyte", "[malformed][memory]") {
  std::uint64_t worst = 0;
  const auto try_stream = [&](Bytes bytes) {
    nmc_decoder* decoder = nullptr;
    REQUIRE(nmc_decoder_create(&decoder, nullptr, nullptr) == NMC_OK);
    decode_with(decoder, bytes);
    for (std::uint32_t level = 0; level < 14; ++level) mesh_is_sound(decoder, level);
    std::uint64_t peak = 0;
    nmc_decoder_memory(decoder, nullptr, &peak);
    worst = std::max(worst, peak);
    INFO(bytes.size() << " bytes, peak " << peak);
    CHECK(peak <= 1u << 20);
    nmc_decoder_destroy(&decoder);
  };
  for (const std::uint64_t face_count : {4ull, 100ull, 1000ull, 1500ull, 3000ull, 100000ull, 1ull << 29}) {
    for (const std::uint64_t vertex_count : {face_count, 3 * face_count, face_count / 2 + 2}) {
      for (std::uint64_t seed = 0; seed < 60; ++seed) {
        HeaderFields header;
        header.base_face_count = face_count;
        header.base_vertex_count = std::max<std::uint64_t>(vertex_count, 3);
        header.level_count = seed % 3 == 0 ? 0 : 2;
        header.step_codes.assign(header.level_count, 64);
        RandomIntegers random(seed + 1);
        Bytes payload(30 - 5 * header.level_count);
        for (std::uint8_t& byte : payload) {
          byte = seed == 0   ? std::uint8_t{0}
                 : seed == 1 ? std::uint8_t{255}
                             : static_cast<std::uint8_t>(random.below(256));
        }
        const Bytes base = chunk(1, payload);
        const Bytes level = chunk(3, {0, 0, 1, 0, 0});
        header.rows[0].size = base.size();
        if (header.level_count > 0) {
          header.rows.push_back({level.size(), 1, 1, 1});
          header.row_count = 2;
        }
        Bytes bytes = header.bytes();
        bytes.insert(bytes.end(), base.begin(), base.end());
        if (header.level_count > 0) bytes.insert(bytes.end(), level.begin(), level.end());
        REQUIRE(bytes.size() <= 100);
        try_stream(bytes);
      }
    }
  }
  // A good base mesh, with as many levels of zeros as the rest of the bytes allows.
  StreamRecipe recipe;
  recipe.density = 0;
  recipe.largest_coordinate = 1;
  recipe.level_count = 3;
  recipe.one_layer_per_chunk = false;
  const GeneratedStream stream = generate(recipe);
  INFO(stream.bytes.size() << " bytes");
  try_stream(stream.bytes);
  WARN("largest peak " << worst << " bytes");
}

TEST_CASE("hostile sizes: rows and chunks that promise gigabytes cost nothing until the bytes come",
          "[malformed][memory]") {
  HeaderFields header;
  header.rows[0].size = (std::uint64_t{1} << 40) - 1;
  Bytes bytes = header.bytes();
  bytes.push_back(1);
  put_varint(bytes, (1u << 30) - 1);
  const Decoding decoding = decode(bytes);
  INFO(decoding);
  CHECK(decoding.status == NMC_ERR_TRUNCATED);
  CHECK(decoding.peak_memory < 1u << 20);
  Bytes too_large = header.bytes();
  too_large.push_back(1);
  put_varint(too_large, (std::uint64_t{1} << 30) + 1);
  CHECK(decode(too_large).status == NMC_ERR_LIMIT);
}
