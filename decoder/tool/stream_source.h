// SPDX-License-Identifier: Apache-2.0
// A stream on its way from a file or a pipe through a decoder, as far as it is wanted.
#ifndef NMC_DECODER_TOOL_STREAM_SOURCE_H_
#define NMC_DECODER_TOOL_STREAM_SOURCE_H_

#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "libnmc/include/nmc/nmc.hpp"

namespace nmc {

/// Bytes of a file; "-" is standard input. Throws ToolError(kInputOutput).
class InputFile {
 public:
  explicit InputFile(const std::string& path);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  /// Up to `capacity` bytes; 0 at the end.
  std::size_t read(std::uint8_t* bytes, std::size_t capacity);
  /// "standard input" or the path.
  const std::string& name() const { return name_; }

 private:
  std::string name_;
  std::FILE* file_ = nullptr;
};

/// All bytes at once.
std::vector<std::uint8_t> read_file(const std::string& path);

/// How far a stream was decoded.
struct StreamOutcome {
  nmc_status status = NMC_OK;  // NMC_ERR_TRUNCATED when the input ended early
  bool has_info = false;
  nmc_info info{};
  std::uint32_t layers_complete = 0;
  std::uint64_t bytes_read = 0;
};

/// What to do on the way. `on_header` returns the index of the last row wanted; reading stops behind it.
/// Either may be empty.
struct StreamVisitor {
  std::function<std::uint32_t(const nmc_info&)> on_header;
  std::function<void(const nmc_layer&)> on_layer;
  std::uint64_t largest_size = ~std::uint64_t{0};  // bytes beyond are not read
  std::function<bool(const nmc_layer&)> skips;     // true: the bytes of this row, one of a region, are left out
};

/// Feeds `reader` from `input` until the last row wanted is complete, the input ends, or an error stands in
/// the way.
StreamOutcome decode_stream(StreamReader& reader, InputFile& input, const StreamVisitor& visitor);

/// "offset 1234, section 5.2 of the format: a sentence".
std::string error_text(const nmc_error_detail& detail);

}  // namespace nmc

#endif  // NMC_DECODER_TOOL_STREAM_SOURCE_H_
