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
inline Status cut_behind(std::span<const std::uint8_t> bytes, std::uint32_t last_row,
                         Array<std::uint8_t>& result) {
  std::size_t header_size = 0;
  Header header;
  NMC_TRY(measure_header(bytes.data(), bytes.size(), header_size));
  NMC_TRY(parse_header(bytes.data(), header_size, header));
  std::size_t end = header_size;
  for (std::uint32_t i = 0; i <= last_row; ++i) end += static_cast<std::size_t>(header.layers[i].size);
  result.clear();
  if (!header.layers.resize(last_row + 1)) return no_memory();
  NMC_TRY(write_header(header, result));
  return result.append(bytes.data() + header_size, end - header_size) ? ok_status() : no_memory();
}

}  // namespace nmc

#endif  // NMC_DECODER_TOOL_CUT_STREAM_H_
