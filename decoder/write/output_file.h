// SPDX-License-Identifier: Apache-2.0
// Output that is either complete under its name or not there at all.
#ifndef NMC_DECODER_WRITE_OUTPUT_FILE_H_
#define NMC_DECODER_WRITE_OUTPUT_FILE_H_

#include <cstddef>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

namespace nmc {

/// Writes to "PATH.part" and renames it to PATH in commit(); without a commit, or after any error, the part
/// file is removed and whatever was at PATH stays. "-" is standard output. A path that exists and is no
/// regular file (a device, a pipe) is written in place; a symbolic link keeps being one and its target is
/// replaced.
///
/// Errors are sticky: write() may be called on, and commit() reports the first one. Not for use from two
/// threads.
class OutputFile {
 public:
  explicit OutputFile(const std::string& path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(const void* bytes, std::size_t size);
  void write(std::string_view text) { write(text.data(), text.size()); }

  bool is_good() const { return error_.empty(); }

  /// Flushes, closes and renames. False with the reason in error() where anything went wrong since
  /// construction.
  [[nodiscard]] bool commit();

  /// "PATH: what: the system's reason", or empty.
  const std::string& error() const { return error_; }

  /// Makes SIGINT, SIGTERM and SIGHUP remove the part files of this process before they end it. Called by
  /// main() of a tool; covers the one file that was opened last and is not committed yet.
  static void remove_part_file_on_signals();

 private:
  void fail(const char* what, int error_number);
  void discard();

  std::string shown_path_;
  std::string final_path_;
  std::string part_path_;  // empty: written in place
  std::FILE* file_ = nullptr;
  std::vector<char> buffer_;
  std::string error_;
};

}  // namespace nmc

#endif  // NMC_DECODER_WRITE_OUTPUT_FILE_H_
