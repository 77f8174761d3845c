// SPDX-License-Identifier: Apache-2.0
#include "libnmc/decode/header_parser.h"

#include <catch2/catch.hpp>
#include <functional>
#include <string>

#include "libnmc/encode/stream_writer.h"
#include "tests/support/header_bytes.h"
#include "tests/support/random_base_mesh.h"
#include "tests/support/stream_decoding.h"

using namespace nmc;
using namespace nmc::test;

namespace {

Status parse(const Bytes& bytes, Header& header) {
  std::size_t size = 0;
  const Status measured = measure_header(bytes.data(), bytes.size(), size);
  if (!measured.ok()) return measured;
  REQUIRE(size <= bytes.size());
  return parse_header(bytes.data(), size, header);
}

struct Violation {
  std::string name;
  std::function<void(HeaderFields&)> apply;
  StatusCode code;
  std::string section;
};

/// A header with one colour whose byte `index` of the attribute table is `value`.
auto attribute_byte(std::size_t index, std::uint8_t value) {
  return [index, value](HeaderFields& h) {
    h.flags |= 2;
    h.attributes[index] = value;
  };
}

const std::vector<Violation> kViolations = {
    {"no attribute", attribute_byte(0, 0), StatusCode::kCorrupt, "10.1"},
    {"five attributes", attribute_byte(0, 5), StatusCode::kCorrupt, "10.1"},
    {"an attribute without a kind", attribute_byte(1, 0), StatusCode::kCorrupt, "10.1"},
    {"an attribute without components", attribute_byte(2, 0), StatusCode::kCorrupt, "10.1"},
    {"five components", attribute_byte(2, 5), StatusCode::kCorrupt, "10.1"},
    {"a colour of two components", attribute_byte(2, 2), StatusCode::kCorrupt, "10.1"},
    {"components of no bits", attribute_byte(3, 0), StatusCode::kCorrupt, "10.1"},
    {"components of fifteen bits", attribute_byte(3, 15), StatusCode::kCorrupt, "10.1"},
    {"a reserved flag of an attribute", attribute_byte(4, 3), StatusCode::kCorrupt, "10.1"},
    {"an attribute finer than the mesh", attribute_byte(5, 3), StatusCode::kCorrupt, "10.1"},
    {"an attribute step of zero", attribute_byte(8, 0), StatusCode::kCorrupt, "10.1"},
    {"a reserved flag", [](HeaderFields& h) { h.flags = 0x20; }, StatusCode::kCorrupt, "3.3.1"},
    {"the last reserved flag", [](HeaderFields& h) { h.flags = 0x80; }, StatusCode::kCorrupt, "3.3.1"},
    {"unknown units", [](HeaderFields& h) { h.frame = 7; }, StatusCode::kCorrupt, "3.3.2"},
    {"an unknown up axis", [](HeaderFields& h) { h.frame = 0x30; }, StatusCode::kCorrupt, "3.3.2"},
    {"a step of zero", [](HeaderFields& h) { h.step_mantissa = 0; }, StatusCode::kCorrupt, "3.3.3"},
    {"a long step", [](HeaderFields& h) { h.step_mantissa = 1 << 24; }, StatusCode::kCorrupt, "3.3.3"},
    {"a huge exponent", [](HeaderFields& h) { h.step_exponent = 101; }, StatusCode::kCorrupt, "3.3.3"},
    {"a tiny exponent", [](HeaderFields& h) { h.step_exponent = -161; }, StatusCode::kCorrupt, "3.3.3"},
    {"an origin too far", [](HeaderFields& h) { h.origin[2] = (std::int64_t{1} << 51) + 1; },
     StatusCode::kCorrupt, "3.3.3"},
    {"an origin too far below", [](HeaderFields& h) { h.origin[0] = -(std::int64_t{1} << 51) - 1; },
     StatusCode::kCorrupt, "3.3.3"},
    {"a box too large", [](HeaderFields& h) { h.extent[1] = (std::uint64_t{1} << 51) + 1; },
     StatusCode::kCorrupt, "3.3.3"},
    {"two vertices", [](HeaderFields& h) { h.base_vertex_count = 2; }, StatusCode::kCorrupt, "3.3.4"},
    {"no face", [](HeaderFields& h) { h.base_face_count = 0; }, StatusCode::kCorrupt, "3.3.4"},
    {"more vertices than corners", [](HeaderFields& h) { h.base_vertex_count = 13; }, StatusCode::kCorrupt,
     "3.3.4"},
    {"vertices beyond 32 bits", [](HeaderFields& h) { h.base_vertex_count = std::uint64_t{1} << 32; },
     StatusCode::kCorrupt, "3.3.4"},
    {"faces beyond 32 bits", [](HeaderFields& h) { h.base_face_count = (std::uint64_t{1} << 32) + 4; },
     StatusCode::kCorrupt, "3.3.4"},
    {"too many levels",
     [](HeaderFields& h) {
       h.level_count = 15;
       h.step_codes.assign(15, 64);
     },
     StatusCode::kCorrupt, "3.3.4"},
    {"one quality layer spelt out",
     [](HeaderFields& h) {
       h.flags = 8;
       h.quality_layer_count = 1;
     },
     StatusCode::kCorrupt, "3.3.4"},
    {"too many quality layers",
     [](HeaderFields& h) {
       h.flags = 8;
       h.quality_layer_count = 17;
       h.ratios.assign(16, 1);
     },
     StatusCode::kCorrupt, "3.3.4"},
    {"a ratio of zero",
     [](HeaderFields& h) {
       h.flags = 8;
       h.quality_layer_count = 2;
       h.ratios = {0};
     },
     StatusCode::kCorrupt, "3.3.4"},
    {"a ratio above 16",
     [](HeaderFields& h) {
       h.flags = 8;
       h.quality_layer_count = 2;
       h.ratios = {17};
     },
     StatusCode::kCorrupt, "3.3.4"},
    {"ratios that span too much",
     [](HeaderFields& h) {
       h.flags = 8;
       h.quality_layer_count = 7;
       h.ratios.assign(6, 16);
     },
     StatusCode::kCorrupt, "3.3.4"},
    {"a tension above two",
     [](HeaderFields& h) {
       h.flags = 4;
       h.tensions = {4, 9};
     },
     StatusCode::kCorrupt, "3.3.4"},
    {"an empty table",
     [](HeaderFields& h) {
       h.row_count = 0;
       h.rows.clear();
     },
     StatusCode::kCorrupt, "3.3.5"},
    {"a table too long", [](HeaderFields& h) { h.row_count = 1025; }, StatusCode::kCorrupt, "3.3.5"},
    {"an empty row", [](HeaderFields& h) { h.rows[0].size = 0; }, StatusCode::kCorrupt, "3.3.5"},
    {"a row too large", [](HeaderFields& h) { h.rows[0].size = std::uint64_t{1} << 40; },
     StatusCode::kCorrupt, "3.3.5"},
    {"a row of a level that is not there", [](HeaderFields& h) { h.rows[0].level = 3; }, StatusCode::kCorrupt,
     "3.3.5"},
    {"bytes too many", [](HeaderFields& h) { h.extra = {1}; }, StatusCode::kCorrupt, "3.3"},
    {"a row missing", [](HeaderFields& h) { h.row_count = 2; }, StatusCode::kCorrupt, "3.3.5"},
    {"a wrong signature", [](HeaderFields& h) { h.signature[3] = 'X'; }, StatusCode::kNotNmc, "3.1"},
    {"a version of the future", [](HeaderFields& h) { h.version = 2; }, StatusCode::kVersion, "3.1"},
};

}  // namespace

TEST_CASE("header parser: every field beyond its range is refused with its section", "[header][malformed]") {
  Header header;
  REQUIRE(parse(HeaderFields().bytes(), header).ok());
  for (const Violation& violation : kViolations) {
    HeaderFields fields;
    violation.apply(fields);
    Header parsed;
    const Status status = parse(fields.bytes(), parsed);
    INFO(violation.name << ": " << (status.message() ? status.message() : "accepted"));
    CHECK(status.code() == violation.code);
    CHECK(std::string(status.section() ? status.section() : "") == violation.section);
  }
}

TEST_CASE("header parser: values at the ends of their ranges are accepted", "[header]") {
  HeaderFields fields;
  fields.flags = 15;
  fields.frame = 0x26;
  fields.step_mantissa = (1 << 24) - 1;
  fields.step_exponent = 100;
  fields.origin[0] = std::int64_t{1} << 51;
  fields.origin[1] = -(std::int64_t{1} << 51);
  fields.extent[0] = std::uint64_t{1} << 51;
  fields.base_vertex_count = 12;
  fields.level_count = 14;
  fields.step_codes.assign(14, 255);
  fields.tensions.assign(14, 8);
  fields.quality_layer_count = 6;
  fields.ratios.assign(5, 16);
  fields.rows.assign(1024, {(std::uint64_t{1} << 40) - 1, 14, 0, 65535, 0});
  fields.row_count = 1024;
  Header header;
  const Status status = parse(fields.bytes(), header);
  INFO((status.message() ? status.message() : ""));
  REQUIRE(status.ok());
  CHECK(header.quality_layer_count == 6);
  CHECK(header.ratio_after(0) == 1u << 20);
  CHECK(header.layers.size() == 1024);
  CHECK(header.units == Units::kKilometre);
  CHECK(header.up_axis == UpAxis::kZ);
}

TEST_CASE("header parser: superfluous varint bytes are refused", "[header][malformed]") {
  // The size of the header as two bytes although one would do.
  Bytes bytes = {0x8e, 'N', 'M', 'C', 1};
  const Bytes fields = HeaderFields().fields();
  REQUIRE(fields.size() < 128);
  bytes.push_back(static_cast<std::uint8_t>(fields.size() | 128));
  bytes.push_back(0);
  bytes.insert(bytes.end(), fields.begin(), fields.end());
  Header header;
  const Status status = parse(with_checksum(bytes), header);
  CHECK(status.code() == StatusCode::kCorrupt);
  CHECK(std::string(status.section()) == "2.2");
}

TEST_CASE("header parser: a header larger than the format allows is refused at its size",
          "[header][malformed]") {
  Bytes bytes = {0x8e, 'N', 'M', 'C', 1};
  put_varint(bytes, kMaximumHeaderSize + 1);
  std::size_t size = 0;
  const Status status = measure_header(bytes.data(), bytes.size(), size);
  CHECK(status.code() == StatusCode::kLimit);
}

TEST_CASE("header parser: any changed byte is found by the checksum or by the signature",
          "[header][malformed]") {
  const Bytes bytes = HeaderFields().bytes();
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    for (int bit = 0; bit < 8; ++bit) {
      Bytes changed = bytes;
      changed[i] = static_cast<std::uint8_t>(changed[i] ^ (1u << bit));
      const Decoding decoding = decode(changed);
      INFO("byte " << i << " bit " << bit << ": " << decoding);
      CHECK(!decoding.has_header);
      CHECK(decoding.status < 0);
    }
  }
}

TEST_CASE("header writer and parser: round-trip of random headers", "[header]") {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    RandomIntegers random(seed);
    Header header;
    header.units = static_cast<Units>(random.below(7));
    header.up_axis = static_cast<UpAxis>(random.below(3));
    header.has_creases = random.chance(0.5);
    header.step_mantissa = static_cast<std::uint32_t>(random.between(1, (1 << 24) - 1));
    header.step_exponent = static_cast<int>(random.between(-160, 100));
    for (std::int64_t& o : header.origin) o = random.between(-kMaximumOrigin, kMaximumOrigin);
    for (std::uint64_t& e : header.extent) e = static_cast<std::uint64_t>(random.between(0, kMaximumOrigin));
    header.input_vertex_count = static_cast<std::uint64_t>(random.between(0, std::int64_t{1} << 50));
    header.input_triangle_count = static_cast<std::uint64_t>(random.between(0, std::int64_t{1} << 50));
    header.base_face_count = static_cast<std::uint32_t>(random.between(1, 100000));
    header.base_vertex_count = static_cast<std::uint32_t>(random.between(3, 3 * header.base_face_count));
    header.level_count = static_cast<int>(random.between(0, kMaximumLevelCount));
    header.quality_layer_count = static_cast<int>(random.between(1, 5));
    for (int k = 1; k < header.quality_layer_count; ++k) {
      header.layer_ratio[k] = static_cast<std::uint8_t>(random.between(1, 16));
    }
    header.tangential_code =
        header.level_count ? static_cast<std::uint8_t>(random.below(256)) : std::uint8_t{0};
    for (int l = 0; l < header.level_count; ++l) {
      header.step_code[l] = static_cast<std::uint8_t>(random.below(256));
      header.tension_code[l] = static_cast<std::uint8_t>(random.chance(0.5) ? 4 : random.below(9));
    }
    header.attribute_count = static_cast<int>(random.chance(0.5) ? 0 : random.between(1, 4));
    for (int i = 0; i < header.attribute_count; ++i) {
      AttributeDescriptor& attribute = header.attributes[i];
      attribute.kind = static_cast<std::uint8_t>(random.between(1, 255));
      attribute.component_count = static_cast<int>(random.between(attribute.is_color() ? 3 : 1, 4));
      attribute.bit_count = static_cast<int>(random.between(1, 14));
      attribute.is_decorrelated = attribute.component_count >= 3 && random.chance(0.5);
      attribute.finest_level = static_cast<int>(random.between(0, header.level_count));
      for (int l = 0; l <= attribute.finest_level; ++l) {
        for (std::uint8_t& step : attribute.levels[l].step) step = static_cast<std::uint8_t>(random.between(1, 255));
        attribute.levels[l].opposite_share = static_cast<int>(random.between(-4, 11));
        attribute.levels[l].near_share = static_cast<int>(random.between(0, 15));
      }
    }
    for (std::uint32_t i = random.below(20);; --i) {
      REQUIRE(
          header.layers.push_back({static_cast<std::uint64_t>(random.between(1, (std::int64_t{1} << 40) - 1)),
                                   static_cast<std::uint8_t>(random.below(header.level_count + 1)),
                                   static_cast<std::uint16_t>(random.below(65536)),
                                   static_cast<std::uint16_t>(random.below(65536)),
                                   static_cast<std::uint8_t>(random.below(header.region_count + 1))}));
      if (i == 0) break;
    }
    // Face counts that no manifold has are refused; keep to those that one can have.
    if (header.base_face_count > 2 * header.base_vertex_count)
      header.base_vertex_count = header.base_face_count;
    Array<std::uint8_t> bytes;
    REQUIRE(write_header(header, bytes).ok());
    Header parsed;
    const Status status = parse(Bytes(bytes.begin(), bytes.end()), parsed);
    INFO("seed " << seed << ": " << (status.message() ? status.message() : ""));
    REQUIRE(status.ok());
    Array<std::uint8_t> again;
    REQUIRE(write_header(parsed, again).ok());
    CHECK(Bytes(again.begin(), again.end()) == Bytes(bytes.begin(), bytes.end()));
  }
}

TEST_CASE("error codes: the stated error is at least the true one and at most 0.06 percent above",
          "[header]") {
  for (double error = 1e-8; error < 10; error *= 1.37) {
    const double stated = error_from_code(error_to_code(error, 12.5), 12.5);
    INFO(error << " is stated as " << stated);
    CHECK(stated >= error);
    CHECK(stated <= error * 1.0006);
  }
  CHECK(error_from_code(error_to_code(0, 1), 1) < 1e-9);
  CHECK(error_to_code(-1, 1) == kUnknownError);
}
