// SPDX-License-Identifier: Apache-2.0
// What a chunk may describe depends on the bytes up to its own end, never on how many more have arrived.
#include <catch2/catch.hpp>

#include "tests/support/header_bytes.h"
#include "tests/support/stream_decoding.h"
#include "tests/support/stream_generator.h"

using namespace nmc;
using namespace nmc::test;

namespace {

/// A base mesh and six empty levels of a torus in one row; then a row of `padding` ancillary bytes.
Bytes padded_stream(std::size_t padding, bool padding_comes_first) {
  const SmallMesh base = grid(5, 5, true);
  Header header;
  header.base_vertex_count = base.vertex_count;
  header.base_face_count = static_cast<std::uint32_t>(base.faces.size());
  header.level_count = 6;
  for (int l = 0; l < 6; ++l) {
    header.step_code[l] = 64;
    header.tension_code[l] = 4;
  }
  StreamWriter writer(header);
  Array<std::uint32_t> order;
  const std::vector<std::int32_t> corners(std::size_t{3} * base.vertex_count, 1);
  require(writer.add_base(base.faces[0].data(), corners.data(), nullptr, order));
  const Bytes filler(padding, 7);
  if (padding_comes_first) require(writer.add_chunk(0xc0, filler.data(), filler.size()));
  std::vector<LevelCoefficients> levels(6);
  std::vector<const LevelCoefficients*> pointers;
  for (int l = 0; l < 6; ++l) {
    require(writer.mesh().ensure_topology(l, false));
    if (!levels[static_cast<std::size_t>(l)].normal.resize(writer.mesh().topology(l).edge_count))
      throw std::bad_alloc();
  }
  for (const LevelCoefficients& level : levels) pointers.push_back(&level);
  require(writer.add_levels(0, 0, 6, pointers.data()));
  require(writer.end_layer(6, kUnknownError, kUnknownError));
  if (!padding_comes_first) {
    require(writer.add_chunk(0xc0, filler.data(), filler.size()));
    require(writer.end_layer(6, kUnknownError, kUnknownError));
  }
  Array<std::uint8_t> bytes;
  require(writer.write_stream(bytes));
  return Bytes(bytes.begin(), bytes.end());
}

}  // namespace

TEST_CASE("bounds: bytes that follow a chunk do not widen what it may describe", "[malformed][splits]") {
  const Bytes bytes = padded_stream(3000, false);
  const Decoding whole = decode(bytes), bytewise = decode(bytes, {1});
  INFO("whole: " << whole << "\nbyte by byte: " << bytewise);
  CHECK(whole.status == NMC_ERR_LIMIT);
  CHECK(std::string(whole.error.spec_section) == "8.2");
  CHECK(whole == bytewise);
}

TEST_CASE("bounds: ancillary bytes before a chunk widen what it may describe", "[malformed][splits]") {
  const Bytes bytes = padded_stream(3000, true);
  const Decoding whole = decode(bytes), bytewise = decode(bytes, {1});
  INFO("whole: " << whole << "\nbyte by byte: " << bytewise);
  CHECK(whole.status == NMC_OK);
  CHECK(whole == bytewise);
}

TEST_CASE("bounds: a payload that ends too early is reported as that, whatever its zeros mean",
          "[malformed][order]") {
  // The zeros read beyond the one byte come to name an impossible place on the border.
  HeaderFields header;
  header.base_vertex_count = 40;
  header.base_face_count = 60;
  const Bytes base = chunk(1, {0x12});
  header.rows[0].size = base.size();
  Bytes bytes = header.bytes();
  bytes.insert(bytes.end(), base.begin(), base.end());
  const Decoding decoding = decode(bytes);
  INFO(decoding);
  REQUIRE(decoding.status == NMC_ERR_CORRUPT);
  CHECK(std::string(decoding.error.spec_section) == "5.1");
}

TEST_CASE("bounds: quality layers cannot multiply what few bytes describe", "[malformed][work]") {
  // Sixteen layers of a level in which every value grows by 15: after a while a value costs next to no bits
  // and takes seventeen decisions, a thousand times what a byte of a real surface takes.
  const SmallMesh base = grid(8, 8, true);
  Header header;
  header.base_vertex_count = base.vertex_count;
  header.base_face_count = static_cast<std::uint32_t>(base.faces.size());
  header.level_count = 4;
  header.quality_layer_count = 16;
  for (int k = 1; k < 16; ++k) header.layer_ratio[k] = 1;
  for (int l = 0; l < 4; ++l) {
    header.step_code[l] = 64;
    header.tension_code[l] = 4;
  }
  StreamWriter writer(header);
  Array<std::uint32_t> order;
  const std::vector<std::int32_t> corners(std::size_t{3} * base.vertex_count, 1);
  require(writer.add_base(base.faces[0].data(), corners.data(), nullptr, order));
  const Bytes filler(200, 7);
  require(writer.add_chunk(0xc0, filler.data(), filler.size()));
  std::uint64_t value_count = 0;
  for (int layer = 0; layer < 16; ++layer) {
    std::vector<LevelCoefficients> levels(4);
    std::vector<const LevelCoefficients*> pointers;
    for (int l = 0; l < 4; ++l) {
      require(writer.mesh().ensure_topology(l, false));
      Array<std::int32_t>& values = levels[static_cast<std::size_t>(l)].normal;
      if (!values.resize(writer.mesh().topology(l).edge_count)) throw std::bad_alloc();
      for (std::int32_t& value : values) value = 15 * (layer + 1);
      value_count += values.size();
      pointers.push_back(&levels[static_cast<std::size_t>(l)]);
    }
    require(writer.add_levels(layer, 0, 4, pointers.data()));
    require(writer.end_layer(4, kUnknownError, kUnknownError));
  }
  Array<std::uint8_t> bytes;
  require(writer.write_stream(bytes));
  const Decoding decoding = decode({bytes.data(), bytes.size()});
  INFO(bytes.size() << " bytes, " << value_count << " values: " << decoding);
  REQUIRE(value_count > kFreeValues + kValuesPerByte * bytes.size());
  CHECK(decoding.status == NMC_ERR_LIMIT);
  CHECK(std::string(decoding.error.spec_section) == "8.2");
  CHECK(decoding.layers.size() >= 2);
}
