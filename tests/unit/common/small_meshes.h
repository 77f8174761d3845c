// SPDX-License-Identifier: Apache-2.0
// Base meshes of every kind of neighbourhood, and a deterministic source of numbers, for the tests of common.
#ifndef NMC_TESTS_UNIT_COMMON_SMALL_MESHES_H_
#define NMC_TESTS_UNIT_COMMON_SMALL_MESHES_H_

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "libnmc/common/butterfly.h"
#include "libnmc/common/subdivision.h"
#include "libnmc/common/vec3.h"

namespace nmc::test {

/// A list of base faces, and pairs of vertices whose edge is a crease.
struct SmallMesh {
  std::string name;
  std::uint32_t vertex_count = 0;
  std::vector<std::array<std::uint32_t, 3>> faces;
  std::vector<std::array<std::uint32_t, 2>> creases;
};

inline SmallMesh tetrahedron() {
  return {"tetrahedron", 4, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}, {}};
}

/// Columns times rows quads, each cut along the same diagonal; closed in both directions to a torus on
/// request.
inline SmallMesh grid(std::uint32_t columns, std::uint32_t rows, bool torus) {
  SmallMesh mesh;
  mesh.name = torus ? "torus" : "sheet";
  const std::uint32_t width = torus ? columns : columns + 1, height = torus ? rows : rows + 1;
  mesh.vertex_count = width * height;
  const auto id = [&](std::uint32_t i, std::uint32_t j) { return (j % height) * width + i % width; };
  for (std::uint32_t j = 0; j < rows; ++j) {
    for (std::uint32_t i = 0; i < columns; ++i) {
      mesh.faces.push_back({id(i, j), id(i + 1, j), id(i, j + 1)});
      mesh.faces.push_back({id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  }
  return mesh;
}

/// A fan of `valence` faces around vertex 0, closed underneath by a second fan around the last vertex.
inline SmallMesh bipyramid(std::uint32_t valence) {
  SmallMesh mesh;
  mesh.name = "bipyramid " + std::to_string(valence);
  mesh.vertex_count = valence + 2;
  for (std::uint32_t i = 0; i < valence; ++i) {
    const std::uint32_t p = 1 + i, q = 1 + (i + 1) % valence;
    mesh.faces.push_back({0, p, q});
    mesh.faces.push_back({valence + 1, q, p});
  }
  return mesh;
}

/// An open fan of `face_count` faces; closed to a disk around vertex 0 on request.
inline SmallMesh fan(std::uint32_t face_count, bool closed) {
  SmallMesh mesh;
  mesh.name = (closed ? "disk " : "fan ") + std::to_string(face_count);
  mesh.vertex_count = 1 + face_count + (closed ? 0 : 1);
  for (std::uint32_t i = 0; i < face_count; ++i) {
    mesh.faces.push_back({0, 1 + i, closed ? 1 + (i + 1) % face_count : 2 + i});
  }
  return mesh;
}

inline SmallMesh creased_tetrahedron() {
  SmallMesh mesh = tetrahedron();
  mesh.name = "tetrahedron with a crease of two edges";
  mesh.creases = {{0, 1}, {1, 2}};
  return mesh;
}

inline SmallMesh creased_bipyramid() {
  SmallMesh mesh = bipyramid(6);
  mesh.name = "bipyramid with a closed crease, a corner of four and a dart";
  for (std::uint32_t i = 0; i < 6; ++i) mesh.creases.push_back({1 + i, 1 + (i + 1) % 6});
  mesh.creases.push_back({0, 1});
  mesh.creases.push_back({7, 1});
  return mesh;
}

inline std::vector<SmallMesh> all_small_meshes() {
  return {tetrahedron(), grid(3, 4, true), grid(3, 2, false),     fan(1, false),
          fan(3, false), fan(5, true),     bipyramid(3),          bipyramid(5),
          bipyramid(7),  bipyramid(12),    creased_tetrahedron(), creased_bipyramid()};
}

inline Status build(const SmallMesh& mesh, LevelTopology& topology) {
  const Status status = build_base_topology(mesh.faces.empty() ? nullptr : mesh.faces.front().data(),
                                            static_cast<std::uint32_t>(mesh.faces.size()), mesh.vertex_count,
                                            nullptr, topology);
  if (!status.ok() || mesh.creases.empty()) return status;
  std::vector<std::uint8_t> is_crease(topology.edge_count, 0);
  for (const auto& crease : mesh.creases) {
    for (std::uint32_t e = 0; e < topology.edge_count; ++e) {
      const std::uint32_t a = topology.edge_vertices[2 * e], b = topology.edge_vertices[2 * e + 1];
      if ((a == crease[0] && b == crease[1]) || (a == crease[1] && b == crease[0])) is_crease[e] = 1;
    }
  }
  return set_creases(is_crease.data(), topology);
}

/// SplitMix64 (Steele, Lea, Flood 2014).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  double uniform(double low = -1, double high = 1) {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    z ^= z >> 31;
    return low + (high - low) * static_cast<double>(z >> 11) * 0x1p-53;
  }
  Vec3 point() {
    const double x = uniform(), y = uniform();
    return {x, y, uniform()};
  }

 private:
  std::uint64_t state_;
};

}  // namespace nmc::test

#endif  // NMC_TESTS_UNIT_COMMON_SMALL_MESHES_H_
