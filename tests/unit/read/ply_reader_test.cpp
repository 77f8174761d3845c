// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "tests/unit/read/read_test_tools.h"

namespace nmc {
namespace {

using test::Bytes;
using test::mentions;
using test::read_bytes;
using test::require_failure;

constexpr MeshFormat kPly = MeshFormat::kPly;

const std::string kTriangleHeader =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n";

TEST_CASE("ply: reads text with blank lines, CR LF ends and surplus values", "[ply]") {
  std::string text =
      "ply\r\nformat ascii 1.0\r\ncomment hello\r\nobj_info x\r\nelement vertex 3\r\nproperty float x\r\n"
      "property double y\r\nproperty float z\r\nelement face 1\r\nproperty list uchar int vertex_index\r\n"
      "end_header\r\n0 0 0\r\n\r\n  1.5 -2e-1 +3 77\r\n0 1 0\r\n3 0 1 2\r\n";
  const TriangleMesh mesh = read_bytes(kPly, text);
  REQUIRE(mesh.vertex_count() == 3);
  CHECK(mesh.positions[1] == Vec3{1.5, -0.2, 3});
  REQUIRE(mesh.triangle_count() == 1);
  CHECK(mesh.triangles[0] == Triangle{0, 1, 2});
  CHECK(mentions(mesh.dropped_properties, "1 lines with more values"));
}

TEST_CASE("ply: reads every property type in both byte orders and any order of properties", "[ply]") {
  for (const bool big_endian : {false, true}) {
    CAPTURE(big_endian);
    Bytes bytes(big_endian);
    bytes.text(std::string("ply\nformat binary_") + (big_endian ? "big" : "little") +
               "_endian 1.0\nelement vertex 3\nproperty char z\nproperty list uchar ushort neighbours\n"
               "property ushort y\nproperty double x\nproperty float quality\nproperty uint label\n"
               "element face 1\nproperty short material\nproperty list ushort uint vertex_indices\n"
               "property float area\nend_header\n");
    for (int i = 0; i < 3; ++i) {
      bytes.number(static_cast<std::int8_t>(-i))
          .number(std::uint8_t{2})
          .number(std::uint16_t{7})
          .number(std::uint16_t{8});
      bytes.number(static_cast<std::uint16_t>(60000 + i))
          .number(0.1 * i)
          .number(0.5f * static_cast<float>(i));
      bytes.number(std::uint32_t{9});
    }
    bytes.number(std::int16_t{-1}).number(std::uint16_t{3});
    bytes.numbers<std::uint32_t>({2, 0, 1}).number(1.0f);
    const TriangleMesh mesh = read_bytes(kPly, bytes.string());
    REQUIRE(mesh.vertex_count() == 3);
    CHECK(mesh.positions[2] == Vec3{0.2, 60002, -2});
    REQUIRE(mesh.triangle_count() == 1);
    CHECK(mesh.triangles[0] == Triangle{2, 0, 1});
    REQUIRE(mesh.attributes.size() == 1);
    CHECK(mesh.attributes[0].name == "quality");
    CHECK(mesh.attributes[0].values == std::vector<float>{0, 0.5f, 1});
    CHECK(mentions(mesh.dropped_properties, "'label'"));
    CHECK(mentions(mesh.dropped_properties, "'neighbours'"));
    CHECK(mentions(mesh.dropped_properties, "'material'"));
    CHECK(mentions(mesh.dropped_properties, "'area'"));
  }
}

TEST_CASE("ply: reads faces that come before the vertices, and skips unknown elements", "[ply]") {
  const TriangleMesh mesh = read_bytes(
      kPly,
      "ply\nformat ascii 1.0\nelement camera 2\nproperty list int float matrix\nproperty int id\nelement "
      "face 2\n"
      "property list uchar int vertex_indices\nelement vertex 4\nproperty float x\nproperty float "
      "y\nproperty float z\n"
      "element nothing 5\nend_header\n2 1 2 3\n0 4\n4 0 1 2 3\n3 0 1 2\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n");
  REQUIRE(mesh.triangle_count() == 3);
  CHECK(mesh.triangles[0] == Triangle{0, 1, 2});
  CHECK(mesh.triangles[1] == Triangle{0, 2, 3});
  CHECK(mesh.triangles[2] == Triangle{0, 1, 2});
  CHECK(mentions(mesh.dropped_properties, "2 elements 'camera'"));
}

TEST_CASE("ply: reads triangle strips with restarts and joints", "[ply]") {
  const TriangleMesh mesh = read_bytes(
      kPly,
      "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
      "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n0 1 0\n1 1 0\n2 2 0\n11 0 1 2 3 3 4 -1 2 1 0 -1\n");
  const std::vector<Triangle> expected = {{0, 1, 2}, {2, 1, 3}, {2, 1, 0}};
  CHECK(mesh.triangles == expected);
}

TEST_CASE("ply: keeps unreferenced vertices and non-finite coordinates in every spelling", "[ply]") {
  const TriangleMesh mesh = read_bytes(
      kPly,
      "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n0 1 0\nnan NaN -nan\ninf -inf Infinity\n1.#QNAN -1.#IND 1.#INF00\n3 0 1 2\n");
  REQUIRE(mesh.vertex_count() == 6);
  CHECK(std::isnan(mesh.positions[3].x));
  CHECK(std::isnan(mesh.positions[3].z));
  CHECK(mesh.positions[4].y == -INFINITY);
  CHECK(mesh.positions[4].z == INFINITY);
  CHECK(std::isnan(mesh.positions[5].x));
  CHECK(std::isnan(mesh.positions[5].y));
  CHECK(mesh.positions[5].z == INFINITY);
}

TEST_CASE("ply: reads colours of bytes, words and reals, and their other names", "[ply][colour]") {
  const auto colored = [](const std::string& type, const std::string& names, const std::string& values) {
    const auto name = [&](std::size_t k) {
      std::size_t begin = 0;
      for (; k > 0; --k) begin = names.find(' ', begin) + 1;
      return names.substr(begin, names.find(' ', begin) - begin);
    };
    std::string text =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    for (std::size_t k = 0; k < 3; ++k) text += "property " + type + " " + name(k) + "\n";
    text += "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 " + values +
            "\n1 0 0 0 0 0\n0 1 0 0 0 0\n3 0 1 2\n";
    return read_bytes(kPly, text).colors.at(0);
  };
  using Color = std::array<std::uint8_t, 3>;
  CHECK(colored("uchar", "red green blue", "1 2 255") == Color{1, 2, 255});
  CHECK(colored("uchar", "diffuse_red diffuse_green diffuse_blue", "9 8 7") == Color{9, 8, 7});
  CHECK(colored("float", "red green blue", "1 0.5 0") == Color{255, 128, 0});
  CHECK(colored("float", "red green blue", "255 51 0") == Color{255, 51, 0});
  CHECK(colored("ushort", "red green blue", "65535 257 0") == Color{255, 1, 0});
  CHECK(colored("int", "r g b", "200 100 0") == Color{200, 100, 0});
}

TEST_CASE("ply: lists what a mesh cannot carry", "[ply]") {
  ReadOptions options;
  options.attributes = false;
  const TriangleMesh mesh = read_bytes(
      kPly,
      "ply\nformat ascii 1.0\ncomment TextureFile my skin.png \nelement vertex 3\nproperty float x\nproperty "
      "float y\n"
      "property float z\nproperty float quality\nproperty uchar red\nproperty uchar alpha\nelement face 1\n"
      "property list uchar int vertex_indices\nproperty list uchar float texcoord\nend_header\n"
      "0 0 0 1 2 3\n1 0 0 1 2 3\n0 1 0 1 2 3\n3 0 1 2 2 0.5 0.5\n",
      options);
  CHECK(mesh.attributes.empty());
  CHECK(mesh.colors.empty());
  for (const char* what : {"'my skin.png'", "'quality'", "'red'", "'alpha'", "'texcoord'"}) {
    CAPTURE(what);
    CHECK(mentions(mesh.dropped_properties, what));
  }
}

TEST_CASE("ply: triangulates polygons and counts faces of fewer than three corners", "[ply]") {
  const TriangleMesh mesh = read_bytes(kPly,
                                       "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty "
                                       "float y\nproperty float z\nelement face 4\n"
                                       "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 "
                                       "1 0\n0 1 0\n4 0 1 2 3\n2 0 1\n0\n3.0 3 2 1\n");
  CHECK(mesh.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {3, 2, 1}});
  CHECK(mentions(mesh.dropped_properties, "2 faces of fewer than three corners"));
}

TEST_CASE("ply: names the line of a malformed header", "[ply][malformed]") {
  const auto invalid = [](const std::string& text, const std::string& part) {
    require_failure(kPly, text, ExitCode::kInvalidInput, part);
  };
  invalid("plx\n", "mesh: byte offset 0: not a PLY file");
  invalid("ply\nformat ascii 1.0\n", "line 3: the file ends before 'end_header'");
  invalid("ply\nend_header\n", "line 2: the header states no format");
  invalid("ply\nformat ascii 2.0\n", "line 2: PLY version '2.0'");
  invalid("ply\nformat utf8 1.0\n", "line 2: unknown format 'utf8'");
  invalid("ply\nformat ascii 1.0\nelement vertex -1\n", "line 3: element 'vertex' has the count '-1'");
  invalid("ply\nformat ascii 1.0\nelement vertex 99999999999999999999\n", "line 3");
  invalid("ply\nformat ascii 1.0\nproperty float x\n", "line 3: a property before the first element");
  invalid("ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\n",
          "line 4: unknown property type 'quad'");
  invalid("ply\nformat ascii 1.0\nelement vertex 1\nproperty list float int x\n",
          "line 4: a list cannot be counted");
  invalid("ply\nformat ascii 1.0\nelement vertex 1\nproperty float\n", "line 4: a property without a name");
  invalid("ply\nformat ascii 1.0\nelement vertex 0\nelement vertex 0\n",
          "line 4: element 'vertex' is declared twice");
  invalid("ply\nformat ascii 1.0\nnonsense\n", "line 3: unknown keyword 'nonsense'");
  invalid("ply\nformat ascii 1.0\nelement face 0\nend_header\n", "declares no vertices");
  invalid("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nend_header\n0 0\n",
          "line 3: the vertices have no property 'z'");
  invalid("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float x\nend_header\n0 0\n",
          "line 3: the vertices have two properties 'x'");
}

TEST_CASE("ply: names the line of a malformed text body", "[ply][malformed]") {
  const auto invalid = [](const std::string& body, const std::string& part) {
    require_failure(kPly, kTriangleHeader + body, ExitCode::kInvalidInput, part);
  };
  invalid("0 0 0\n1 x 0\n0 1 0\n3 0 1 2\n", "mesh: line 11: 'x' is not a number");
  invalid("0 0 0\n1 0\n0 1 0\n3 0 1 2\n", "line 11: the line has fewer values");
  invalid("0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "line 13: vertex index 3, but there are 3 vertices");
  invalid("0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", "line 13: vertex index -1");
  invalid("0 0 0\n1 0 0\n0 1 0\n3 0 1 1.5\n", "line 13: '1.5' is not an integer");
  invalid("0 0 0\n1 0 0\n0 1 0\n200 0 1 2\n", "line 13: a list of 200 values");
  invalid("0 0 0\n1 0 0\n0 1 0\n-3 0 1 2\n", "line 13: a list of -3 values");
  invalid("0 0 0\n1 0 0\n0 1 0 9 9 9\n", "line 7: 1 elements 'face' are announced, but the file ends");
  invalid("0 0 0\n1 0 0\n0 1 0\n   \n", "line 14: the file ends before its last element");
}

TEST_CASE("ply: refuses counts that the file cannot hold before it allocates", "[ply][malformed]") {
  for (const char* count : {"4000000000", "4294967295", "9223372036854775807", "18446744073709551615"}) {
    for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
      const std::string start = std::string("ply\nformat ") + format + " 1.0\n";
      const std::string axes = "property float x\nproperty float y\nproperty float z\n";
      require_failure(kPly, start + "element vertex " + count + "\n" + axes + "end_header\n0 0 0\n",
                      ExitCode::kInvalidInput, "line 3: ");
      require_failure(kPly,
                      start + "element vertex 0\n" + axes + "element face " + count +
                          "\nproperty list uint int vertex_indices\nend_header\n\xff\xff\xff\xff",
                      ExitCode::kInvalidInput, "line 7: ");
    }
  }
  require_failure(kPly,
                  Bytes()
                      .text("ply\nformat binary_little_endian 1.0\nelement vertex 0\nproperty float x\n"
                            "property float y\nproperty float z\nelement face 1\n"
                            "property list uint double vertex_indices\nend_header\n")
                      .number(0xffffffffu)
                      .string(),
                  ExitCode::kInvalidInput, "a list of 4294967295 values where the file ends");
}

TEST_CASE("ply: gives the byte offset of a fault in a binary body", "[ply][malformed]") {
  Bytes bytes;
  bytes.text(
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n");
  const std::size_t body = bytes.size();
  bytes.numbers<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}).number(std::uint8_t{3}).numbers<std::int32_t>({0, 1, 7});
  require_failure(kPly, bytes.string(), ExitCode::kInvalidInput,
                  "mesh: byte offset " + std::to_string(body + 36 + 1 + 12) + ": vertex index 7");
}

TEST_CASE("ply: stops at the limits", "[ply]") {
  ReadOptions options;
  options.maximum_vertices = 2;
  const std::string body = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  std::optional<test::Failure> failure = test::failure_of(kPly, kTriangleHeader + body, options);
  REQUIRE(failure);
  CHECK(failure->code == ExitCode::kLimit);
  options = {};
  options.maximum_triangles = 0;
  failure = test::failure_of(kPly, kTriangleHeader + body, options);
  REQUIRE(failure);
  CHECK(failure->code == ExitCode::kLimit);
}

}  // namespace
}  // namespace nmc
