// SPDX-License-Identifier: Apache-2.0
// Any bytes end in a sound mesh or a clean error, and what a decoder holds stays within its limit.
#include "tests/fuzz/stream_fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace nmc;
  const nmc_limits limits = fuzz::limits();
  nmc_decoder* decoder = nullptr;
  fuzz::require(nmc_decoder_create(&decoder, &limits, nullptr) == NMC_OK);
  const test::Decoding decoding = test::decode_with(decoder, {data, size});
  fuzz::require(decoding.peak_memory <= limits.max_memory);
  for (std::uint32_t level = 0; level <= 4; ++level) fuzz::require(test::mesh_is_sound(decoder, level));
  fuzz::require((decoding.status == NMC_OK) == decoding.has_ended || decoding.status == NMC_ERR_CORRUPT);
  nmc_decoder_destroy(&decoder);
  return 0;
}
