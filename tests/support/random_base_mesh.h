// SPDX-License-Identifier: Apache-2.0
// Random oriented manifolds as base meshes: any number of components, handles and holes, any valence.
#ifndef NMC_TESTS_SUPPORT_RANDOM_BASE_MESH_H_
#define NMC_TESTS_SUPPORT_RANDOM_BASE_MESH_H_

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "libnmc/common/subdivision.h"
#include "tests/unit/common/small_meshes.h"

namespace nmc::test {

/// Whole numbers from the documented generator of small_meshes.h.
class RandomIntegers {
 public:
  explicit RandomIntegers(std::uint64_t seed) : random_(seed) {}
  /// In [low, high].
  std::int64_t between(std::int64_t low, std::int64_t high) {
    const double count = static_cast<double>(high - low) + 1;
    const auto value = low + static_cast<std::int64_t>(random_.uniform(0, 1) * count);
    return value > high ? high : value;
  }
  bool chance(double probability) { return random_.uniform(0, 1) < probability; }
  std::uint32_t below(std::size_t count) {
    return static_cast<std::uint32_t>(between(0, static_cast<std::int64_t>(count) - 1));
  }

 private:
  Random random_;
};

inline bool is_valid(const SmallMesh& mesh) {
  LevelTopology topology;
  return build(mesh, topology).ok();
}

/// Replaces the faces listed and keeps the result if it is still a manifold; the vertex count may have grown.
inline bool try_change(SmallMesh& mesh, std::vector<std::array<std::uint32_t, 3>> faces,
                       std::uint32_t vertex_count) {
  SmallMesh changed = mesh;
  changed.faces = std::move(faces);
  changed.vertex_count = vertex_count;
  if (!is_valid(changed)) return false;
  mesh = std::move(changed);
  return true;
}

inline void append_component(SmallMesh& mesh, const SmallMesh& component) {
  for (const auto& face : component.faces) {
    mesh.faces.push_back(
        {face[0] + mesh.vertex_count, face[1] + mesh.vertex_count, face[2] + mesh.vertex_count});
  }
  mesh.vertex_count += component.vertex_count;
}

/// One random change of connectivity; most attempts succeed.
inline bool change_randomly(SmallMesh& mesh, RandomIntegers& random) {
  auto faces = mesh.faces;
  const std::uint32_t f = random.below(faces.size());
  const std::array<std::uint32_t, 3> a = faces[f];
  switch (random.below(4)) {
    case 0: {  // a new vertex inside a face
      const std::uint32_t v = mesh.vertex_count;
      faces[f] = {a[0], a[1], v};
      faces.push_back({a[1], a[2], v});
      faces.push_back({a[2], a[0], v});
      return try_change(mesh, std::move(faces), v + 1);
    }
    case 1: {  // a hole
      faces.erase(faces.begin() + f);
      return try_change(mesh, std::move(faces), mesh.vertex_count);
    }
    case 2: {  // a tube between two faces: a handle, or one component less
      const std::uint32_t g = random.below(faces.size());
      if (f == g) return false;
      const std::array<std::uint32_t, 3> b = faces[g];
      faces.erase(faces.begin() + (f > g ? f : g));
      faces.erase(faces.begin() + (f > g ? g : f));
      for (std::uint32_t k = 0; k < 3; ++k) {
        // The edge (a_k, a_k+1) faces (b_-k, b_-k-1), which runs the other way round.
        const std::uint32_t p = a[k], q = a[(k + 1) % 3], r = b[(3 - k) % 3], s = b[(5 - k) % 3];
        faces.push_back({p, q, r});
        faces.push_back({q, s, r});
      }
      return try_change(mesh, std::move(faces), mesh.vertex_count);
    }
    default: {  // an edge flip
      for (std::uint32_t g = 0; g < faces.size(); ++g) {
        for (std::uint32_t k = 0; k < 3; ++k) {
          const std::array<std::uint32_t, 3> b = faces[g];
          if (b[(k + 1) % 3] != a[1] || b[(k + 2) % 3] != a[0] || g == f) continue;
          faces[f] = {a[0], b[k], a[2]};
          faces[g] = {b[k], a[1], a[2]};
          return try_change(mesh, std::move(faces), mesh.vertex_count);
        }
      }
      return false;
    }
  }
}

/// Vertices and faces in a random order, faces starting at a random corner.
inline void shuffle(SmallMesh& mesh, RandomIntegers& random) {
  std::vector<std::uint32_t> number(mesh.vertex_count);
  for (std::uint32_t v = 0; v < mesh.vertex_count; ++v) number[v] = v;
  for (std::uint32_t v = mesh.vertex_count; v > 1; --v) std::swap(number[v - 1], number[random.below(v)]);
  for (std::size_t i = mesh.faces.size(); i > 1; --i)
    std::swap(mesh.faces[i - 1], mesh.faces[random.below(i)]);
  for (auto& face : mesh.faces) {
    const std::uint32_t turn = random.below(3);
    face = {number[face[turn]], number[face[(turn + 1) % 3]], number[face[(turn + 2) % 3]]};
  }
}

inline SmallMesh random_base_mesh(RandomIntegers& random, int change_count) {
  SmallMesh mesh;
  mesh.name = "random";
  const std::int64_t component_count = random.chance(0.6) ? 1 : random.between(2, 4);
  for (std::int64_t i = 0; i < component_count; ++i) {
    const auto size = [&] { return static_cast<std::uint32_t>(random.between(3, 6)); };
    switch (random.below(5)) {
      case 0:
        append_component(mesh, tetrahedron());
        break;
      case 1:
        append_component(mesh, bipyramid(size()));
        break;
      case 2:
        append_component(mesh, grid(size(), size(), true));
        break;
      case 3:
        append_component(mesh, grid(size() - 2, size() - 2, false));
        break;
      default:
        append_component(mesh, fan(size(), random.chance(0.5)));
        break;
    }
  }
  for (int i = 0; i < change_count; ++i) change_randomly(mesh, random);
  shuffle(mesh, random);
  return mesh;
}

}  // namespace nmc::test

#endif  // NMC_TESTS_SUPPORT_RANDOM_BASE_MESH_H_
