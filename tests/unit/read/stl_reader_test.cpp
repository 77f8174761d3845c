// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/read/read_test_tools.h"

namespace nmc {
namespace {

using test::Bytes;
using test::mentions;
using test::read_bytes;
using test::require_failure;

constexpr MeshFormat kStl = MeshFormat::kStl;

std::string binary_stl(const std::string& name, std::uint32_t announced, int facets, std::uint16_t word = 0) {
  Bytes bytes;
  std::string header = name;
  header.resize(80, '\0');
  bytes.text(header).number(announced);
  for (int i = 0; i < facets; ++i) {
    bytes.numbers<float>({0, 0, 1})
        .numbers<float>({0, 0, static_cast<float>(i), 1, 0, 0, 0, 1, 0})
        .number(word);
  }
  return bytes.string();
}

const std::string kFacet =
    " facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 0 1.5e0 0\n  endloop\n "
    "endfacet\n";

TEST_CASE("stl: reads binary, three vertices per facet", "[stl]") {
  const TriangleMesh mesh = read_bytes(kStl, binary_stl("exported", 2, 2));
  CHECK(mesh.vertex_count() == 6);
  CHECK(mesh.triangles == std::vector<Triangle>{{0, 1, 2}, {3, 4, 5}});
  CHECK(mesh.positions[3] == Vec3{0, 0, 1});
  CHECK(mesh.dropped_properties.empty());
}

TEST_CASE("stl: recognises binary files whose header begins with 'solid'", "[stl]") {
  CHECK(read_bytes(kStl, binary_stl("solid from a tool", 2, 2)).triangle_count() == 2);
  const std::string with_tail = binary_stl("solid from a tool", 1, 1) + std::string(7, '\0');
  const TriangleMesh mesh = read_bytes(kStl, with_tail);
  CHECK(mesh.triangle_count() == 1);
  CHECK(mentions(mesh.dropped_properties, "7 bytes after the last facet"));
}

TEST_CASE("stl: reads text with any case, white space, and several solids", "[stl]") {
  const TriangleMesh mesh = read_bytes(
      kStl, "\n  SOLID a b c\n" + kFacet +
                "ENDSOLID a b c\nsolid\r\n FACET NORMAL nan nan nan "
                "OUTER LOOP VERTEX 0 0 0 VERTEX 1 0 0 VERTEX 0 0 1 ENDLOOP ENDFACET\r\nendsolid\r\n");
  CHECK(mesh.triangle_count() == 2);
  CHECK(mesh.positions.at(2) == Vec3{0, 1.5, 0});
}

TEST_CASE("stl: reports facet colours as dropped", "[stl]") {
  CHECK(mentions(read_bytes(kStl, binary_stl("COLOR=", 2, 2, 0x8001)).dropped_properties,
                 "attribute words of 2 facets"));
}

TEST_CASE("stl: refuses wrong counts", "[stl][malformed]") {
  require_failure(kStl, binary_stl("x", 3, 2), ExitCode::kInvalidInput,
                  "3 facets are announced, but the file ends after 2");
  require_failure(kStl, binary_stl("x", 0xffffffffu, 2), ExitCode::kInvalidInput,
                  "4294967295 facets are announced");
  require_failure(kStl, binary_stl("x", 0, 2), ExitCode::kInvalidInput,
                  "no facets are announced, but 100 bytes follow");
  require_failure(kStl, "x", ExitCode::kInvalidInput, "byte offset 1: neither text");
}

TEST_CASE("stl: names the line of malformed text", "[stl][malformed]") {
  const auto invalid = [](const std::string& text, const std::string& part) {
    require_failure(kStl, text, ExitCode::kInvalidInput, part);
  };
  invalid("solid x\n" + kFacet, "mesh: line 9: the file ends before 'endsolid'");
  invalid("solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0\n0\nvertex 0 0 zero\n",
          "line 6: 'zero' is not a number");
  invalid("solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0 0 0\nendloop\nendfacet\n",
          "line 6: 'endloop' after fewer than three vertices");
  invalid("solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n", "line 5: the file ends within a facet");
  invalid("solid x\nfacet 0 0 1\n", "line 2: '0' where 'normal' is expected");
  invalid("solid x\nmesh\n", "line 2: 'mesh' where a facet");
  invalid("solid x\nendsolid\nendsolid\n", "line 3: 'endsolid' without its 'solid'");
}

}  // namespace
}  // namespace nmc
