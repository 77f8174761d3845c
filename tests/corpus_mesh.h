// SPDX-License-Identifier: Apache-2.0
// Where tests find the shared meshes: the folder NMC_CORPUS, or ../shared/corpus beside the source tree.
#ifndef NMC_TESTS_CORPUS_MESH_H_
#define NMC_TESTS_CORPUS_MESH_H_

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

namespace nmc::test {

/// The path of a corpus mesh. Where it is missing the test fails under CI (the variable CI is set) and
/// elsewhere says so and gets nothing.
inline std::optional<std::string> corpus_mesh(const std::string& name) {
  const char* folder = std::getenv("NMC_CORPUS");
  const std::filesystem::path path =
      (folder != nullptr ? std::filesystem::path(folder)
                         : std::filesystem::path(NMC_SOURCE_DIR) / "../shared/corpus") /
      name;
  if (std::filesystem::exists(path)) return path.string();
  if (std::getenv("CI") != nullptr) FAIL("corpus mesh is missing: " << path);
  WARN("left out, corpus mesh is missing: " << path);
  return std::nullopt;
}

}  // namespace nmc::test

#endif  // NMC_TESTS_CORPUS_MESH_H_
