// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "encoder/read/face_list.h"
#include "encoder/read/format_readers.h"
#include "encoder/read/text_numbers.h"
#include "encoder/read/vertex_colors.h"

namespace nmc {

namespace {

constexpr std::size_t kMaximumUnknownKeywords = 16;

/// Statements that carry nothing of the surface, and how they are reported.
constexpr std::array<std::pair<std::string_view, std::string_view>, 9> kUnusedStatements = {{
    {"vt", "texture coordinates (wedge textures are not carried)"},
    {"vn", "corner normals (computed from the surface)"},
    {"vp", "parameter-space vertices (curves and patches are not read)"},
    {"g", "group names (one surface is carried)"},
    {"o", "object names (one surface is carried)"},
    {"s", "smoothing groups"},
    {"usemtl", "material references (materials are not carried)"},
    {"l", "line elements (only faces are read)"},
    {"p", "point elements (only faces are read)"},
}};

int hexadecimal_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

class ObjReader {
 public:
  ObjReader(const Source& source, const ReadOptions& options) : source_(source), options_(options) {}

  TriangleMesh read() {
    const char* begin = source_.begin();
    if (std::string_view(begin, source_.data.size()).starts_with("\xef\xbb\xbf")) begin += 3;
    LineReader lines(begin, source_.end());
    std::string_view line;
    while (lines.next(line)) {
      line_begin_ = line.data();
      if (ends_in_backslash(line)) line = joined(line, lines);
      at_ = line.data();
      end_ = at_ + line.size();
      read_statement();
    }
    if (mesh_.positions.empty())
      source_.fail_at_line(source_.end(), "the file has no vertices: not one line begins with 'v'");
    if (highest_index_ >= mesh_.positions.size())
      source_.fail_at_line(highest_index_line_, fmt::format("vertex index {}, but there are {} vertices",
                                                            highest_index_ + 1, mesh_.positions.size()));
    faces_.finish(mesh_);
    finish_colors();
    report_unused();
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void fail(const std::string& reason) const { source_.fail_at_line(line_begin_, reason); }

  static bool ends_in_backslash(std::string_view line) {
    while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
    return !line.empty() && line.back() == '\\';
  }

  std::string_view joined(std::string_view line, LineReader& lines) {
    joined_.clear();
    bool more = true;
    while (more) {
      more = ends_in_backslash(line);
      joined_.append(line.substr(0, more ? line.rfind('\\') : line.size()));
      joined_.push_back(' ');
      if (more && !lines.next(line)) break;
    }
    return joined_;
  }

  bool at_end_of_statement() {
    skip_blanks(at_, end_);
    return at_ == end_ || *at_ == '#';
  }

  void read_statement() {
    skip_blanks(at_, end_);
    if (at_ == end_) return;
    if (*at_ == '#') {
      read_comment();
      return;
    }
    const std::string_view keyword = take_token(at_, end_);
    if (keyword == "v") {
      read_vertex();
    } else if (keyword == "f" || keyword == "fo") {
      read_face();
    } else {
      note_unused(keyword);
    }
  }

  void read_vertex() {
    std::array<double, 8> values{};
    std::size_t count = 0;
    while (!at_end_of_statement()) {
      const char* token = at_;
      double value = 0;
      if (!parse_real(at_, end_, value) || !ends_token(at_, end_))
        fail(fmt::format("'{}' is not a number", take_token(token, end_).substr(0, 40)));
      if (count < values.size()) values[count] = value;
      ++count;
    }
    if (count < 3) fail(fmt::format("a vertex of {} coordinates", count));
    if (mesh_.positions.size() >= options_.maximum_vertices)
      source_.fail_at_line(
          line_begin_, fmt::format("more than {} vertices, which is the limit", options_.maximum_vertices),
          ExitCode::kLimit);
    if (count == 6 || count == 7) {
      rgb_.resize(3 * mesh_.positions.size(), kNoColor);
      for (std::size_t k = 3; k < 6; ++k) rgb_.push_back(static_cast<float>(values[k]));
    }
    opacities_ += count == 7;
    weights_ += count == 4 && values[3] != 1;
    surplus_ += count == 5 || count > 7;
    mesh_.positions.push_back({values[0], values[1], values[2]});
  }

  void read_face() {
    corners_.clear();
    while (!at_end_of_statement()) {
      const char* token = at_;
      std::int64_t index = 0;
      const auto [stop, error] = std::from_chars(at_, end_, index);
      at_ = stop;
      if (error != std::errc() || !(ends_token(at_, end_) || *at_ == '/'))
        fail(fmt::format("'{}' is not a vertex reference", take_token(token, end_).substr(0, 40)));
      take_token(at_, end_);
      corners_.push_back(resolved(index));
    }
    if (corners_.empty()) fail("a face without corners");
    faces_.add(corners_);
    if (faces_.triangle_count() > options_.maximum_triangles)
      source_.fail_at_line(
          line_begin_, fmt::format("more than {} triangles, which is the limit", options_.maximum_triangles),
          ExitCode::kLimit);
  }

  /// 1-based from the first vertex, or backwards from the last one so far. A positive index may point to a
  /// vertex still to come; the highest one is checked at the end of the file.
  std::uint32_t resolved(std::int64_t index) {
    if (index == 0) fail("vertex index 0, but OBJ counts from 1");
    const auto count = static_cast<std::int64_t>(mesh_.positions.size());
    if (index < -count)
      fail(
          fmt::format("vertex index {}, but only {} vertices come before it", index, mesh_.positions.size()));
    const std::int64_t zero_based = index > 0 ? index - 1 : count + index;
    if (zero_based > 0xfffffffe) fail(fmt::format("vertex index {} is above the limit", index));
    if (highest_index_line_ == nullptr || static_cast<std::uint64_t>(zero_based) > highest_index_) {
      highest_index_ = static_cast<std::uint64_t>(zero_based);
      highest_index_line_ = line_begin_;
    }
    return static_cast<std::uint32_t>(zero_based);
  }

  /// ZBrush writes its colours as comments: "#MRGB " and up to 64 blocks MMRRGGBB, for the vertices in order.
  void read_comment() {
    if (take_token(at_, end_) != "#MRGB") return;
    skip_blanks(at_, end_);
    const std::string_view blocks = take_token(at_, end_);
    for (std::size_t i = 0; i + 8 <= blocks.size(); i += 8) {
      std::array<std::uint8_t, 4> bytes{};
      for (std::size_t k = 0; k < 4; ++k) {
        const int high = hexadecimal_digit(blocks[i + 2 * k]), low = hexadecimal_digit(blocks[i + 2 * k + 1]);
        if (high < 0 || low < 0) fail("a '#MRGB' block that is not hexadecimal");
        bytes[k] = static_cast<std::uint8_t>(16 * high + low);
      }
      polypaint_.push_back({bytes[1], bytes[2], bytes[3]});
    }
  }

  void note_unused(std::string_view keyword) {
    for (std::size_t i = 0; i < kUnusedStatements.size(); ++i) {
      if (kUnusedStatements[i].first == keyword) {
        ++unused_[i];
        return;
      }
    }
    const bool is_word = std::all_of(keyword.begin(), keyword.end(), [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
    });
    if (!is_word) fail(fmt::format("'{}' is not an OBJ statement", keyword.substr(0, 40)));
    if (keyword == "mtllib") return;
    if (unknown_.size() < kMaximumUnknownKeywords || unknown_.contains(std::string(keyword)))
      ++unknown_[std::string(keyword.substr(0, 40))];
  }

  void finish_colors() {
    const std::size_t count = mesh_.positions.size();
    if (holds_negative(rgb_)) {
      mesh_.dropped_properties.push_back(
          "three values behind the positions (some are negative, so no colours)");
    } else if (!rgb_.empty()) {
      rgb_.resize(3 * count, kNoColor);
      mesh_.colors = colors_from_unscaled(rgb_);
      for (std::size_t i = 0; i < count; ++i)
        if (std::isnan(rgb_[3 * i])) mesh_.colors[i] = {255, 255, 255};
    } else if (polypaint_.size() == count) {
      mesh_.colors = std::move(polypaint_);
    } else if (!polypaint_.empty()) {
      mesh_.dropped_properties.push_back(
          fmt::format("#MRGB colours ({} of them for {} vertices)", polypaint_.size(), count));
    }
  }

  void report_unused() {
    for (std::size_t i = 0; i < kUnusedStatements.size(); ++i)
      if (unused_[i] > 0)
        mesh_.dropped_properties.push_back(fmt::format("{} {}", unused_[i], kUnusedStatements[i].second));
    for (const auto& [keyword, count] : unknown_)
      mesh_.dropped_properties.push_back(fmt::format("{} statements '{}' (not read by nmc)", count, keyword));
    if (opacities_ > 0) mesh_.dropped_properties.push_back(fmt::format("{} vertex opacities", opacities_));
    if (weights_ > 0)
      mesh_.dropped_properties.push_back(fmt::format("{} vertex weights (of rational curves)", weights_));
    if (surplus_ > 0)
      mesh_.dropped_properties.push_back(fmt::format("surplus values of {} vertex lines", surplus_));
  }

  static constexpr float kNoColor = std::numeric_limits<float>::quiet_NaN();

  const Source& source_;
  const ReadOptions& options_;
  TriangleMesh mesh_;
  FaceList faces_;
  const char* at_ = nullptr;
  const char* end_ = nullptr;
  const char* line_begin_ = nullptr;  // of the statement; errors point here
  std::string joined_;
  std::vector<std::uint32_t> corners_;
  std::vector<float> rgb_;
  std::vector<std::array<std::uint8_t, 3>> polypaint_;
  std::uint64_t highest_index_ = 0;
  const char* highest_index_line_ = nullptr;
  std::array<std::uint64_t, kUnusedStatements.size()> unused_{};
  std::map<std::string, std::uint64_t> unknown_;
  std::uint64_t opacities_ = 0, weights_ = 0, surplus_ = 0;
};

}  // namespace

TriangleMesh read_obj(const Source& source, const ReadOptions& options) {
  return ObjReader(source, options).read();
}

}  // namespace nmc
