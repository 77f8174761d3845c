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

#include "tests/conformance/vectors.h"
#include "tests/support/reference_comparison.h"

using namespace nmc::test;
TEST_CASE("conformance: the library agrees with every vector, in one piece and byte by byte",
          "[conformance]") {
  const std::vector<Vector> vectors = read_vectors();
  REQUIRE(vectors.size() >= 60);
  for (const Vector& vector : vectors) {
    INFO("vector " << vector.id << ": " << vector.what);
    for (const std::size_t piece : {~std::size_t{0}, std::size_t{1}}) {
      const Decoding decoding = decode(vector.bytes, {piece}, &vector.limits);
      INFO("in pieces of " << piece << ": " << decoding);
      CHECK(nmc_status_name(decoding.status) == vector.status);
      if (decoding.status != NMC_OK) {
        CHECK(decoding.error.byte_offset == vector.error_offset);
        CHECK(decoding.error.spec_section == vector.error_section);
      }
      REQUIRE(decoding.layers.size() == vector.layers.size());
      for (std::size_t i = 0; i < decoding.layers.size(); ++i) CHECK(decoding.layers[i] == vector.layers[i]);
    }
  }
}

TEST_CASE("conformance: the reference decoder agrees with every vector", "[conformance][reference]") {
  for (const Vector& vector : read_vectors()) {
    INFO("vector " << vector.id << ": " << vector.what);
    const nmc_reference::Decoding decoding =
        nmc_reference::decode(vector.bytes, reference_limits(vector.limits));
    CHECK((decoding.code == nmc_reference::Code::kOk
               ? "NMC_OK"
               : std::string("NMC_ERR_") + name_of(decoding.code)) == vector.status);
    if (decoding.code != nmc_reference::Code::kOk) {
      CHECK(decoding.offset == vector.error_offset);
      CHECK(decoding.section == vector.error_section);
    }
    REQUIRE(decoding.rows.size() == vector.layers.size());
    for (std::size_t i = 0; i < decoding.rows.size(); ++i) {
      const nmc_reference::Row& row = decoding.rows[i];
      CHECK(DecodedLayer{static_cast<std::uint32_t>(i), row.level, row.end_offset, row.state_hash,
                         row.position_hash, row.attribute_hashes} == vector.layers[i]);
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
