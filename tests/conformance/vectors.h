// SPDX-License-Identifier: Apache-2.0
// The table of vectors as it lies in tests/conformance/vectors.
#ifndef NMC_TESTS_CONFORMANCE_VECTORS_H_
#define NMC_TESTS_CONFORMANCE_VECTORS_H_

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/stream_decoding.h"

namespace nmc::test {

namespace fs = std::filesystem;
using Json = nlohmann::json;

inline const fs::path kVectors = fs::path(NMC_SOURCE_DIR) / "tests/conformance/vectors";

struct Vector {
  std::string id, what, status, error_section;
  std::uint64_t error_offset = 0;
  std::vector<DecodedLayer> layers;
  nmc_limits limits = nmc_default_limits();
  std::vector<std::uint8_t> bytes;
};

inline Json read_json(const fs::path& path) {
  std::ifstream in(path);
  INFO(path.string());
  REQUIRE(in.good());
  return Json::parse(in);
}

/// All vectors of the index; one that is missing fails the test at hand.
inline std::vector<Vector> read_vectors() {
  std::vector<Vector> vectors;
  for (const Json& entry : read_json(kVectors / "index.json")) {
    Vector vector;
    vector.id = entry.get<std::string>();
    const Json expected = read_json(kVectors / vector.id / "expected.json");
    vector.what = expected.value("what", "");
    vector.status = expected["status"].get<std::string>();
    vector.error_offset = expected.value("errorOffset", std::uint64_t{0});
    vector.error_section = expected.value("errorSection", "");
    const Json given = expected.value("limits", Json::object());
    vector.limits.max_vertices = given.value("maxVertices", vector.limits.max_vertices);
    vector.limits.max_memory = given.value("maxMemory", vector.limits.max_memory);
    vector.limits.max_levels = given.value("maxLevels", vector.limits.max_levels);
    vector.limits.max_base_vertices = given.value("maxBaseVertices", vector.limits.max_base_vertices);
    for (const Json& row : expected["layers"]) {
      const auto hash = [&](const char* name) {
        return std::stoull(row[name].get<std::string>(), nullptr, 16);
      };
      vector.layers.push_back({static_cast<std::uint32_t>(vector.layers.size()),
                               row["level"].get<std::uint32_t>(), row["endByte"].get<std::uint64_t>(),
                               hash("stateHash"), hash("positionHash")});
      for (const Json& text : row.value("attributeHashes", Json::array()))
        vector.layers.back().attribute_hashes.push_back(std::stoull(text.get<std::string>(), nullptr, 16));
    }
    std::ifstream stream(kVectors / vector.id / "stream.nmc", std::ios::binary);
    INFO("vector " << vector.id);
    REQUIRE(stream.good());
    vector.bytes.assign(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
    vectors.push_back(std::move(vector));
  }
  return vectors;
}

}  // namespace nmc::test

#endif  // NMC_TESTS_CONFORMANCE_VECTORS_H_
