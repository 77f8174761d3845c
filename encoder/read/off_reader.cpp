// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include "encoder/read/binary_load.h"
#include "encoder/read/face_list.h"
#include "encoder/read/format_readers.h"
#include "encoder/read/text_numbers.h"
#include "encoder/read/vertex_colors.h"

namespace nmc {

namespace {

constexpr std::uint64_t kMaximumCount = 0xfffffffeu;

struct OffHeader {
  bool has_texture_coordinates = false;  // ST
  bool has_colors = false;               // C
  bool has_normals = false;              // N
  bool is_binary = false;
  const char* body = nullptr;

  std::size_t values_without_color() const {
    return 3 + (has_normals ? 3u : 0u) + (has_texture_coordinates ? 2u : 0u);
  }
};

bool takes(std::string_view& text, std::string_view prefix) {
  if (!text.starts_with(prefix)) return false;
  text.remove_prefix(prefix.size());
  return true;
}

/// "[ST][C][N][4][n]OFF [BINARY]". The keyword is optional in the format's own definition, so a file may
/// begin with its counts at once; and a well-known data set has the counts right behind the keyword, as in
/// "OFF490 518 0".
OffHeader parse_header(const Source& source) {
  OffHeader header;
  const char* at = source.begin();
  if (std::string_view(at, source.data.size()).starts_with("\xef\xbb\xbf")) at += 3;
  for (;;) {
    while (at < source.end() && (is_blank(*at) || *at == '\n')) ++at;
    if (at == source.end() || *at != '#') break;
    while (at < source.end() && *at != '\n' && *at != '\r') ++at;
  }
  const char* after = at;
  std::string_view word = take_token(after, source.end());
  header.body = at;
  if (!word.empty() && word[0] >= '0' && word[0] <= '9' && !word.starts_with("4OFF") &&
      !word.starts_with("4nOFF"))
    return header;
  header.has_texture_coordinates = takes(word, "ST");
  header.has_colors = takes(word, "C");
  header.has_normals = takes(word, "N");
  const bool is_homogeneous = takes(word, "4");
  const bool is_n_dimensional = takes(word, "n");
  if (!takes(word, "OFF") || !(word.empty() || (word[0] >= '0' && word[0] <= '9')))
    source.fail_at_line(at, "not an OFF file: it begins neither with OFF nor with its counts");
  if (is_homogeneous || is_n_dimensional)
    source.fail_at_line(at, "OFF files of four or n dimensions are not surfaces in space",
                        ExitCode::kUnsupported);
  header.body = word.empty() ? after : word.data();
  const char* rest = header.body;
  skip_blanks(rest, source.end());
  if (take_token(rest, source.end()) == "BINARY") {
    header.is_binary = true;
    const char* const line_end = std::find(rest, source.end(), '\n');
    if (line_end == source.end()) source.fail_at_byte(rest, "the file ends within its first line");
    header.body = line_end + 1;
  }
  return header;
}

/// Where the values of one vertex go, for the text and the binary form: position, normal, colour, texture.
class VertexSink {
 public:
  VertexSink(const OffHeader& header, std::size_t color_count, std::size_t vertex_count,
             const ReadOptions& options, TriangleMesh& mesh)
      : header_(header), color_count_(color_count), mesh_(mesh) {
    mesh_.positions.reserve(vertex_count);
    if (header.has_normals && options.attributes) {
      for (const char* name : {"nx", "ny", "nz"}) {
        mesh_.attributes.push_back({name, 1, {}});
        mesh_.attributes.back().values.reserve(vertex_count);
      }
    } else if (header.has_normals) {
      mesh_.dropped_properties.push_back("vertex normals (attributes are not asked for)");
    }
    if (header.has_texture_coordinates)
      mesh_.dropped_properties.push_back("vertex texture coordinates (textures are not carried)");
    if (color_count > 0) rgb_.reserve(3 * vertex_count);
  }

  void add(const double* values) {
    mesh_.positions.push_back({values[0], values[1], values[2]});
    values += 3;
    if (header_.has_normals) {
      for (std::size_t k = 0; k < mesh_.attributes.size(); ++k)
        mesh_.attributes[k].values.push_back(static_cast<float>(values[k]));
      values += 3;
    }
    if (color_count_ > 0) rgb_.insert(rgb_.end(), values, values + 3);
    if (color_count_ == 4) {
      largest_opacity_ = std::max(largest_opacity_, static_cast<float>(values[3]));
      smallest_opacity_ = std::min(smallest_opacity_, static_cast<float>(values[3]));
    }
  }

  void finish() {
    if (smallest_opacity_ < largest_opacity_) mesh_.dropped_properties.push_back("vertex opacities");
    if (holds_negative(rgb_)) {
      mesh_.dropped_properties.push_back("values behind the positions (some are negative, so no colours)");
    } else if (color_count_ > 0) {
      mesh_.colors = colors_from_unscaled(rgb_, largest_opacity_);
    }
  }

 private:
  const OffHeader& header_;
  std::size_t color_count_;
  TriangleMesh& mesh_;
  std::vector<float> rgb_;
  float largest_opacity_ = 0;
  float smallest_opacity_ = std::numeric_limits<float>::infinity();
};

[[noreturn]] void fail_limit(const Source& source, std::uint64_t vertex_count, std::uint64_t face_count) {
  source.fail(fmt::format("{} vertices and {} faces, above the limit", vertex_count, face_count),
              ExitCode::kLimit);
}

class TextReader {
 public:
  TextReader(const Source& source, const OffHeader& header, const ReadOptions& options)
      : source_(source), header_(header), options_(options), at_(header.body), end_(source.end()) {}

  TriangleMesh read() {
    const std::uint64_t vertex_count = expect_count("the number of vertices");
    const std::uint64_t face_count = expect_count("the number of faces");
    if (!at_line_end()) expect_count("the number of edges");
    if (vertex_count > bytes_left() / 6 || face_count > bytes_left() / 2)
      source_.fail_at_line(
          at_, fmt::format("{} vertices and {} faces are announced, but only {} bytes follow", vertex_count,
                           face_count, bytes_left()));
    if (vertex_count > options_.maximum_vertices || face_count > options_.maximum_triangles)
      fail_limit(source_, vertex_count, face_count);
    read_vertices(static_cast<std::size_t>(vertex_count));
    read_faces(static_cast<std::size_t>(face_count));
    faces_.finish(mesh_);
    if (has_face_colors_)
      mesh_.dropped_properties.push_back("face colours (only vertex colours are carried)");
    if (skip_to_token())
      mesh_.dropped_properties.push_back(fmt::format("{} bytes after the last face", end_ - at_));
    return std::move(mesh_);
  }

 private:
  std::uint64_t bytes_left() const { return static_cast<std::uint64_t>(end_ - at_) + 1; }

  void skip_comment() {
    while (at_ < end_ && *at_ != '\n' && *at_ != '\r') ++at_;
  }

  /// Blanks and a comment up to the end of the line.
  bool at_line_end() {
    while (at_ < end_ && is_blank(*at_) && *at_ != '\r') ++at_;
    if (at_ < end_ && *at_ == '#') skip_comment();
    return at_ == end_ || *at_ == '\n' || *at_ == '\r';
  }

  bool skip_to_token() {
    for (;;) {
      while (at_ < end_ && (is_blank(*at_) || *at_ == '\n')) ++at_;
      if (at_ == end_) return false;
      if (*at_ != '#') return true;
      skip_comment();
    }
  }

  [[noreturn]] void fail_value(const char* token, const char* reason) const {
    const char* at = token;
    source_.fail_at_line(token, fmt::format("'{}' {}", take_token(at, end_).substr(0, 40), reason));
  }

  std::int64_t expect_integer(const char* what) {
    if (!skip_to_token()) source_.fail_at_line(end_, fmt::format("the file ends where {} is expected", what));
    const char* const token = at_;
    std::int64_t value = 0;
    if (!parse_integer(at_, end_, value) || !(ends_token(at_, end_) || *at_ == '#'))
      fail_value(token, "is not an integer");
    return value;
  }

  std::uint64_t expect_count(const char* what) {
    const std::int64_t count = expect_integer(what);
    if (count < 0 || static_cast<std::uint64_t>(count) > kMaximumCount)
      source_.fail_at_line(at_, fmt::format("{} is {}", what, count));
    return static_cast<std::uint64_t>(count);
  }

  double expect_real() {
    const char* const token = at_;
    double value = 0;
    if (!parse_real(at_, end_, value) || !(ends_token(at_, end_) || *at_ == '#'))
      fail_value(token, "is not a number");
    return value;
  }

  /// The format does not say how many colour components there are: the first vertex's line does.
  std::size_t values_on_first_line() {
    if (!skip_to_token()) return 0;
    const char* const start = at_;
    std::size_t count = 0;
    for (; !at_line_end(); ++count) take_token(at_, end_);
    at_ = start;
    return count;
  }

  void read_vertices(std::size_t vertex_count) {
    const std::size_t plain = header_.values_without_color();
    const std::size_t on_line = values_on_first_line();
    std::size_t color_count = 0, surplus = 0;
    if (header_.has_colors && vertex_count > 0) {
      if (on_line != plain + 3 && on_line != plain + 4)
        source_.fail_at_line(at_, fmt::format("the first vertex has {} values where {} or {} are expected",
                                              on_line, plain + 3, plain + 4));
      color_count = on_line - plain;
    } else if (on_line == plain + 3 || on_line == plain + 4) {
      color_count = on_line - plain;  // many writers add colours and leave the keyword as it is
    } else if (on_line > plain) {
      surplus = on_line - plain;
    }
    if (surplus > 0 && vertex_count > 0)
      mesh_.dropped_properties.push_back(
          fmt::format("{} values per vertex that the OFF keyword does not announce", surplus));
    VertexSink sink(header_, color_count, vertex_count, options_, mesh_);
    std::array<double, 12> values{};
    for (std::size_t i = 0; i < vertex_count; ++i) {
      if (!skip_to_token())
        source_.fail_at_line(end_, fmt::format("the file ends after {} of {} vertices", i, vertex_count));
      for (std::size_t k = 0; k < plain + color_count; ++k) {
        if (at_line_end()) source_.fail_at_line(at_, "the vertex has too few values");
        values[k] = expect_real();
      }
      if (surplus > 0) {
        while (!at_line_end()) take_token(at_, end_);
      } else if (!at_line_end()) {
        source_.fail_at_line(at_, "the vertex has more values than the first one");
      }
      sink.add(values.data());
    }
    sink.finish();
  }

  void read_faces(std::size_t face_count) {
    const auto vertex_count = static_cast<std::int64_t>(mesh_.positions.size());
    faces_.reserve(face_count);
    for (std::size_t i = 0; i < face_count; ++i) {
      if (!skip_to_token())
        source_.fail_at_line(end_, fmt::format("the file ends after {} of {} faces", i, face_count));
      const std::uint64_t corner_count = expect_count("the number of corners");
      if (corner_count > bytes_left() / 2)
        source_.fail_at_line(at_,
                             fmt::format("a face of {} corners, but the file ends before", corner_count));
      corners_.clear();
      for (std::uint64_t k = 0; k < corner_count; ++k) {
        const std::int64_t index = expect_integer("a vertex index");
        if (index < 0 || index >= vertex_count)
          source_.fail_at_line(
              at_, fmt::format("vertex index {}, but there are {} vertices", index, vertex_count));
        corners_.push_back(static_cast<std::uint32_t>(index));
      }
      while (!at_line_end()) {
        has_face_colors_ = true;
        const char* const token = at_;
        double value = 0;
        if (!parse_real(at_, end_, value)) fail_value(token, "is not a colour component");
        take_token(at_, end_);
      }
      faces_.add(corners_);
      if (faces_.triangle_count() > options_.maximum_triangles)
        fail_limit(source_, mesh_.positions.size(), face_count);
    }
  }

  const Source& source_;
  const OffHeader& header_;
  const ReadOptions& options_;
  const char* at_;
  const char* end_;
  std::vector<std::uint32_t> corners_;
  bool has_face_colors_ = false;
  TriangleMesh mesh_;
  FaceList faces_;
};

/// Geomview's binary form is big-endian and ends each face with its colour: a count and that many floats. The
/// form of pmp-library is little-endian without colours. The counts tell them apart: read in the wrong order,
/// any but a palindromic count is far larger than the file.
class BinaryReader {
 public:
  BinaryReader(const Source& source, const OffHeader& header, const ReadOptions& options)
      : source_(source), header_(header), options_(options), at_(header.body) {}

  TriangleMesh read() {
    expect(12, "its three counts");
    const std::size_t vertex_size = 4 * (header_.values_without_color() + (header_.has_colors ? 4u : 0u));
    order_ = counts_fit(std::endian::big, vertex_size) && !counts_fit(std::endian::little, vertex_size)
                 ? std::endian::big
                 : std::endian::little;
    if (!counts_fit(order_, vertex_size))
      source_.fail_at_byte(at_,
                           fmt::format("{} vertices and {} faces are announced, but only {} bytes follow",
                                       count(0, order_), count(1, order_), bytes_left() - 12));
    const std::uint64_t vertex_count = count(0, order_), face_count = count(1, order_);
    if (vertex_count > options_.maximum_vertices || face_count > options_.maximum_triangles)
      fail_limit(source_, vertex_count, face_count);
    at_ += 12;
    read_vertices(static_cast<std::size_t>(vertex_count), vertex_size / 4);
    read_faces(static_cast<std::size_t>(face_count));
    faces_.finish(mesh_);
    if (has_face_colors_)
      mesh_.dropped_properties.push_back("face colours (only vertex colours are carried)");
    if (at_ != source_.end())
      mesh_.dropped_properties.push_back(fmt::format("{} bytes after the last face", bytes_left()));
    return std::move(mesh_);
  }

 private:
  std::uint64_t bytes_left() const { return static_cast<std::uint64_t>(source_.end() - at_); }

  std::uint64_t count(std::size_t i, std::endian order) const {
    return load<std::uint32_t>(at_ + 4 * i, order);
  }

  bool counts_fit(std::endian order, std::size_t vertex_size) const {
    return count(0, order) * vertex_size + count(1, order) * 4 <= bytes_left() - 12;
  }

  void expect(std::uint64_t size, const char* what) const {
    if (size > bytes_left())
      source_.fail_at_byte(source_.end(), fmt::format("the file ends where {} should be", what));
  }

  std::uint32_t next_integer(const char* what) {
    expect(4, what);
    const auto value = load<std::uint32_t>(at_, order_);
    at_ += 4;
    return value;
  }

  void read_vertices(std::size_t vertex_count, std::size_t value_count) {
    VertexSink sink(header_, header_.has_colors ? 4 : 0, vertex_count, options_, mesh_);
    std::array<double, 12> values{};
    for (std::size_t i = 0; i < vertex_count; ++i) {
      for (std::size_t k = 0; k < value_count; ++k, at_ += 4) values[k] = load<float>(at_, order_);
      sink.add(values.data());
    }
    sink.finish();
  }

  void read_faces(std::size_t face_count) {
    faces_.reserve(face_count);
    for (std::size_t i = 0; i < face_count; ++i) {
      const std::uint64_t corner_count = next_integer("a face");
      expect(4 * corner_count, "the corners of a face");
      corners_.clear();
      for (std::uint64_t k = 0; k < corner_count; ++k) {
        const std::uint32_t index = next_integer("a corner");
        if (index >= mesh_.positions.size())
          source_.fail_at_byte(at_ - 4, fmt::format("vertex index {}, but there are {} vertices", index,
                                                    mesh_.positions.size()));
        corners_.push_back(index);
      }
      if (order_ == std::endian::big) {
        const std::uint64_t component_count = next_integer("the colour of a face");
        expect(4 * component_count, "the colour of a face");
        at_ += 4 * component_count;
        has_face_colors_ = has_face_colors_ || component_count > 0;
      }
      faces_.add(corners_);
      if (faces_.triangle_count() > options_.maximum_triangles)
        fail_limit(source_, mesh_.positions.size(), face_count);
    }
  }

  const Source& source_;
  const OffHeader& header_;
  const ReadOptions& options_;
  const char* at_;
  std::endian order_ = std::endian::little;
  std::vector<std::uint32_t> corners_;
  bool has_face_colors_ = false;
  TriangleMesh mesh_;
  FaceList faces_;
};

}  // namespace

TriangleMesh read_off(const Source& source, const ReadOptions& options) {
  const OffHeader header = parse_header(source);
  return header.is_binary ? BinaryReader(source, header, options).read()
                          : TextReader(source, header, options).read();
}

}  // namespace nmc
