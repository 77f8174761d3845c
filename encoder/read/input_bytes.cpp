// SPDX-License-Identifier: Apache-2.0
#include "encoder/read/input_bytes.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "encoder/core/error.h"

namespace nmc {

namespace {

[[noreturn]] void fail(const std::string& path, const char* what, int error_number) {
  throw Error(ExitCode::kInputOutput, fmt::format("{}: {}: {}", path, what, std::strerror(error_number)));
}

class Descriptor {
 public:
  explicit Descriptor(int value) : value_(value) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (value_ > STDERR_FILENO) ::close(value_);
  }
  int get() const { return value_; }

 private:
  int value_;
};

std::vector<std::byte> read_to_end(int descriptor, const std::string& path) {
  std::vector<std::byte> bytes;
  std::size_t used = 0;
  for (;;) {
    if (bytes.size() - used < (std::size_t{1} << 16)) bytes.resize(used + used / 2 + (std::size_t{1} << 18));
    const ssize_t count = ::read(descriptor, bytes.data() + used, bytes.size() - used);
    if (count == 0) break;
    if (count > 0) {
      used += static_cast<std::size_t>(count);
    } else if (errno != EINTR) {
      fail(path, "cannot be read", errno);
    }
  }
  bytes.resize(used);
  return bytes;
}

}  // namespace

InputBytes InputBytes::open(const std::string& path) {
  InputBytes input;
  if (path == "-") {
    input.copy_ = read_to_end(STDIN_FILENO, "standard input");
    return input;
  }
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.get() < 0) fail(path, "cannot be opened", errno);
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) fail(path, "cannot be opened", errno);
  if (S_ISDIR(status.st_mode)) fail(path, "cannot be read", EISDIR);
  if (!S_ISREG(status.st_mode) || status.st_size == 0) {
    input.copy_ = read_to_end(file.get(), path);
    return input;
  }
  const auto size = static_cast<std::size_t>(status.st_size);
  void* const mapping = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.get(), 0);
  if (mapping == MAP_FAILED) {  // some network file systems cannot map
    input.copy_ = read_to_end(file.get(), path);
    return input;
  }
  ::madvise(mapping, size, MADV_SEQUENTIAL);
  input.mapping_ = mapping;
  input.mapping_size_ = size;
  return input;
}

InputBytes::InputBytes(InputBytes&& other) noexcept
    : mapping_(std::exchange(other.mapping_, nullptr)),
      mapping_size_(std::exchange(other.mapping_size_, 0)),
      copy_(std::move(other.copy_)) {}

InputBytes& InputBytes::operator=(InputBytes&& other) noexcept {
  if (this != &other) {
    release();
    mapping_ = std::exchange(other.mapping_, nullptr);
    mapping_size_ = std::exchange(other.mapping_size_, 0);
    copy_ = std::move(other.copy_);
  }
  return *this;
}

InputBytes::~InputBytes() { release(); }

void InputBytes::release() {
  if (mapping_ != nullptr) ::munmap(mapping_, mapping_size_);
  mapping_ = nullptr;
}

std::span<const std::byte> InputBytes::bytes() const {
  if (mapping_ != nullptr) return {static_cast<const std::byte*>(mapping_), mapping_size_};
  return copy_;
}

}  // namespace nmc
