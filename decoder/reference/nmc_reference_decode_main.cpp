// SPDX-License-Identifier: Apache-2.0
// nmc-reference-decode FILE...: what the reference decoder finds, one line per row of the layer table
//     row END LEVEL STATE_HASH POSITION_HASH INDEX_HASH
// and at last "OK", or the code, offset and section of the first error (spec 1.3). Exit code 0 when all files
// are whole.
#include <cinttypes>
#include <cstdio>
#include <fstream>
#include <iterator>

#include "decoder/reference/reference_decoder.h"

int main(int argument_count, char** arguments) {
  if (argument_count < 2) {
    std::fprintf(stderr, "usage: nmc-reference-decode FILE...\n");
    return 1;
  }
  int exit_code = 0;
  for (int i = 1; i < argument_count; ++i) {
    std::ifstream file(arguments[i], std::ios::binary);
    if (!file) {
      std::fprintf(stderr, "nmc-reference-decode: %s cannot be read\n", arguments[i]);
      return 2;
    }
    const std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(file),
                                          std::istreambuf_iterator<char>()};
    const nmc_reference::Decoding decoding = nmc_reference::decode(bytes);
    if (argument_count > 2) std::printf("%s\n", arguments[i]);
    for (const nmc_reference::Row& row : decoding.rows) {
      std::printf("row %" PRIu64 " %u %016" PRIx64 " %016" PRIx64 " %016" PRIx64 "\n", row.end_offset,
                  row.level, row.state_hash, row.position_hash, row.index_hash);
    }
    if (decoding.code == nmc_reference::Code::kOk) {
      std::printf("OK\n");
    } else {
      std::printf("%s %" PRIu64 " %s\n", nmc_reference::name_of(decoding.code), decoding.offset,
                  decoding.section.c_str());
      exit_code = 3;
    }
  }
  return exit_code;
}
