// SPDX-License-Identifier: Apache-2.0
// The library against the table of vectors. A vector that is missing fails, and so does one that nobody
// lists.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "tests/support/stream_decoding.h"

using namespace nmc::test;
using Json = nlohmann::json;
namespace fs = std::filesystem;

namespace {

const fs::path kVectors = fs::path(NMC_SOURCE_DIR) / "tests/conformance/vectors";

Json read_json(const fs::path& path) {
  std::ifstream in(path);
  INFO(path.string());
  REQUIRE(in.good());
  return Json::parse(in);
}

nmc_limits limits_of(const Json& expected) {
  nmc_limits limits = nmc_default_limits();
  const Json given = expected.value("limits", Json::object());
  limits.max_vertices = given.value("maxVertices", limits.max_vertices);
  limits.max_memory = given.value("maxMemory", limits.max_memory);
  limits.max_levels = given.value("maxLevels", limits.max_levels);
  limits.max_base_vertices = given.value("maxBaseVertices", limits.max_base_vertices);
  return limits;
}

}  // namespace

TEST_CASE("conformance: the library agrees with every vector, in one piece and byte by byte",
          "[conformance]") {
  const Json index = read_json(kVectors / "index.json");
  REQUIRE(index.size() >= 60);
  for (const Json& entry : index) {
    const std::string id = entry.get<std::string>();
    const Json expected = read_json(kVectors / id / "expected.json");
    std::ifstream stream(kVectors / id / "stream.nmc", std::ios::binary);
    INFO("vector " << id << ": " << expected.value("what", ""));
    REQUIRE(stream.good());
    const std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(stream),
                                          std::istreambuf_iterator<char>()};
    const nmc_limits limits = limits_of(expected);
    for (const std::size_t piece : {~std::size_t{0}, std::size_t{1}}) {
      const Decoding decoding = decode(bytes, {piece}, &limits);
      INFO("in pieces of " << piece << ": " << decoding);
      CHECK(nmc_status_name(decoding.status) == expected["status"].get<std::string>());
      if (decoding.status != NMC_OK) {
        CHECK(decoding.error.byte_offset == expected["errorOffset"].get<std::uint64_t>());
        CHECK(decoding.error.spec_section == expected["errorSection"].get<std::string>());
      }
      REQUIRE(decoding.layers.size() == expected["layers"].size());
      for (std::size_t i = 0; i < decoding.layers.size(); ++i) {
        const Json& layer = expected["layers"][i];
        const auto hash = [&](const char* name) {
          return std::stoull(layer[name].get<std::string>(), nullptr, 16);
        };
        INFO("row " << i);
        CHECK(decoding.layers[i].level == layer["level"].get<std::uint32_t>());
        CHECK(decoding.layers[i].end_offset == layer["endByte"].get<std::uint64_t>());
        CHECK(decoding.layers[i].state_hash == hash("stateHash"));
        CHECK(decoding.layers[i].position_hash == hash("positionHash"));
      }
    }
  }
}

TEST_CASE("conformance: every folder is a vector of the index", "[conformance]") {
  std::set<std::string> listed;
  for (const Json& entry : read_json(kVectors / "index.json")) listed.insert(entry.get<std::string>());
  for (const auto& folder : fs::directory_iterator(kVectors)) {
    if (!folder.is_directory()) continue;
    INFO(folder.path().string());
    CHECK(listed.count(folder.path().filename().string()) == 1);
  }
}
