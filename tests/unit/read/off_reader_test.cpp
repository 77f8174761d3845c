// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/read/read_test_tools.h"

namespace nmc {
namespace {

using test::Bytes;
using test::mentions;
using test::read_bytes;
using test::require_failure;

constexpr MeshFormat kOff = MeshFormat::kOff;
using Color = std::array<std::uint8_t, 3>;

const std::string kBody = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

TEST_CASE("off: reads the header in all its usual forms", "[off]") {
  for (const std::string header :
       {"OFF\n3 1 0\n", "OFF 3 1 0\n", "OFF3 1 0\n", "3 1 0\n", "OFF\n# comment\n3 1\n",
        "# first\nOFF # kind\n\n3 1 3 # counts\n", "OFF\r\n3 1 0\r\n", "\xef\xbb\xbfOFF\n3 1 0\n"}) {
    CAPTURE(header);
    const TriangleMesh mesh = read_bytes(kOff, header + kBody);
    CHECK(mesh.vertex_count() == 3);
    CHECK(mesh.triangles == std::vector<Triangle>{{0, 1, 2}});
    CHECK(mesh.dropped_properties.empty());
  }
}

TEST_CASE("off: reads polygons, comments and faces without area, and reports face colours", "[off]") {
  const TriangleMesh mesh =
      read_bytes(kOff,
                 "OFF\n4 4 0\n0 0 0 # a\n1 0 0\n\n# b\n1 1 0\n0 1 0\n4 0 1 2 3 255 0 0\n3 0 1 2 7\n"
                 "2 0 1\n3 2 1 0 # c\n");
  CHECK(mesh.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 1, 2}, {2, 1, 0}});
  CHECK(mentions(mesh.dropped_properties, "face colours"));
  CHECK(mentions(mesh.dropped_properties, "1 faces of fewer"));
}

TEST_CASE("off: ends at vertical tabs and form feeds within lines", "[off][malformed]") {
  const TriangleMesh mesh = read_bytes(kOff, "OFF\n3 1 0\v\n0\f0 0\v9\n1 0 0 9\n0 1 0 9\n3 0\v1 2 \v \f\n");
  CHECK(mesh.triangles == std::vector<Triangle>{{0, 1, 2}});
}

TEST_CASE("off: reads colours of integers and reals, with and without opacity", "[off][colour]") {
  const std::string face = "3 0 1 2\n";
  const std::vector<Color> expected = {{255, 0, 51}, {0, 255, 0}, {0, 0, 255}};
  CHECK(read_bytes(kOff, "COFF\n3 1 0\n0 0 0 255 0 51\n1 0 0 0 255 0\n0 1 0 0 0 255\n" + face).colors ==
        expected);
  CHECK(read_bytes(kOff, "COFF\n3 1 0\n0 0 0 255 0 51 255\n1 0 0 0 255 0 255\n0 1 0 0 0 255 255\n" + face)
            .colors == expected);
  CHECK(read_bytes(kOff, "COFF\n3 1 0\n0 0 0 1 0 0.2\n1 0 0 0 1 0\n0 1 0 0 0 1\n" + face).colors == expected);
  CHECK(read_bytes(kOff, "OFF\n3 1 0\n0 0 0 1 0 .2 1\n1 0 0 0 1 0 1\n0 1 0 0 0 1 1\n" + face).colors ==
        expected);
  // Dark bytes are told from reals by their opacity.
  CHECK(read_bytes(kOff, "COFF\n3 1 0\n0 0 0 1 0 0 255\n1 0 0 0 1 0 255\n0 1 0 0 0 1 255\n" + face)
            .colors.at(0) == Color{1, 0, 0});
}

TEST_CASE("off: reads normals as attributes and reports texture coordinates", "[off]") {
  const TriangleMesh mesh = read_bytes(kOff,
                                       "STCNOFF\n3 1 0\n0 0 0  0 0 1  1 0 0 1  .5 .5\n1 0 0 0 0 1 0 1 0 1 .5 "
                                       ".5\n0 1 0 0 0 1 0 0 1 1 .5 .5\n3 0 1 2\n");
  REQUIRE(mesh.attributes.size() == 3);
  CHECK(mesh.attributes[2].name == "nz");
  CHECK(mesh.attributes[2].values == std::vector<float>{1, 1, 1});
  CHECK(mesh.colors == std::vector<Color>{{255, 0, 0}, {0, 255, 0}, {0, 0, 255}});
  CHECK(mentions(mesh.dropped_properties, "texture coordinates"));
}

TEST_CASE("off: reads both binary layouts", "[off]") {
  Bytes little;
  little.text("OFF BINARY\n")
      .numbers<std::uint32_t>({4, 2, 0})
      .numbers<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});
  little.numbers<std::uint32_t>({3, 0, 1, 2}).numbers<std::uint32_t>({4, 0, 1, 2, 3});
  const TriangleMesh pmp = read_bytes(kOff, little.string());
  CHECK(pmp.positions.at(2) == Vec3{1, 1, 0});
  CHECK(pmp.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 1, 2}, {0, 2, 3}});

  Bytes big(true);
  big.text("COFF BINARY\n").numbers<std::uint32_t>({3, 2, 0});
  for (int i = 0; i < 3; ++i)
    big.numbers<float>({static_cast<float>(i), 0, 0}).numbers<float>({1, 0, 0.2f, 1});
  big.numbers<std::uint32_t>({3, 0, 1, 2, 3})
      .numbers<float>({1, 0, 0})
      .numbers<std::uint32_t>({3, 2, 1, 0, 0});
  const TriangleMesh geomview = read_bytes(kOff, big.string());
  CHECK(geomview.positions.at(2) == Vec3{2, 0, 0});
  CHECK(geomview.triangles == std::vector<Triangle>{{0, 1, 2}, {2, 1, 0}});
  CHECK(geomview.colors.at(1) == Color{255, 0, 51});
  CHECK(mentions(geomview.dropped_properties, "face colours"));
}

TEST_CASE("off: names the line of malformed text", "[off][malformed]") {
  const auto invalid = [](const std::string& text, const std::string& part) {
    require_failure(kOff, text, ExitCode::kInvalidInput, part);
  };
  invalid("OFX\n3 1 0\n", "mesh: line 1: not an OFF file");
  invalid("OFF\n3 x 0\n", "line 2: 'x' is not an integer");
  invalid("OFF\n-3 1 0\n", "line 2: the number of vertices is -3");
  invalid("OFF\n4000000000 1 0\n0 0 0\n", "4000000000 vertices and 1 faces are announced");
  invalid("OFF\n0 4000000000 0\n", "4000000000 faces are announced");
  invalid("OFF\n3 1 0\n0 0 0\n1 0\n0 1 0\n3 0 1 2\n", "line 4: the vertex has too few values");
  invalid("OFF\n3 1 0\n0 0 0\n1 0 0 0\n0 1 0\n3 0 1 2\n",
          "line 4: the vertex has more values than the first");
  invalid("OFF\n3 1 0\n0 0 0\n1 0 zero\n0 1 0\n3 0 1 2\n", "line 4: 'zero' is not a number");
  invalid("OFF\n3 1 0\n0.0 0 0\n1.00 0 0\n", "line 5: the file ends after 2 of 3 vertices");
  invalid("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n", "line 6: the file ends after 0 of 1 faces");
  invalid("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "line 6: vertex index 3, but there are 3 vertices");
  invalid("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n99 0 1 2\n", "line 6: a face of 99 corners");
  invalid("COFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "line 3: the first vertex has 3 values");
  require_failure(kOff, "4OFF\n3 1 0\n", ExitCode::kUnsupported, "line 1: OFF files of four");
}

TEST_CASE("off: gives the byte offset of a fault in binary data", "[off][malformed]") {
  const auto binary = [](std::uint32_t vertices, std::uint32_t faces,
                         std::initializer_list<std::uint32_t> face) {
    return Bytes()
        .text("OFF BINARY\n")
        .numbers<std::uint32_t>({vertices, faces, 0})
        .numbers<float>({0, 0, 0, 1, 0, 0, 0, 1, 0})
        .numbers(face)
        .string();
  };
  require_failure(kOff, binary(3, 1, {3, 0, 1, 9}), ExitCode::kInvalidInput,
                  "mesh: byte offset 71: vertex index 9");
  require_failure(kOff, binary(3, 1, {3, 0, 1}), ExitCode::kInvalidInput,
                  "the file ends where the corners of a face");
  require_failure(kOff, binary(3, 1, {0xffffffffu, 0, 1}), ExitCode::kInvalidInput, "the file ends where");
  require_failure(kOff, binary(0x70000000u, 1, {3, 0, 1, 2}), ExitCode::kInvalidInput,
                  "1879048192 vertices and 1 faces are announced");
  require_failure(kOff, binary(3, 0x70000000u, {3, 0, 1, 2}), ExitCode::kInvalidInput,
                  "1879048192 faces are announced");
}

}  // namespace
}  // namespace nmc
