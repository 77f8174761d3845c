// SPDX-License-Identifier: Apache-2.0
#include "decoder/write/output_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <system_error>

namespace nmc {

namespace {

constexpr std::size_t kBufferSize = std::size_t{1} << 18;

// A signal handler may touch nothing but memory that is always there; hence a fixed array. The flag is set
// after the path is complete and cleared before it changes.
char g_part_path[4096];
volatile std::sig_atomic_t g_part_path_is_set = 0;

void remove_part_file_and_end(int signal_number) {
  if (g_part_path_is_set != 0) ::unlink(g_part_path);
  std::signal(signal_number, SIG_DFL);
  std::raise(signal_number);
}

void remember_part_path(const std::string& path) {
  g_part_path_is_set = 0;
  if (path.empty() || path.size() >= sizeof g_part_path) return;
  std::copy(path.begin(), path.end(), g_part_path);
  g_part_path[path.size()] = '\0';
  g_part_path_is_set = 1;
}

}  // namespace

OutputFile::OutputFile(const std::string& path) : shown_path_(path), final_path_(path) {
  if (path == "-") {
    shown_path_ = "standard output";
    final_path_.clear();
    file_ = stdout;
    return;
  }
  std::error_code ignored;
  const std::filesystem::path canonical = std::filesystem::canonical(path, ignored);
  if (!ignored) final_path_ = canonical.string();
  const std::filesystem::file_status status = std::filesystem::status(final_path_, ignored);
  const bool replaces = !std::filesystem::exists(status) || std::filesystem::is_regular_file(status);
  if (replaces) part_path_ = final_path_ + ".part";
  const std::string& opened = replaces ? part_path_ : final_path_;
  const int descriptor = ::open(opened.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor < 0) {
    part_path_.clear();
    fail("cannot be opened for writing", errno);
    return;
  }
  remember_part_path(part_path_);
  file_ = ::fdopen(descriptor, "wb");
  if (file_ == nullptr) {
    fail("cannot be opened for writing", errno);
    ::close(descriptor);
    return;
  }
  buffer_.resize(kBufferSize);
  std::setvbuf(file_, buffer_.data(), _IOFBF, buffer_.size());
}

OutputFile::~OutputFile() { discard(); }

void OutputFile::write(const void* bytes, std::size_t size) {
  if (!is_good() || size == 0) return;
  if (std::fwrite(bytes, 1, size, file_) != size) fail("cannot be written", errno);
}

bool OutputFile::commit() {
  if (!is_good()) return false;
  if (file_ == nullptr) return false;
  if (std::fflush(file_) != 0) {
    fail("cannot be written", errno);
    return false;
  }
  std::FILE* const file = file_;
  file_ = nullptr;
  if (file != stdout && std::fclose(file) != 0) {
    fail("cannot be written", errno);
    return false;
  }
  if (part_path_.empty()) return true;
  if (std::rename(part_path_.c_str(), final_path_.c_str()) != 0) {
    fail("cannot be renamed from its .part file", errno);
    return false;
  }
  remember_part_path("");
  part_path_.clear();
  return true;
}

void OutputFile::remove_part_file_on_signals() {
  for (const int signal_number : {SIGINT, SIGTERM, SIGHUP})
    std::signal(signal_number, remove_part_file_and_end);
}

void OutputFile::fail(const char* what, int error_number) {
  if (error_.empty()) error_ = shown_path_ + ": " + what + ": " + std::strerror(error_number);
  discard();
}

void OutputFile::discard() {
  if (file_ != nullptr && file_ != stdout) std::fclose(file_);
  file_ = nullptr;
  if (part_path_.empty()) return;
  ::unlink(part_path_.c_str());
  remember_part_path("");
  part_path_.clear();
}

}  // namespace nmc
