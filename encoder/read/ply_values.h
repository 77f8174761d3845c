// SPDX-License-Identifier: Apache-2.0
// The body of a PLY file as a sequence of values, alike for text and for both byte orders, so that the reader
// of elements is written once.
#ifndef NMC_ENCODER_READ_PLY_VALUES_H_
#define NMC_ENCODER_READ_PLY_VALUES_H_

#include <fmt/format.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>

#include "encoder/read/binary_load.h"
#include "encoder/read/ply_header.h"
#include "encoder/read/source.h"
#include "encoder/read/text_numbers.h"

namespace nmc {

/// Binary values. Every access is checked against the end of the data.
template <std::endian kOrder>
class PlyBinaryValues {
 public:
  static constexpr bool kIsText = false;

  PlyBinaryValues(const Source& source, const char* body) : source_(source), at_(body), end_(source.end()) {}

  void begin_row() {}
  void end_row() {}
  std::uint64_t bytes_left() const { return static_cast<std::uint64_t>(end_ - at_); }

  /// `count` values of `type` are about to be read or skipped; fails where the file holds fewer. Called
  /// before anything of that size is allocated.
  void expect(std::uint64_t count, PlyType type) {
    if (count > bytes_left() / size_of(type))
      fail(fmt::format("a list of {} values where the file ends after {} bytes", count, bytes_left()));
  }

  double real(PlyType type) {
    switch (type) {
      case PlyType::kFloat32:
        return next<float>();
      case PlyType::kFloat64:
        return next<double>();
      default:
        return static_cast<double>(integer(type));
    }
  }

  std::int64_t integer(PlyType type) {
    switch (type) {
      case PlyType::kInt8:
        return next<std::int8_t>();
      case PlyType::kUint8:
        return next<std::uint8_t>();
      case PlyType::kInt16:
        return next<std::int16_t>();
      case PlyType::kUint16:
        return next<std::uint16_t>();
      case PlyType::kInt32:
        return next<std::int32_t>();
      case PlyType::kUint32:
        return next<std::uint32_t>();
      case PlyType::kFloat32:
      case PlyType::kFloat64:
        break;
    }
    const double value = real(type);
    if (!(value >= -9.0e15 && value <= 9.0e15) ||
        value != static_cast<double>(static_cast<std::int64_t>(value)))
      fail("a real number where an index is expected");
    return static_cast<std::int64_t>(value);
  }

  void skip(std::uint64_t count, PlyType type) {
    expect(count, type);
    at_ += count * size_of(type);
  }

  [[noreturn]] void fail(const std::string& reason) const { source_.fail_at_byte(at_, reason); }

 private:
  template <class T>
  T next() {
    if (static_cast<std::size_t>(end_ - at_) < sizeof(T)) fail("the file ends within an element");
    const T value = load<T>(at_, kOrder);
    at_ += sizeof(T);
    return value;
  }

  const Source& source_;
  const char* at_;
  const char* end_;
};

/// Text values, one element a line. Blank lines are skipped; a line with too few values fails there and does
/// not shift all later ones; surplus values are counted in surplus_lines().
class PlyTextValues {
 public:
  static constexpr bool kIsText = true;

  PlyTextValues(const Source& source, const char* body)
      : source_(source), lines_(body, source.end()), at_(body) {}

  void begin_row() {
    std::string_view line;
    do {
      if (!lines_.next(line)) source_.fail_at_line(source_.end(), "the file ends before its last element");
      at_ = line.data();
      stop_ = line.data() + line.size();
      skip_blanks(at_, stop_);
    } while (at_ == stop_);
  }

  void end_row() {
    skip_blanks(at_, stop_);
    if (at_ != stop_) ++surplus_lines_;
  }

  std::uint64_t bytes_left() const {
    return static_cast<std::uint64_t>(lines_.end() - lines_.position()) + 1;
  }

  void expect(std::uint64_t count, PlyType) {
    if (count > static_cast<std::uint64_t>(stop_ - at_ + 1) / 2)
      fail(fmt::format("a list of {} values on a line that has not as many", count));
  }

  double real(PlyType) {
    double value = 0;
    before_value();
    if (!parse_real(at_, stop_, value) || !ends_token(at_, stop_)) fail_value("is not a number");
    return value;
  }

  std::int64_t integer(PlyType) {
    std::int64_t value = 0;
    before_value();
    if (!parse_integer(at_, stop_, value) || !ends_token(at_, stop_)) fail_value("is not an integer");
    return value;
  }

  void skip(std::uint64_t count, PlyType) {
    for (; count > 0; --count) {
      before_value();
      take_token(at_, stop_);
    }
  }

  [[noreturn]] void fail(const std::string& reason) const { source_.fail_at_line(at_, reason); }
  std::uint64_t surplus_lines() const { return surplus_lines_; }

 private:
  void before_value() {
    skip_blanks(at_, stop_);
    value_ = at_;
    if (at_ == stop_) fail("the line has fewer values than the header announces");
  }

  [[noreturn]] void fail_value(const char* what) const {
    const char* end = value_;
    const std::string_view token = take_token(end, stop_);
    source_.fail_at_line(value_, fmt::format("'{}' {}", token.substr(0, 40), what));
  }

  const Source& source_;
  LineReader lines_;
  const char* at_;
  const char* stop_ = nullptr;
  const char* value_ = nullptr;
  std::uint64_t surplus_lines_ = 0;
};

}  // namespace nmc

#endif  // NMC_ENCODER_READ_PLY_VALUES_H_
