// SPDX-License-Identifier: Apache-2.0
// A shorter stream from a longer one, without encoding anew: cut behind a row of the layer table, under a
// header that is written for what is left.
#ifndef NMC_DECODER_TOOL_CUT_STREAM_H_
#define NMC_DECODER_TOOL_CUT_STREAM_H_

#include <cstdint>
#include <span>

#include "libnmc/decode/header_parser.h"
#include "libnmc/encode/stream_writer.h"

namespace nmc {

/// The rows 0 ... last_row of the stream in `bytes`, which hold them whole. `result` is replaced. Fails with
/// the status of the header, or with kNoMemory. Linear in the size of the result.
/// The rows up to `last_row`, without those of regions that `keeps(region)` says no to. From the first row that is
/// left out on no error is stated.
template <class Keeps>
Status cut_to_regions(std::span<const std::uint8_t> bytes, std::uint32_t last_row, const Keeps& keeps,
                      Array<std::uint8_t>& result) {
  std::size_t header_size = 0;
  Header header;
  NMC_TRY(measure_header(bytes.data(), bytes.size(), header_size));
  NMC_TRY(parse_header(bytes.data(), header_size, header));
  Array<std::uint8_t> chunks;
  std::size_t begin = header_size, kept = 0;
  bool is_part = false;
  for (std::uint32_t i = 0; i <= last_row; ++i) {
    LayerEntry row = header.layers[i];
    const auto size = static_cast<std::size_t>(row.size);
    const bool is_kept = row.region == 0 || keeps(row.region - 1u);
    is_part = is_part || !is_kept;
    if (is_kept) {
      if (is_part) row.rms_error = row.max_error = kUnknownError;
      if (!chunks.append(bytes.data() + begin, size)) return no_memory();
      header.layers[kept++] = row;
    }
    begin += size;
  }
  header.layers.truncate(kept);
  NMC_TRY(write_header(header, result));
  return result.append(chunks.data(), chunks.size()) ? ok_status() : no_memory();
}

inline Status cut_behind(std::span<const std::uint8_t> bytes, std::uint32_t last_row,
                         Array<std::uint8_t>& result) {
  return cut_to_regions(bytes, last_row, [](std::uint32_t) { return true; }, result);
}

}  // namespace nmc

#endif  // NMC_DECODER_TOOL_CUT_STREAM_H_
