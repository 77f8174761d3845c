// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "libnmc/common/coded_mesh.h"
#include "libnmc/decode/range_decoder.h"
#include "libnmc/encode/base_face_lookup.h"
#include "libnmc/encode/range_encoder.h"
#include "tests/support/random_base_mesh.h"

using namespace nmc;
using test::RandomIntegers;
using test::SmallMesh;

namespace {

/// A face as a set that remembers its orientation: its smallest corner first.
std::array<std::uint32_t, 3> canonical(std::array<std::uint32_t, 3> f) {
  std::rotate(f.begin(), std::min_element(f.begin(), f.end()), f.end());
  return f;
}

struct Coded {
  std::size_t byte_count = 0;
  std::size_t wrong_coordinates = 0;
  bool same_faces = false;
};

/// Codes and decodes connectivity and coordinates, and compares in the numbering of the caller.
Coded round_trip(const SmallMesh& mesh, const std::vector<std::int32_t>& coordinates) {
  const auto face_count = static_cast<std::uint32_t>(mesh.faces.size());
  Header header;
  header.base_vertex_count = mesh.vertex_count;
  header.base_face_count = face_count;
  BaseFaceLookup lookup(nullptr);
  REQUIRE(lookup.build(mesh.faces[0].data(), face_count, mesh.vertex_count, nullptr).ok());
  Array<std::uint8_t> bytes;
  Array<std::uint32_t> old_index;
  CodedMesh encoded(nullptr, &header);
  RangeEncoder encoder(bytes);
  const Status coded =
      encoded.code_base(encoder, &lookup, lookup.seeds(), coordinates.data(), nullptr, &old_index);
  INFO(mesh.name << ": " << (coded.message() ? coded.message() : ""));
  REQUIRE(coded.ok());
  encoder.finish();

  CodedMesh decoded(nullptr, &header);
  RangeDecoder decoder(bytes.data(), bytes.size());
  const Status status = decoded.code_base(decoder, nullptr, nullptr, nullptr, nullptr, nullptr);
  INFO((status.message() ? status.message() : ""));
  REQUIRE(status.ok());
  REQUIRE(decoder.check().ok());
  CHECK(decoded.state_hash() == encoded.state_hash());

  std::vector<std::array<std::uint32_t, 3>> expected, found;
  for (const auto& face : mesh.faces) expected.push_back(canonical(face));
  for (std::uint32_t f = 0; f < face_count; ++f) {
    const std::uint32_t* v = decoded.base().face_vertices.data() + 3 * f;
    found.push_back(canonical({old_index[v[0]], old_index[v[1]], old_index[v[2]]}));
  }
  std::sort(expected.begin(), expected.end());
  std::sort(found.begin(), found.end());
  Coded result;
  result.byte_count = bytes.size();
  result.same_faces = expected == found;
  for (std::uint32_t v = 0; v < mesh.vertex_count; ++v)
    for (std::uint32_t k = 0; k < 3; ++k)
      result.wrong_coordinates += decoded.base().coordinates[3 * v + k] != coordinates[3 * old_index[v] + k];
  return result;
}

std::vector<std::int32_t> random_coordinates(const SmallMesh& mesh, RandomIntegers& random,
                                             std::int64_t largest) {
  std::vector<std::int32_t> coordinates(3 * mesh.vertex_count);
  for (std::int32_t& x : coordinates) x = static_cast<std::int32_t>(random.between(-largest, largest));
  return coordinates;
}

}  // namespace

TEST_CASE("base mesh coder: round-trips every kind of small mesh", "[base]") {
  RandomIntegers random(1);
  for (SmallMesh mesh : test::all_small_meshes()) {
    for (int i = 0; i < 5; ++i) {
      const Coded coded = round_trip(mesh, random_coordinates(mesh, random, 1000));
      INFO(mesh.name);
      CHECK(coded.same_faces);
      CHECK(coded.wrong_coordinates == 0);
      test::shuffle(mesh, random);
    }
  }
}

TEST_CASE("base mesh coder: round-trips random manifolds with handles, holes and several components",
          "[base]") {
  int handles = 0, boundaries = 0;
  for (std::uint64_t seed = 1; seed <= 1500; ++seed) {
    RandomIntegers random(seed);
    const SmallMesh mesh = test::random_base_mesh(random, static_cast<int>(random.between(0, 60)));
    LevelTopology topology;
    REQUIRE(test::build(mesh, topology).ok());
    bool has_boundary = false;
    for (std::uint32_t e = 0; e < topology.edge_count; ++e) has_boundary |= topology.is_boundary(e);
    const std::int64_t euler =
        std::int64_t{topology.vertex_count} - topology.edge_count + topology.face_count;
    handles += !has_boundary && euler <= 0;
    boundaries += has_boundary;
    const std::int64_t largest = random.chance(0.2) ? kMaximumBaseCoordinate : random.between(0, 3000);
    const Coded coded = round_trip(mesh, random_coordinates(mesh, random, largest));
    INFO("seed " << seed << ": V " << mesh.vertex_count << " F " << mesh.faces.size());
    CHECK(coded.same_faces);
    CHECK(coded.wrong_coordinates == 0);
  }
  // The generator reaches what the name of this test promises.
  CHECK(handles > 10);
  CHECK(boundaries > 300);
}

TEST_CASE("base mesh coder: high genus and long borders", "[base]") {
  RandomIntegers random(11);
  SmallMesh mesh = test::grid(12, 12, true);
  int handles = 0;
  for (int attempt = 0; attempt < 3000 && handles < 40; ++attempt) {
    const std::size_t before = mesh.faces.size();
    test::change_randomly(mesh, random);
    handles += mesh.faces.size() == before + 4;
  }
  REQUIRE(handles == 40);
  test::shuffle(mesh, random);
  const Coded coded = round_trip(mesh, random_coordinates(mesh, random, 500));
  CHECK(coded.same_faces);
  CHECK(coded.wrong_coordinates == 0);
}

TEST_CASE("base mesh coder: extreme coordinates come back exactly", "[base]") {
  const SmallMesh mesh = test::tetrahedron();
  const std::int32_t m = kMaximumBaseCoordinate;
  const Coded coded = round_trip(mesh, {m, -m, m, -m, m, -m, m, m, m, -m, -m, 0});
  CHECK(coded.same_faces);
  CHECK(coded.wrong_coordinates == 0);
}

TEST_CASE("base mesh coder: a regular mesh costs little", "[base]") {
  const SmallMesh mesh = test::grid(20, 20, true);
  std::vector<std::int32_t> coordinates;
  for (std::uint32_t v = 0; v < mesh.vertex_count; ++v) {
    for (const std::uint32_t x : {v % 20 * 100, v / 20 * 100, 0u})
      coordinates.push_back(static_cast<std::int32_t>(x));
  }
  const Coded coded = round_trip(mesh, coordinates);
  CHECK(coded.same_faces);
  // 400 vertices: less than two bytes each with connectivity and all coordinates.
  CHECK(coded.byte_count < 800);
}
