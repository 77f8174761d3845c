// SPDX-License-Identifier: Apache-2.0
// JSON, written in order: a decoder has no library for it, and needs no more than this.
#ifndef NMC_DECODER_TOOL_JSON_WRITER_H_
#define NMC_DECODER_TOOL_JSON_WRITER_H_

#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>
#include <type_traits>

namespace nmc {

/// Keys and values in the order of the calls; commas and indentation are put in. Every string comes out as
/// valid JSON in ASCII, whatever bytes it has: what is no UTF-8 becomes U+FFFD, control and non-ASCII
/// characters \u escapes.
class JsonWriter {
 public:
  explicit JsonWriter(bool is_compact) : is_compact_(is_compact) {}

  JsonWriter& key(std::string_view name) {
    separate();
    append_string(name);
    text_ += is_compact_ ? ":" : ": ";
    after_key_ = true;
    return *this;
  }
  void begin(char bracket) {
    separate();
    text_ += bracket;
    ++depth_;
    is_first_ = true;
  }
  void end(char bracket) {
    --depth_;
    if (!is_first_) new_line();
    text_ += bracket;
    is_first_ = false;
  }
  void value(std::string_view text) {
    separate();
    append_string(text);
  }
  void value(const char* text) { value(std::string_view(text)); }
  void value(bool flag) {
    separate();
    text_ += flag ? "true" : "false";
  }
  /// Numbers are the shortest that read back equal; JSON has no infinities, they become null.
  template <class Number>
  requires std::is_arithmetic_v<Number>
  void value(Number number) {
    separate();
    if (!std::isfinite(static_cast<double>(number))) {
      text_ += "null";
      return;
    }
    char digits[40];
    text_.append(digits, std::to_chars(digits, digits + sizeof digits, number).ptr);
  }
  template <class Value>
  void member(std::string_view name, const Value& v) {
    key(name).value(v);
  }
  const std::string& text() const { return text_; }

 private:
  void separate() {
    if (after_key_) {
      after_key_ = false;
      return;
    }
    if (!is_first_) text_ += ',';
    if (depth_ > 0) new_line();
    is_first_ = false;
  }
  void new_line() {
    if (is_compact_) return;
    text_ += '\n';
    text_.append(static_cast<std::size_t>(2 * depth_), ' ');
  }
  void append_code_unit(unsigned unit) {
    char escape[8];
    std::snprintf(escape, sizeof escape, "\\u%04x", unit);
    text_ += escape;
  }
  void append_code_point(unsigned point) {
    if (point >= 0x10000) {
      append_code_unit(0xd800 + ((point - 0x10000) >> 10));
      append_code_unit(0xdc00 + ((point - 0x10000) & 0x3ff));
    } else if (point < 0x20 || point > 0x7e) {
      append_code_unit(point);
    } else {
      if (point == '"' || point == '\\') text_ += '\\';
      text_ += static_cast<char>(point);
    }
  }
  void append_string(std::string_view s) {
    text_ += '"';
    for (std::size_t i = 0; i < s.size();) {
      const auto byte = static_cast<unsigned char>(s[i]);
      const int length = byte < 0x80                   ? 1
                         : byte >= 0xf0 && byte < 0xf5 ? 4
                         : byte >= 0xe0                ? 3
                         : byte >= 0xc2                ? 2
                                                       : 0;
      unsigned point = length <= 1 ? byte : byte & (0xffu >> (length + 1));
      bool is_valid = length > 0 && i + static_cast<std::size_t>(length) <= s.size() && byte < 0xf5;
      for (int k = 1; is_valid && k < length; ++k) {
        const auto next = static_cast<unsigned char>(s[i + static_cast<std::size_t>(k)]);
        is_valid = (next & 0xc0) == 0x80;
        point = (point << 6) | (next & 0x3fu);
      }
      is_valid = is_valid && !(point >= 0xd800 && point < 0xe000) && point < 0x110000 &&
                 !(length == 3 && point < 0x800) && !(length == 4 && point < 0x10000);
      append_code_point(is_valid ? point : 0xfffd);
      i += is_valid ? static_cast<std::size_t>(length) : 1;
    }
    text_ += '"';
  }

  bool is_compact_;
  bool is_first_ = true, after_key_ = false;
  int depth_ = 0;
  std::string text_;
};

}  // namespace nmc

#endif  // NMC_DECODER_TOOL_JSON_WRITER_H_
