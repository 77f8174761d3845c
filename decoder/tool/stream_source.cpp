// SPDX-License-Identifier: Apache-2.0
#include "decoder/tool/stream_source.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "decoder/tool/tool_error.h"

namespace nmc {

InputFile::InputFile(const std::string& path) : name_(path == "-" ? "standard input" : path) {
  file_ = path == "-" ? stdin : std::fopen(path.c_str(), "rb");
  if (!file_) {
    throw ToolError(ToolExit::kInputOutput, name_ + ": cannot be opened: " + std::strerror(errno));
  }
}

InputFile::~InputFile() {
  if (file_ && file_ != stdin) std::fclose(file_);
}

std::size_t InputFile::read(std::uint8_t* bytes, std::size_t capacity) {
  const std::size_t size = std::fread(bytes, 1, capacity, file_);
  if (size == 0 && std::ferror(file_)) {
    throw ToolError(ToolExit::kInputOutput, name_ + ": cannot be read: " + std::strerror(errno));
  }
  return size;
}

std::vector<std::uint8_t> read_file(const std::string& path) {
  InputFile input(path);
  std::vector<std::uint8_t> bytes;
  for (std::size_t size = 0;; bytes.resize(size)) {
    bytes.resize(size + (1 << 18));
    const std::size_t count = input.read(bytes.data() + size, 1 << 18);
    size += count;
    if (count == 0) {
      bytes.resize(size);
      return bytes;
    }
  }
}

StreamOutcome decode_stream(StreamReader& reader, InputFile& input, const StreamVisitor& visitor) {
  StreamOutcome outcome;
  std::uint8_t bytes[1 << 15];
  std::uint32_t last_row = ~std::uint32_t{0};
  // With `skips` no byte is read beyond the row at hand.
  const auto leave_out = [&](std::uint64_t size) {
    while (size > 0) {
      const std::size_t count = input.read(bytes, static_cast<std::size_t>(std::min<std::uint64_t>(size, sizeof bytes)));
      if (count == 0) return;
      size -= count;
      outcome.bytes_read += count;
    }
  };
  std::uint64_t row_end = visitor.skips ? 0 : ~std::uint64_t{0};
  const auto begin_row = [&]() -> nmc_status {
    nmc_layer row{};
    while (visitor.skips && reader.layer(outcome.layers_complete, row) == NMC_OK) {
      row_end = row.end_offset;
      if (!visitor.skips(row)) return NMC_OK;
      const nmc_status skipped = reader.skip_layer();
      if (skipped != NMC_OK) return skipped;
      leave_out(row_end - outcome.bytes_read);
      ++outcome.layers_complete;
    }
    return NMC_OK;
  };
  while (true) {
    nmc_event event{};
    outcome.status = reader.next(event);
    if (outcome.status == NMC_NEED_MORE_INPUT) {
      // The header's size is in its first bytes; it is read byte by byte.
      const std::uint64_t end = !visitor.skips || outcome.has_info ? row_end : outcome.bytes_read + 1;
      const std::uint64_t left = std::min(visitor.largest_size, end) - outcome.bytes_read;
      const std::size_t size =
          input.read(bytes, static_cast<std::size_t>(std::min<std::uint64_t>(left, sizeof bytes)));
      outcome.bytes_read += size;
      outcome.status = size > 0 ? reader.feed(std::span<const std::uint8_t>(bytes, size)) : reader.finish();
      if (outcome.status != NMC_OK || size == 0) return outcome;
    } else if (outcome.status != NMC_OK) {
      return outcome;
    } else if (event == NMC_EVENT_HEADER) {
      outcome.has_info = reader.info(outcome.info) == NMC_OK;
      if (visitor.on_header) last_row = visitor.on_header(outcome.info);
      outcome.status = begin_row();
      if (outcome.status != NMC_OK) return outcome;
    } else if (event == NMC_EVENT_LAYER) {
      ++outcome.layers_complete;
      nmc_layer layer{};
      if (visitor.on_layer && reader.current_layer(layer) == NMC_OK) visitor.on_layer(layer);
      if (outcome.layers_complete > last_row) return outcome;
      outcome.status = begin_row();
      if (outcome.status != NMC_OK) return outcome;
    }
  }
}

std::string error_text(const nmc_error_detail& detail) {
  std::string text = "offset " + std::to_string(detail.byte_offset);
  if (*detail.spec_section) text += std::string(", section ") + detail.spec_section + " of the format";
  return text + ": " + (*detail.message ? detail.message : nmc_status_name(detail.status));
}

}  // namespace nmc
