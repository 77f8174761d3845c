// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/read_fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return nmc::fuzz_read(nmc::MeshFormat::kOff, data, size);
}
