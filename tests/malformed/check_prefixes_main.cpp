// SPDX-License-Identifier: Apache-2.0
// Cuts streams and checks that what is left decodes to the last row that the table promises, with the bits it
// has in the whole stream. Streams below 20,000 bytes are cut at every byte, others at 512 places and around
// the end of each row. Usage: check_prefixes STREAM.nmc...
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <set>
#include <vector>

#include "tests/support/stream_decoding.h"

namespace {

using nmc::test::current_row;
using nmc::test::DecodedLayer;

struct Outcome {
  nmc_status status = NMC_OK;
  std::uint64_t error_offset = 0;
  std::size_t row_count = 0;
  DecodedLayer last;  // the last complete row
};

/// `rows`: where each row is to be described; null: the last one only.
Outcome decode(const std::vector<std::uint8_t>& stream, std::size_t size, std::vector<DecodedLayer>* rows) {
  Outcome outcome;
  nmc_decoder* decoder = nullptr;
  if (nmc_decoder_create(&decoder, nullptr, nullptr) != NMC_OK) return outcome;
  nmc_decoder_feed(decoder, stream.data(), size);
  nmc_event event = NMC_EVENT_HEADER;
  while ((outcome.status = nmc_decoder_next(decoder, &event)) == NMC_OK) {
    if (event != NMC_EVENT_LAYER) continue;
    ++outcome.row_count;
    if (rows) rows->push_back(current_row(decoder));
  }
  if (outcome.status == NMC_NEED_MORE_INPUT) outcome.status = nmc_decoder_finish(decoder);
  nmc_error_detail error;
  nmc_decoder_error(decoder, &error);
  outcome.error_offset = error.byte_offset;
  if (outcome.row_count > 0) outcome.last = current_row(decoder);
  nmc_decoder_destroy(&decoder);
  return outcome;
}

std::set<std::size_t> cuts(std::size_t size, const std::vector<DecodedLayer>& rows) {
  std::set<std::size_t> result;
  const std::size_t step = size < 20000 ? 1 : size / 512;
  for (std::size_t cut = 0; cut < size; cut += step) result.insert(cut);
  for (const DecodedLayer& row : rows) {
    for (std::uint64_t cut = row.end_offset - 2; cut <= row.end_offset + 2 && cut < size; ++cut)
      result.insert(cut);
  }
  return result;
}

}  // namespace

int main(int argument_count, char** arguments) {
  std::size_t failures = 0, prefix_count = 0;
  for (int i = 1; i < argument_count; ++i) {
    std::ifstream file(arguments[i], std::ios::binary);
    const std::vector<std::uint8_t> stream{std::istreambuf_iterator<char>(file), {}};
    std::vector<DecodedLayer> rows;
    if (stream.empty() || decode(stream, stream.size(), &rows).status == NMC_ERR_TRUNCATED || rows.empty()) {
      std::printf("%s is no complete stream\n", arguments[i]);
      ++failures;
      continue;
    }
    const std::set<std::size_t> places = cuts(stream.size(), rows);
    for (const std::size_t size : places) {
      const Outcome outcome = decode(stream, size, nullptr);
      std::size_t promised = 0;
      while (promised < rows.size() && rows[promised].end_offset <= size) ++promised;
      const bool is_right = outcome.status == NMC_ERR_TRUNCATED && outcome.error_offset == size &&
                            outcome.row_count == promised &&
                            (promised == 0 || outcome.last == rows[promised - 1]);
      if (is_right) continue;
      ++failures;
      std::printf("%s cut at %zu: %s at %llu, %zu rows of %zu promised, bits %s\n", arguments[i], size,
                  nmc_status_name(outcome.status), static_cast<unsigned long long>(outcome.error_offset),
                  outcome.row_count, promised,
                  promised > 0 && outcome.last == rows[promised - 1] ? "equal" : "not equal");
    }
    prefix_count += places.size();
    std::printf("%s: %zu bytes, %zu rows, %zu prefixes\n", arguments[i], stream.size(), rows.size(),
                places.size());
    std::fflush(stdout);
  }
  std::printf("%d streams, %zu prefixes, %zu failures\n", argument_count - 1, prefix_count, failures);
  return failures == 0 && argument_count > 1 ? 0 : 1;
}
