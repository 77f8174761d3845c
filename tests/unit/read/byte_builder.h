// SPDX-License-Identifier: Apache-2.0
// Binary files for tests, in either byte order.
#ifndef NMC_TESTS_UNIT_READ_BYTE_BUILDER_H_
#define NMC_TESTS_UNIT_READ_BYTE_BUILDER_H_

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <initializer_list>
#include <string>
#include <string_view>

namespace nmc::test {

/// Binary data piece by piece.
class Bytes {
 public:
  explicit Bytes(bool big_endian = false) : big_endian_(big_endian) {}

  Bytes& text(std::string_view text) {
    bytes_ += text;
    return *this;
  }

  template <class T>
  Bytes& number(T value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    if (big_endian_) std::reverse(raw, raw + sizeof value);
    bytes_.append(raw, sizeof value);
    return *this;
  }

  template <class T>
  Bytes& numbers(std::initializer_list<T> values) {
    for (const T value : values) number(value);
    return *this;
  }

  const std::string& string() const { return bytes_; }
  std::size_t size() const { return bytes_.size(); }

 private:
  bool big_endian_;
  std::string bytes_;
};

}  // namespace nmc::test

#endif  // NMC_TESTS_UNIT_READ_BYTE_BUILDER_H_
