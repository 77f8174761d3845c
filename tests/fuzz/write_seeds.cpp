// SPDX-License-Identifier: Apache-2.0
// nmc_fuzz_seeds FOLDER: writes the small valid files that the fuzz targets start from, one folder per
// target.
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>

#include "tests/unit/read/tiny_meshes.h"

int main(int argument_count, char** arguments) {
  if (argument_count != 2) {
    std::fprintf(stderr, "usage: nmc_fuzz_seeds FOLDER\n");
    return 1;
  }
  static constexpr std::array<std::pair<nmc::MeshFormat, const char*>, 5> kTargets = {
      {{nmc::MeshFormat::kPly, "read_ply"},
       {nmc::MeshFormat::kObj, "read_obj"},
       {nmc::MeshFormat::kStl, "read_stl"},
       {nmc::MeshFormat::kOff, "read_off"},
       {nmc::MeshFormat::kGltf, "read_gltf"}}};
  for (const nmc::test::TinyMesh& mesh : nmc::test::tiny_meshes()) {
    for (const auto& [format, target] : kTargets) {
      if (format != mesh.format) continue;
      const std::filesystem::path folder = std::filesystem::path(arguments[1]) / target;
      std::filesystem::create_directories(folder);
      std::ofstream file(folder / mesh.name, std::ios::binary);
      file << mesh.bytes;
      if (!file.flush()) {
        std::fprintf(stderr, "%s: cannot be written\n", (folder / mesh.name).c_str());
        return 2;
      }
    }
  }
  return 0;
}
