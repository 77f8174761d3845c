// SPDX-License-Identifier: Apache-2.0
// Any split of any bytes gives the same rows and the same error, in a new decoder and after a reset in the
// middle of another stream. The last four bytes choose the splits.
#include "tests/fuzz/stream_fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace nmc;
  if (size < 4) return 0;
  const std::uint8_t* choice = data + size - 4;
  const std::span<const std::uint8_t> bytes(data, size - 4);
  const nmc_limits limits = fuzz::limits();
  const test::Decoding whole = test::decode(bytes, {~std::size_t{0}}, &limits);
  const std::vector<std::size_t> pieces = {std::size_t{choice[0]}, std::size_t{choice[1]} * 4,
                                           std::size_t{choice[2]} + 1};
  nmc_decoder* decoder = nullptr;
  fuzz::require(nmc_decoder_create(&decoder, &limits, nullptr) == NMC_OK);
  fuzz::require(test::decode_with(decoder, bytes, pieces) == whole);
  fuzz::require(nmc_decoder_reset(decoder) == NMC_OK);
  const std::size_t cut = bytes.size() * choice[3] / 255;
  test::decode_with(decoder, bytes.first(cut), pieces);
  fuzz::require(nmc_decoder_reset(decoder) == NMC_OK);
  fuzz::require(test::decode_with(decoder, bytes) == whole);
  nmc_decoder_destroy(&decoder);
  return 0;
}
