// SPDX-License-Identifier: Apache-2.0
// A stream cut behind a complete row, as nmc-trim does, is a stream: it decodes to the same rows.
#include "decoder/tool/cut_stream.h"
#include "tests/fuzz/stream_fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace nmc;
  const nmc_limits limits = fuzz::limits();
  const std::span<const std::uint8_t> bytes(data, size);
  const test::Decoding whole = test::decode(bytes, {~std::size_t{0}}, &limits);
  for (std::uint32_t row = 0; row < whole.layers.size() && row < 4; ++row) {
    Array<std::uint8_t> cut;
    fuzz::require(cut_behind(bytes, row, cut).ok());
    const test::Decoding decoding = test::decode({cut.data(), cut.size()}, {~std::size_t{0}}, &limits);
    // A shorter header can leave a level without the bytes that let it be large (spec 8.2).
    if (decoding.status == NMC_ERR_LIMIT) continue;
    fuzz::require(decoding.status == NMC_OK && decoding.layers.size() == row + 1);
    for (std::uint32_t i = 0; i <= row; ++i) {
      fuzz::require(decoding.layers[i].state_hash == whole.layers[i].state_hash);
      fuzz::require(decoding.layers[i].position_hash == whole.layers[i].position_hash ||
                    decoding.layers[i].position_hash == 0);
    }
  }
  return 0;
}
