// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/read/gltf_builder.h"
#include "tests/unit/read/read_test_tools.h"
#include "tests/unit/read/tiny_meshes.h"

namespace nmc {
namespace {

using test::Bytes;
using test::glb;
using test::mentions;
using test::read_bytes;
using test::require_failure;

constexpr MeshFormat kGltf = MeshFormat::kGltf;
using Color = std::array<std::uint8_t, 3>;

const std::string kStart = R"({"asset":{"version":"2.0"},)";

/// Three corners of a right angle, 36 bytes.
std::string corner_positions() { return Bytes().numbers<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}).string(); }

/// A document around `members`, with the corner positions as accessor 0.
std::string with_corner(const std::string& members,
                        const std::string& primitive = R"({"attributes":{"POSITION":0}})") {
  return glb(kStart + R"("buffers":[{"byteLength":36}],"bufferViews":[{"buffer":0,"byteLength":36}],)" +
                 R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],)" +
                 R"("meshes":[{"primitives":[)" + primitive + "]}]" + members + "}",
             corner_positions());
}

TEST_CASE("gltf: reads strips, instances, mirrored nodes, sparse, strided and quantized accessors",
          "[gltf]") {
  for (const test::TinyMesh& tiny : test::tiny_meshes()) {
    if (tiny.format != kGltf) continue;
    CAPTURE(tiny.name);
    const TriangleMesh mesh = read_bytes(kGltf, tiny.bytes);
    REQUIRE(mesh.vertex_count() == 4 + 4 + 3);
    // The strip 0 1 2 2 3 has one triangle and two joints; its second instance hangs below the first and
    // mirrors.
    const std::vector<Triangle> expected = {{0, 1, 2}, {4, 6, 5}, {8, 9, 10}, {9, 10, 8}};
    CHECK(mesh.triangles == expected);
    CHECK(mesh.positions[1] == Vec3{2, 2, 3});
    CHECK(mesh.positions[3] == Vec3{3, 4, 5});  // replaced by the sparse value 2 2 2
    CHECK(mesh.positions[5] == Vec3{0, 2, 3});
    CHECK(mesh.positions[9].x == Approx(2 + 2 * 10000 / 32767.0));
    CHECK(mesh.positions[9].y == 0);  // -32768 is clamped to -1, times 2, plus 2
    REQUIRE(mesh.colors.size() == mesh.vertex_count());
    CHECK(mesh.colors[0] == Color{255, 188, 0});  // linear 128/255
    CHECK(mesh.colors[8] == Color{255, 255, 255});
    CHECK(mentions(mesh.dropped_properties, "points or lines"));
    CHECK_FALSE(mentions(mesh.dropped_properties, "opacities"));
  }
}

TEST_CASE("gltf: applies translation, rotation and scale down the tree", "[gltf]") {
  // Scale by 2, a quarter turn about z, then a shift; the parent shifts by 10 along x.
  const TriangleMesh mesh = read_bytes(
      kGltf,
      with_corner(
          R"(,"nodes":[{"children":[1],"translation":[10,0,0]},{"mesh":0,"translation":[0,0,1],)"
          R"("rotation":[0,0,0.7071067811865476,0.7071067811865476],"scale":[2,2,2]}],"scenes":[{"nodes":[0]}])"));
  REQUIRE(mesh.vertex_count() == 3);
  CHECK(distance(mesh.positions[1], {10, 2, 1}) < 1e-12);
  CHECK(distance(mesh.positions[2], {8, 0, 1}) < 1e-12);
}

TEST_CASE("gltf: shows only the default scene, and all roots or meshes where there is none", "[gltf]") {
  const std::string nodes = R"(,"nodes":[{"mesh":0},{"children":[2]},{"mesh":0}])";
  CHECK(read_bytes(kGltf, with_corner("")).triangle_count() == 1);
  CHECK(read_bytes(kGltf, with_corner(nodes)).triangle_count() == 2);
  CHECK(read_bytes(kGltf, with_corner(nodes + R"(,"scenes":[{"nodes":[0]},{"nodes":[0,1]}])"))
            .triangle_count() == 1);
  CHECK(read_bytes(kGltf, with_corner(nodes + R"(,"scene":1,"scenes":[{"nodes":[0]},{"nodes":[0,1]}])"))
            .triangle_count() == 2);
}

TEST_CASE("gltf: primitives that share their vertices share them in the mesh", "[gltf]") {
  const std::string primitive = R"({"attributes":{"POSITION":0}},{"attributes":{"POSITION":0}})";
  const TriangleMesh mesh = read_bytes(kGltf, with_corner("", primitive));
  CHECK(mesh.vertex_count() == 3);
  CHECK(mesh.triangle_count() == 2);
}

TEST_CASE(
    "gltf: refuses compressed meshes with a clear reason, and takes their plain copy where there is one",
    "[gltf]") {
  for (const char* extension :
       {"KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"}) {
    require_failure(kGltf, with_corner(std::string(R"(,"extensionsRequired":[")") + extension + R"("])"),
                    ExitCode::kUnsupported, std::string("compressed with ") + extension);
  }
  const std::string draco =
      R"("extensions":{"KHR_draco_mesh_compression":{"bufferView":0,"attributes":{"POSITION":0}}})";
  CHECK(
      read_bytes(kGltf, with_corner("", R"({"attributes":{"POSITION":0},)" + draco + "}")).triangle_count() ==
      1);
  require_failure(kGltf,
                  glb(kStart + R"("accessors":[{"componentType":5126,"count":3,"type":"VEC3"}],)" +
                      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},)" + draco + "}]}]}"),
                  ExitCode::kUnsupported, "meshes[0].primitives[0]: compressed with KHR_draco");
  const auto meshopt = [](const std::string& buffers) {
    return glb(
        kStart + buffers +
            R"("bufferViews":[{"buffer":1,"byteLength":36,"extensions":{"EXT_meshopt_compression":{"buffer":0}}}],)" +
            R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],)" +
            R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}]})",
        "abcd");
  };
  require_failure(kGltf, meshopt(R"("buffers":[{"byteLength":4},{"byteLength":36}],)"),
                  ExitCode::kUnsupported, "bufferViews[0]: compressed with EXT_meshopt");
  CHECK(read_bytes(kGltf, meshopt(R"("buffers":[{"byteLength":4},{"byteLength":36,"uri":"data:;base64,)" +
                                  test::base64(corner_positions()) + R"("}],)"))
            .triangle_count() == 1);
}

TEST_CASE("gltf: refuses required extensions it does not know and ignores those of materials", "[gltf]") {
  require_failure(kGltf, with_corner(R"(,"extensionsRequired":["ACME_tessellation"])"),
                  ExitCode::kUnsupported, "requires ACME_tessellation");
  CHECK(
      read_bytes(kGltf, with_corner(R"(,"extensionsRequired":["KHR_texture_basisu","KHR_materials_unlit"])"))
          .triangle_count() == 1);
}

TEST_CASE("gltf: never opens images and reports what is left out", "[gltf]") {
  const TriangleMesh mesh = read_bytes(
      kGltf,
      with_corner(R"(,"images":[{"uri":"/no/such.png"},{"bufferView":99},{}],"skins":[{}],"animations":[{}],)"
                  R"("nodes":[{"mesh":0,"skin":0,"translation":[9,9,9]}])",
                  R"({"attributes":{"POSITION":0,"TEXCOORD_0":7},"material":3,"targets":[{}]})"));
  CHECK(mesh.positions.at(1) == Vec3{1, 0, 0});
  for (const char* what : {"TEXCOORD_0", "material", "morph targets", "skins", "animations"}) {
    CAPTURE(what);
    CHECK(mentions(mesh.dropped_properties, what));
  }
}

TEST_CASE("gltf: says where a container or its JSON is malformed", "[gltf][malformed]") {
  const std::string whole = with_corner("");
  require_failure(kGltf, "glTF\1", ExitCode::kInvalidInput,
                  "byte offset 5: the file ends within the GLB header");
  require_failure(kGltf, whole.substr(0, whole.size() - 1), ExitCode::kInvalidInput, "the file ends before");
  std::string version_one = whole;
  version_one[4] = 1;
  require_failure(kGltf, version_one, ExitCode::kUnsupported, "byte offset 4: GLB version 1");
  std::string long_chunk = whole;
  long_chunk[15] = 1;  // the JSON chunk's size, plus 2^24
  require_failure(kGltf, long_chunk, ExitCode::kInvalidInput, "byte offset 20: a GLB chunk of");
  // The binary chunk announces as many bytes as the file has left, its own header counted in.
  const std::size_t binary_chunk = whole.find(std::string_view("BIN\0", 4)) - 4;
  std::string binary_too_long = whole;
  binary_too_long[binary_chunk] = static_cast<char>(whole.size() - binary_chunk);
  require_failure(
      kGltf, binary_too_long, ExitCode::kInvalidInput,
      "byte offset " + std::to_string(binary_chunk + 8) + ": a GLB chunk of 44 bytes, but 36 are left");
  require_failure(kGltf, R"({"asset":{"version":"2.0"},})", ExitCode::kInvalidInput,
                  "byte offset 27: malformed JSON");
  require_failure(kGltf, std::string(100000, '['), ExitCode::kInvalidInput, "malformed JSON");
  require_failure(kGltf, std::string(100000, '[') + std::string(100000, ']'), ExitCode::kInvalidInput,
                  "is no object");
  require_failure(kGltf, R"({"asset":{"version":"1.0"}})", ExitCode::kUnsupported, "glTF version '1.0'");
  require_failure(kGltf, "{}", ExitCode::kInvalidInput, "asset: missing");
}

TEST_CASE("gltf: says which object is malformed", "[gltf][malformed]") {
  const auto invalid = [](const std::string& members, const std::string& part) {
    require_failure(kGltf, glb(kStart + members + "}", corner_positions()), ExitCode::kInvalidInput, part);
  };
  const std::string mesh = R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}])";
  const auto accessor = [&](const std::string& body,
                            const std::string& view = R"({"buffer":0,"byteLength":36})") {
    return R"("buffers":[{"byteLength":36}],"bufferViews":[)" + view + R"(],"accessors":[{)" + body + "}]," +
           mesh;
  };
  const std::string vec3 = R"("componentType":5126,"type":"VEC3",)";
  invalid(mesh, "refers to accessors[0], but there are 0");
  invalid(accessor(vec3 + R"("count":4,"bufferView":0)"),
          "accessors[0]: 4 elements from byte 0 on do not fit");
  invalid(accessor(vec3 + R"("count":3,"bufferView":0,"byteOffset":4)"),
          "accessors[0]: 3 elements from byte 4");
  invalid(accessor(vec3 + R"("count":18446744073709551615,"bufferView":0)"), "do not fit");
  invalid(accessor(vec3 + R"("count":-3,"bufferView":0)"),
          "accessors[0]: 'count' is not a non-negative integer");
  invalid(accessor(vec3 + R"("count":3)"), "accessors[0]: has no data");
  invalid(accessor(vec3 + R"("count":3,"bufferView":1)"), "refers to bufferViews[1]");
  invalid(accessor(R"("componentType":5124,"type":"VEC3","count":3,"bufferView":0)"), "componentType 5124");
  invalid(accessor(R"("componentType":5126,"type":"VEC2","count":3,"bufferView":0)"), "three components");
  invalid(accessor(vec3 + R"("count":3,"bufferView":0)", R"({"buffer":0,"byteLength":37})"),
          "bufferViews[0]: bytes 0 to 37");
  invalid(accessor(vec3 + R"("count":3,"bufferView":0)",
                   R"({"buffer":0,"byteLength":36,"byteOffset":18446744073709551615})"),
          "bufferViews[0]: bytes");
  invalid(accessor(vec3 + R"("count":3,"bufferView":0)", R"({"buffer":0,"byteLength":36,"byteStride":8})"),
          "at a stride of 8");
  invalid(
      accessor(
          vec3 +
          R"("count":2000000000,"sparse":{"count":1,"indices":{"bufferView":0,"componentType":5121},"values":{"bufferView":0}})"),
      "far more than the file has data for");
  invalid(
      accessor(
          vec3 +
          R"("count":3,"sparse":{"count":1,"indices":{"bufferView":0,"componentType":5121,"byteOffset":15},"values":{"bufferView":0}})"),
      "accessors[0].sparse.indices: replaces element 63, but there are 3");
  const std::string good = accessor(vec3 + R"("count":3,"bufferView":0)");
  invalid(good + R"(,"nodes":[{"children":[0]}],"scenes":[{"nodes":[0]}])", "nodes[0]: is reached twice");
  invalid(good + R"(,"nodes":[{"mesh":0},{"children":[0,0]}],"scenes":[{"nodes":[1]}])",
          "nodes[0]: is reached twice");
  invalid(good + R"(,"nodes":[{"mesh":7}])", "nodes[0]: refers to meshes[7]");
  invalid(good + R"(,"nodes":[{"matrix":[1,2]}])", "nodes[0]: 'matrix' is not an array of 16 numbers");
  require_failure(kGltf, with_corner("", R"({"attributes":{"POSITION":0},"indices":0})"),
                  ExitCode::kInvalidInput, "accessors[0]: indices are not plain unsigned integers");
  require_failure(kGltf, with_corner("", R"({"attributes":{"POSITION":0},"mode":9})"),
                  ExitCode::kInvalidInput, "mode 9");
}

TEST_CASE("gltf: reports an index that is out of range", "[gltf][malformed]") {
  const std::string positions = corner_positions();
  const std::string document = glb(
      kStart +
          R"("buffers":[{"byteLength":48}],"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":12}],)" +
          R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},{"bufferView":1,"componentType":5125,"count":3,"type":"SCALAR"}],)" +
          R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}]})",
      positions + Bytes().numbers<std::uint32_t>({0, 1, 3}).string());
  require_failure(kGltf, document, ExitCode::kInvalidInput,
                  "accessors[1]: element 2 is vertex 3, but there are 3");
}

TEST_CASE("gltf: instances stop at the limits", "[gltf]") {
  ReadOptions options;
  options.maximum_triangles = 2;
  const std::string three = with_corner(R"(,"nodes":[{"mesh":0},{"mesh":0},{"mesh":0}])");
  std::optional<test::Failure> failure = test::failure_of(kGltf, three, options);
  REQUIRE(failure);
  CHECK(failure->code == ExitCode::kLimit);

  // A strip whose triangles are all joints gives no triangle and still counts.
  const std::string joints = glb(
      kStart + R"("buffers":[{"byteLength":36}],"bufferViews":[{"buffer":0,"byteLength":36}],)" +
          R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},)" +
          R"({"bufferView":0,"componentType":5121,"count":8,"type":"SCALAR"}],"nodes":[{"mesh":0},{"mesh":0}],)" +
          R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"mode":5}]}]})",
      corner_positions());
  CHECK(read_bytes(kGltf, joints).triangle_count() == 0);
  options.maximum_triangles = 10;
  failure = test::failure_of(kGltf, joints, options);
  REQUIRE(failure);
  CHECK(failure->code == ExitCode::kLimit);
}

}  // namespace
}  // namespace nmc
