// SPDX-License-Identifier: Apache-2.0
// Numbers and lines of text files. Parsing of reals is fast_float's; what the files of this field add to it
// (a leading plus sign, the "1.#QNAN" of old Microsoft run-times) is here.
#ifndef NMC_ENCODER_READ_TEXT_NUMBERS_H_
#define NMC_ENCODER_READ_TEXT_NUMBERS_H_

#include <fast_float/fast_float.h>

#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string_view>

namespace nmc {

inline bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }

inline void skip_blanks(const char*& at, const char* end) {
  while (at < end && is_blank(*at)) ++at;
}

/// True where a number may end: at a blank, a line feed or the end of the text.
inline bool ends_token(const char* at, const char* end) { return at == end || is_blank(*at) || *at == '\n'; }

/// The characters up to the next blank, line feed or end; moves `at` behind them.
inline std::string_view take_token(const char*& at, const char* end) {
  const char* const begin = at;
  while (!ends_token(at, end)) ++at;
  return {begin, static_cast<std::size_t>(at - begin)};
}

/// Parses a real number, "nan" and "inf" in their usual spellings included, and moves `at` behind it. False
/// without a number, and `at` stays. Does not look at what follows the number.
inline bool parse_real(const char*& at, const char* end, double& value) {
  const char* begin = at;
  if (begin < end && *begin == '+') ++begin;
  const fast_float::from_chars_result result = fast_float::from_chars(begin, end, value);
  if (result.ptr == begin) return false;
  if (result.ec != std::errc() && result.ec != std::errc::result_out_of_range) return false;
  at = result.ptr;
  if (at < end && *at == '#') {
    const bool negative = *begin == '-';
    const std::string_view kind = take_token(at, end);
    value = kind.starts_with("#INF") ? std::numeric_limits<double>::infinity()
                                     : std::numeric_limits<double>::quiet_NaN();
    if (negative) value = -value;
  }
  return true;
}

/// Parses a decimal integer and moves `at` behind it; "3.0" and "3e0" are accepted as 3 because some writers
/// print every number as a real. False without an integer of 64 bits.
inline bool parse_integer(const char*& at, const char* end, std::int64_t& value) {
  const char* begin = at;
  if (begin < end && *begin == '+') ++begin;
  const std::from_chars_result result = std::from_chars(begin, end, value);
  if (result.ec != std::errc()) return false;
  if (result.ptr < end && (*result.ptr == '.' || *result.ptr == 'e' || *result.ptr == 'E')) {
    double real = 0;
    const char* real_end = at;
    if (!parse_real(real_end, end, real) || std::abs(real) > 9.0e15 || real != std::trunc(real)) return false;
    value = static_cast<std::int64_t>(real);
    at = real_end;
    return true;
  }
  at = result.ptr;
  return true;
}

/// Steps through text line by line. Lines end in LF, CR LF or, in a file without any LF, CR.
class LineReader {
 public:
  LineReader(const char* begin, const char* end)
      : at_(begin),
        end_(end),
        terminator_(std::memchr(begin, '\n', static_cast<std::size_t>(end - begin)) != nullptr ? '\n'
                                                                                               : '\r') {}

  /// Sets `line` to the next line without its end; a CR before the LF stays and counts as a blank. False at
  /// the end of the text.
  bool next(std::string_view& line) {
    if (at_ == end_) return false;
    const void* const found = std::memchr(at_, terminator_, static_cast<std::size_t>(end_ - at_));
    const char* const stop = found != nullptr ? static_cast<const char*>(found) : end_;
    line = {at_, static_cast<std::size_t>(stop - at_)};
    at_ = found != nullptr ? stop + 1 : end_;
    return true;
  }

  const char* position() const { return at_; }
  const char* end() const { return end_; }

 private:
  const char* at_;
  const char* end_;
  char terminator_;
};

}  // namespace nmc

#endif  // NMC_ENCODER_READ_TEXT_NUMBERS_H_
