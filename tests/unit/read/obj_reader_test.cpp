// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/read/read_test_tools.h"

namespace nmc {
namespace {

using test::mentions;
using test::read_bytes;
using test::require_failure;

constexpr MeshFormat kObj = MeshFormat::kObj;
using Color = std::array<std::uint8_t, 3>;

TEST_CASE("obj: reads absolute, relative and forward references in every corner form", "[obj]") {
  const TriangleMesh mesh =
      read_bytes(kObj,
                 "# comment\nf 1 2 4\nv 0 0 0\nv 1 0 0\n  v\t0 1 0 # end\nvt 0 0\nvn 0 0 1\n"
                 "f -3 -2 -1\nv 1 1 1e0\nf 1/1 2/1/1 4//1\nfo 1/ 2// 3\n");
  CHECK(mesh.vertex_count() == 4);
  CHECK(mesh.triangles == std::vector<Triangle>{{0, 1, 3}, {0, 1, 2}, {0, 1, 3}, {0, 1, 2}});
  CHECK(mentions(mesh.dropped_properties, "1 texture coordinates"));
  CHECK(mentions(mesh.dropped_properties, "1 corner normals"));
}

TEST_CASE("obj: joins continued lines, with LF and with CR LF", "[obj]") {
  for (const std::string end : {"\n", "\r\n"}) {
    const TriangleMesh mesh = read_bytes(kObj, "v 0 0 0" + end + "v 1 \\" + end + " 0 0" + end + "v 0 1 0" +
                                                   end + "f 1 \\" + end + "2 \\" + end + "3" + end);
    CHECK(mesh.positions.at(1) == Vec3{1, 0, 0});
    CHECK(mesh.triangles == std::vector<Triangle>{{0, 1, 2}});
  }
  CHECK(read_bytes(kObj, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 \\").triangle_count() == 1);
}

TEST_CASE("obj: reads old Macintosh line ends and a byte order mark", "[obj]") {
  const TriangleMesh mesh = read_bytes(kObj, "\xef\xbb\xbfv 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r");
  CHECK(mesh.vertex_count() == 3);
  CHECK(mesh.triangle_count() == 1);
}

TEST_CASE("obj: triangulates polygons, also those of vertices still to come", "[obj]") {
  const TriangleMesh mesh = read_bytes(kObj, "f 1 2 3 4\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 4 3 2 1\n");
  CHECK(mesh.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {3, 2, 1}, {3, 1, 0}});
}

TEST_CASE("obj: reads colours behind the positions in either scale", "[obj][colour]") {
  const std::string face = "f 1 2 3\n";
  CHECK(read_bytes(kObj, "v 0 0 0 1 0.5 0\nv 1 0 0 0 0 0\nv 0 1 0 0 0 1\n" + face).colors ==
        std::vector<Color>{{255, 128, 0}, {0, 0, 0}, {0, 0, 255}});
  CHECK(read_bytes(kObj, "v 0 0 0 255 51 0\nv 1 0 0 0 0 0\nv 0 1 0 0 0 1\n" + face).colors.at(0) ==
        Color{255, 51, 0});
  // Vertices without a colour among coloured ones are white.
  CHECK(read_bytes(kObj, "v 0 0 0\nv 1 0 0 0 0 0\nv 0 1 0\n" + face).colors ==
        std::vector<Color>{{255, 255, 255}, {0, 0, 0}, {255, 255, 255}});
  const TriangleMesh with_normals = read_bytes(kObj, "v 0 0 0 0 0 -1\nv 1 0 0 0 0 1\nv 0 1 0 0 0 1\n" + face);
  CHECK(with_normals.colors.empty());
  CHECK(mentions(with_normals.dropped_properties, "some are negative"));
}

TEST_CASE("obj: reads ZBrush's polypaint comments", "[obj][colour]") {
  const TriangleMesh mesh =
      read_bytes(kObj, "v 0 0 0\nv 1 0 0\nv 0 1 0\n#MRGB ffff0000ff00FF00\n#MRGB ff000010\nf 1 2 3\n");
  CHECK(mesh.colors == std::vector<Color>{{255, 0, 0}, {0, 255, 0}, {0, 0, 16}});
  CHECK(mentions(read_bytes(kObj, "v 0 0 0\nv 1 0 0\nv 0 1 0\n#MRGB ffff0000\nf 1 2 3\n").dropped_properties,
                 "#MRGB"));
}

TEST_CASE("obj: reports what it leaves out and does not need the material file", "[obj]") {
  const TriangleMesh mesh =
      read_bytes(kObj,
                 "mtllib missing.mtl\no thing\ng a b\nv 0 0 0 2\nv 1 0 0\nv 0 1 0\nusemtl red\n"
                 "s off\nf 1 2 3\nl 1 2\np 1\nf 1 2\nlod 3\n");
  CHECK(mesh.triangle_count() == 1);
  for (const char* what :
       {"object names", "group names", "line elements", "point elements", "smoothing groups",
        "material references", "vertex weights", "fewer than three corners", "'lod'"}) {
    CAPTURE(what);
    CHECK(mentions(mesh.dropped_properties, what));
  }
}

TEST_CASE("obj: names the line of what is malformed", "[obj][malformed]") {
  const auto invalid = [](const std::string& text, const std::string& part) {
    require_failure(kObj, text, ExitCode::kInvalidInput, part);
  };
  invalid("\n\n", "the file has no vertices");
  invalid("v 0 0 0\nv 1 2\n", "mesh: line 2: a vertex of 2 coordinates");
  invalid("v 0 0 0\nv 1 2 3,5\n", "line 2: '3,5' is not a number");
  invalid("v 0 0 0\nf 1 1 2\nf 1 1 9\nf 1 1 1\n", "line 3: vertex index 9, but there are 1 vertices");
  invalid("v 0 0 0\nf 0 1 1\n", "line 2: vertex index 0");
  invalid("v 0 0 0\nf 1 1 -2\nv 0 0 0\n", "line 2: vertex index -2, but only 1 vertices come before it");
  invalid("v 0 0 0\nf a b c\n", "line 2: 'a' is not a vertex reference");
  invalid("v 0 0 0\nf 1 2x 3\n", "line 2: '2x' is not a vertex reference");
  invalid("v 0 0 0\nf\n", "line 2: a face without corners");
  invalid("v 0 0 0\nf 1 1 99999999999999999999\n", "line 2");
  invalid("v 0 0 0\nf 1 1 4294967296\n", "line 2: vertex index 4294967296 is above the limit");
  invalid("v 0 0 0\n\n@!? 3\n", "line 3: '@!?' is not an OBJ statement");
  invalid("v 0 0 0\nf 1 \\\n1 x\n", "line 2: 'x'");
  invalid("v 0 0 0\n#MRGB ffff00zz\n", "line 2: a '#MRGB' block");
}

}  // namespace
}  // namespace nmc
