// SPDX-License-Identifier: Apache-2.0
#include "encoder/read/ply_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <string_view>
#include <utility>

#include "encoder/read/text_numbers.h"

namespace nmc {

namespace {

constexpr std::size_t kMaximumQuoted = 40;
constexpr std::size_t kMaximumName = 255;

std::string quoted(std::string_view text) {
  return fmt::format("'{}{}'", text.substr(0, kMaximumQuoted), text.size() > kMaximumQuoted ? "..." : "");
}

std::optional<PlyType> ply_type(std::string_view name) {
  static constexpr std::array<std::pair<std::string_view, PlyType>, 16> kNames = {{
      {"char", PlyType::kInt8},
      {"int8", PlyType::kInt8},
      {"uchar", PlyType::kUint8},
      {"uint8", PlyType::kUint8},
      {"short", PlyType::kInt16},
      {"int16", PlyType::kInt16},
      {"ushort", PlyType::kUint16},
      {"uint16", PlyType::kUint16},
      {"int", PlyType::kInt32},
      {"int32", PlyType::kInt32},
      {"uint", PlyType::kUint32},
      {"uint32", PlyType::kUint32},
      {"float", PlyType::kFloat32},
      {"float32", PlyType::kFloat32},
      {"double", PlyType::kFloat64},
      {"float64", PlyType::kFloat64},
  }};
  for (const auto& [text, type] : kNames)
    if (text == name) return type;
  return std::nullopt;
}

class HeaderParser {
 public:
  explicit HeaderParser(const Source& source) : source_(source), at_(source.begin()) {}

  PlyHeader parse() {
    expect_magic();
    bool has_format = false;
    while (next_line()) {
      const std::string_view keyword = word();
      if (keyword == "end_header") {
        if (!has_format) fail("the header states no format");
        header_.body = at_;
        return std::move(header_);
      }
      if (keyword == "format") {
        parse_format();
        has_format = true;
      } else if (keyword == "element") {
        parse_element();
      } else if (keyword == "property") {
        parse_property();
      } else if (keyword == "comment") {
        if (word() == "TextureFile") header_.texture_files.emplace_back(rest_of_line());
      } else if (!keyword.empty() && keyword != "obj_info") {
        fail("unknown keyword " + quoted(keyword) + " in the header");
      }
    }
    source_.fail_at_line(source_.end(), "the file ends before 'end_header'");
  }

 private:
  [[noreturn]] void fail(const std::string& reason) const { source_.fail_at_line(line_begin_, reason); }

  /// The end of the first line settles how all header lines end. It matters for "end_header" of a binary
  /// file, where the byte after a carriage return may already be data.
  void expect_magic() {
    const std::string_view start(source_.begin(), std::min<std::size_t>(source_.data.size(), 5));
    if (start.starts_with("ply\r\n")) {
      line_end_ = "\r\n";
    } else if (start.starts_with("ply\n")) {
      line_end_ = "\n";
    } else if (start.starts_with("ply\r")) {
      line_end_ = "\r";
    } else {
      source_.fail_at_byte(source_.begin(), "not a PLY file: it does not begin with a line 'ply'");
    }
    at_ += 3 + line_end_.size();
  }

  bool next_line() {
    const std::string_view rest(at_, static_cast<std::size_t>(source_.end() - at_));
    // A line may end in a bare line feed even where the first did not.
    const std::size_t length = rest.find(line_end_ == "\r" ? '\r' : '\n');
    if (length == std::string_view::npos) return false;
    line_begin_ = word_ = at_;
    line_stop_ = at_ + length;
    at_ = line_stop_ + 1;
    return true;
  }

  std::string_view word() {
    skip_blanks(word_, line_stop_);
    return take_token(word_, line_stop_);
  }

  std::string_view rest_of_line() {
    skip_blanks(word_, line_stop_);
    std::string_view rest(word_, static_cast<std::size_t>(line_stop_ - word_));
    while (!rest.empty() && is_blank(rest.back())) rest.remove_suffix(1);
    return rest.substr(0, kMaximumName);
  }

  void parse_format() {
    const std::string_view name = word();
    if (name == "ascii") {
      header_.encoding = PlyEncoding::kText;
    } else if (name == "binary_little_endian") {
      header_.encoding = PlyEncoding::kLittleEndian;
    } else if (name == "binary_big_endian") {
      header_.encoding = PlyEncoding::kBigEndian;
    } else {
      fail("unknown format " + quoted(name));
    }
    const std::string_view version = word();
    if (version != "1.0") fail("PLY version " + quoted(version) + " where only '1.0' exists");
  }

  void parse_element() {
    PlyElement element;
    element.name = word();
    element.declared_at = line_begin_;
    const std::string_view count = word();
    const auto [stop, error] = std::from_chars(count.data(), count.data() + count.size(), element.count);
    if (element.name.empty() || error != std::errc() || stop != count.data() + count.size())
      fail("element " + quoted(element.name) + " has the count " + quoted(count));
    for (const PlyElement& other : header_.elements)
      if (other.name == element.name) fail("element " + quoted(element.name) + " is declared twice");
    header_.elements.push_back(std::move(element));
  }

  void parse_property() {
    if (header_.elements.empty()) fail("a property before the first element");
    PlyProperty property;
    std::string_view type = word();
    if (type == "list") {
      property.is_list = true;
      const std::string_view count_type = word();
      const std::optional<PlyType> parsed = ply_type(count_type);
      if (!parsed || is_real(*parsed)) fail("a list cannot be counted in the type " + quoted(count_type));
      property.count_type = *parsed;
      type = word();
    }
    const std::optional<PlyType> parsed = ply_type(type);
    if (!parsed) fail("unknown property type " + quoted(type));
    property.type = *parsed;
    property.name = word();
    if (property.name.empty()) fail("a property without a name");
    header_.elements.back().properties.push_back(std::move(property));
  }

  const Source& source_;
  const char* at_;
  std::string_view line_end_;
  const char* line_begin_ = nullptr;
  const char* line_stop_ = nullptr;
  const char* word_ = nullptr;
  PlyHeader header_;
};

}  // namespace

std::size_t size_of(PlyType type) {
  switch (type) {
    case PlyType::kInt8:
    case PlyType::kUint8:
      return 1;
    case PlyType::kInt16:
    case PlyType::kUint16:
      return 2;
    case PlyType::kInt32:
    case PlyType::kUint32:
    case PlyType::kFloat32:
      return 4;
    case PlyType::kFloat64:
      return 8;
  }
  return 0;
}

std::size_t PlyElement::minimum_size(bool is_text) const {
  std::size_t size = 0;
  for (const PlyProperty& property : properties)
    size += is_text ? 2 : size_of(property.is_list ? property.count_type : property.type);
  return size;
}

PlyHeader parse_ply_header(const Source& source) { return HeaderParser(source).parse(); }

}  // namespace nmc
