// SPDX-License-Identifier: Apache-2.0
// The library and the reference decoder agree about any bytes: rows, hashes, and the code, offset and section
// of the first error.
#include <cstdio>

#include "tests/fuzz/stream_fuzz.h"
#include "tests/support/reference_comparison.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace nmc;
  nmc_limits limits = nmc_default_limits();
  limits.max_vertices = 5000;
  std::vector<std::uint8_t> bytes(data, data + size);
  // Attributes (section 10) are left out by the reference decoder.
  const std::size_t flags = size > 5 && bytes[5] >= 128 ? 7 : 6;
  if (flags < size && (bytes[flags] & 2) != 0) return 0;
  const std::string difference = test::difference(bytes, limits);
  if (difference.empty()) return 0;
  std::fprintf(stderr, "%s\n", difference.c_str());
  std::abort();
}
