// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <catch2/catch.hpp>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "decoder/write/mesh_writer.h"

using namespace nmc;

namespace {

std::string bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::uint32_t word_at(const std::string& bytes, std::size_t offset) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + offset, sizeof word);
  return word;
}

}  // namespace

TEST_CASE("A progressive GLB holds a plain mesh and, behind it, the stream byte for byte") {
  const std::array<double, 9> positions = {1000, 0, 0, 1001, 0, 0, 1000, 1, 0};  // far from the origin
  const std::array<std::uint32_t, 3> triangles = {0, 1, 2};
  MeshView mesh;
  mesh.positions_double = positions;
  mesh.triangles = triangles;
  const std::vector<std::uint8_t> stream = {0x8e, 'N', 'M', 'C', 1, 2, 3};
  const std::array<ProgressiveLayer, 2> layers = {{{5, 4, false, 0}, {7, 16, true, 0.25}}};
  ProgressiveStream progressive;
  progressive.bytes = stream;
  progressive.box_maximum = {1, 2, 3};
  progressive.layers = layers;
  const std::string path = (std::filesystem::temp_directory_path() / "nmc_progressive_glb_test.glb").string();
  REQUIRE(write_progressive_glb(path, mesh, progressive).is_ok());

  const std::string file = bytes_of(path);
  std::filesystem::remove(path);
  REQUIRE(file.size() > 28);
  CHECK(file.substr(0, 4) == "glTF");
  CHECK(word_at(file, 8) == file.size());
  const std::size_t json_size = word_at(file, 12);
  const std::string json = file.substr(20, json_size);
  CHECK(json.find(R"("extensionsUsed":["NMC_progressive_mesh"])") != std::string::npos);
  CHECK(json.find(R"("NMC_progressive_mesh":{"bufferView":2,)") != std::string::npos);
  CHECK(
      json.find(
          R"("layers":[{"byteLength":5,"triangles":4},{"byteLength":7,"triangles":16,"geometricError":0.25}])") !=
      std::string::npos);
  // The stream's positions are in model units, so the plain mesh's are too.
  CHECK(json.find("translation") == std::string::npos);
  const std::string binary = file.substr(20 + json_size + 8);
  CHECK(binary.size() % 4 == 0);
  CHECK(binary.substr(binary.size() - 8, 7) == std::string(stream.begin(), stream.end()));
}

TEST_CASE("A progressive GLB needs a plain mesh") {
  CHECK(write_progressive_glb("unused.glb", {}, {}).outcome == WriteOutcome::kInvalidMesh);
}
