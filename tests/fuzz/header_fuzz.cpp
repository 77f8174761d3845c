// SPDX-License-Identifier: Apache-2.0
// A header that is accepted can be written again, and reads as the same numbers. The checksum is repaired
// here, so that every input reaches the fields.
#include "tests/fuzz/stream_fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace nmc;
  test::Bytes bytes(data, data + size);
  if (size >= 5) std::copy(kSignature, kSignature + 4, bytes.begin());
  test::repair_checksums(bytes.data(), bytes.size());
  std::size_t total_size = 0;
  if (!measure_header(bytes.data(), bytes.size(), total_size).ok() || total_size > bytes.size()) return 0;
  Header header, again;
  if (!parse_header(bytes.data(), total_size, header).ok()) return 0;
  fuzz::require(header.grid_step() > 0 && header.diagonal() >= 0);
  Array<std::uint8_t> written;
  fuzz::require(write_header(header, written).ok());
  std::size_t written_size = 0;
  fuzz::require(measure_header(written.data(), written.size(), written_size).ok());
  fuzz::require(written_size == written.size() && parse_header(written.data(), written_size, again).ok());
  fuzz::require(again.base_vertex_count == header.base_vertex_count &&
                again.level_count == header.level_count && again.layers.size() == header.layers.size() &&
                again.grid_step() == header.grid_step());
  for (std::size_t i = 0; i < header.layers.size(); ++i)
    fuzz::require(again.layers[i].size == header.layers[i].size &&
                  again.layers[i].level == header.layers[i].level);
  return 0;
}
