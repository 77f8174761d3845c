// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <string_view>
#include <utility>
#include <vector>

#include "encoder/read/binary_load.h"
#include "encoder/read/face_list.h"
#include "encoder/read/format_readers.h"
#include "encoder/read/text_numbers.h"

namespace nmc {

namespace {

constexpr std::size_t kHeaderSize = 80;
constexpr std::size_t kFirstFacet = kHeaderSize + 4;
constexpr std::size_t kFacetSize = 50;
constexpr std::size_t kNormalSize = 12;

bool equals_ignoring_case(std::string_view text, std::string_view lower_case) {
  return std::equal(text.begin(), text.end(), lower_case.begin(), lower_case.end(), [](char a, char b) {
    return (a >= 'A' && a <= 'Z' ? static_cast<char>(a - 'A' + 'a') : a) == b;
  });
}

/// Many binary files begin with "solid" too. A file whose size is what its count says is binary; of the
/// others, one that begins with "solid" and has no control characters near its start is text.
bool is_binary(const Source& source) {
  const std::size_t size = source.data.size();
  if (size >= kFirstFacet) {
    const std::uint64_t count = load<std::uint32_t>(source.begin() + kHeaderSize, std::endian::little);
    if (size == kFirstFacet + kFacetSize * count) return true;
  }
  const char* at = source.begin();
  while (at < source.end() && (is_blank(*at) || *at == '\n')) ++at;
  if (!equals_ignoring_case(take_token(at, source.end()), "solid")) return true;
  const char* const stop = source.begin() + std::min<std::size_t>(size, 1024);
  return std::any_of(source.begin(), stop, [](char c) { return c >= 0 && c < '\t'; });
}

TriangleMesh read_binary(const Source& source, const ReadOptions& options) {
  const std::size_t size = source.data.size();
  if (size < kFirstFacet)
    source.fail_at_byte(source.end(),
                        "neither text beginning with 'solid' nor as long as the header of a binary STL");
  const std::uint64_t count = load<std::uint32_t>(source.begin() + kHeaderSize, std::endian::little);
  const std::uint64_t present = (size - kFirstFacet) / kFacetSize;
  if (count > present)
    source.fail_at_byte(source.end(),
                        fmt::format("{} facets are announced, but the file ends after {}", count, present));
  if (count == 0 && size > kFirstFacet)
    source.fail_at_byte(source.begin() + kHeaderSize,
                        fmt::format("no facets are announced, but {} bytes follow", size - kFirstFacet));
  if (count > options.maximum_triangles || 3 * count > options.maximum_vertices)
    source.fail_at_byte(source.begin() + kHeaderSize, fmt::format("{} facets, above the limit", count),
                        ExitCode::kLimit);
  TriangleMesh mesh;
  mesh.positions.reserve(3 * count);
  mesh.triangles.reserve(count);
  std::uint64_t attribute_words = 0;
  const char* at = source.begin() + kFirstFacet;
  for (std::uint32_t i = 0; i < count; ++i) {
    at += kNormalSize;
    for (int corner = 0; corner < 3; ++corner) {
      mesh.positions.push_back({load<float>(at, std::endian::little),
                                load<float>(at + 4, std::endian::little),
                                load<float>(at + 8, std::endian::little)});
      at += 12;
    }
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    attribute_words += load<std::uint16_t>(at, std::endian::little) != 0;
    at += 2;
  }
  if (attribute_words > 0)
    mesh.dropped_properties.push_back(
        fmt::format("attribute words of {} facets (facet colours are not carried)", attribute_words));
  if (at != source.end())
    mesh.dropped_properties.push_back(fmt::format("{} bytes after the last facet", source.end() - at));
  return mesh;
}

/// The text form as a sequence of words; the names behind "solid" and "endsolid" end with their line.
class TextReader {
 public:
  TextReader(const Source& source, const ReadOptions& options)
      : source_(source), options_(options), at_(source.begin()) {}

  TriangleMesh read() {
    while (next_word()) {
      if (is("facet")) {
        if (!in_solid_) fail("outside of a solid");
        read_facet();
      } else if (is("solid")) {
        in_solid_ = true;
        skip_line();
      } else if (is("endsolid")) {
        if (!in_solid_) fail("without its 'solid'");
        in_solid_ = false;
        skip_line();
      } else {
        fail("where a facet or the end of the solid is expected");
      }
    }
    if (in_solid_) source_.fail_at_line(source_.end(), "the file ends before 'endsolid'");
    faces_.finish(mesh_);
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void fail(const char* reason) const {
    source_.fail_at_line(word_.data(), fmt::format("'{}' {}", word_.substr(0, 40), reason));
  }

  bool is(std::string_view keyword) const { return equals_ignoring_case(word_, keyword); }

  bool next_word() {
    while (at_ < source_.end() && (is_blank(*at_) || *at_ == '\n')) ++at_;
    word_ = take_token(at_, source_.end());
    return !word_.empty();
  }

  void expect_word() {
    if (!next_word()) source_.fail_at_line(source_.end(), "the file ends within a facet");
  }

  void expect(std::string_view keyword) {
    expect_word();
    if (!is(keyword))
      source_.fail_at_line(word_.data(),
                           fmt::format("'{}' where '{}' is expected", word_.substr(0, 40), keyword));
  }

  double expect_number() {
    expect_word();
    const char* at = word_.data();
    const char* const end = at + word_.size();
    double value = 0;
    if (!parse_real(at, end, value) || at != end) fail("is not a number");
    return value;
  }

  void skip_line() {
    while (at_ < source_.end() && *at_ != '\n' && *at_ != '\r') ++at_;
  }

  void read_facet() {
    expect("normal");
    for (int k = 0; k < 3; ++k) expect_number();
    expect("outer");
    expect("loop");
    corners_.clear();
    for (expect_word(); is("vertex"); expect_word()) {
      if (mesh_.positions.size() >= options_.maximum_vertices)
        source_.fail_at_line(
            word_.data(), fmt::format("more than {} vertices, which is the limit", options_.maximum_vertices),
            ExitCode::kLimit);
      corners_.push_back(static_cast<std::uint32_t>(mesh_.positions.size()));
      Vec3 position;
      for (int k = 0; k < 3; ++k) position[k] = expect_number();
      mesh_.positions.push_back(position);
    }
    if (!is("endloop")) fail("where 'vertex' or 'endloop' is expected");
    if (corners_.size() < 3) fail("after fewer than three vertices");
    expect("endfacet");
    faces_.add(corners_);
    if (faces_.triangle_count() > options_.maximum_triangles)
      source_.fail_at_line(
          word_.data(), fmt::format("more than {} triangles, which is the limit", options_.maximum_triangles),
          ExitCode::kLimit);
  }

  const Source& source_;
  const ReadOptions& options_;
  const char* at_;
  std::string_view word_;
  bool in_solid_ = false;
  std::vector<std::uint32_t> corners_;
  TriangleMesh mesh_;
  FaceList faces_;
};

}  // namespace

TriangleMesh read_stl(const Source& source, const ReadOptions& options) {
  return is_binary(source) ? read_binary(source, options) : TextReader(source, options).read();
}

}  // namespace nmc
