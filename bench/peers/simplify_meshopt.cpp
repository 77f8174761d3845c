// SPDX-License-Identifier: Apache-2.0
// Based on: meshoptimizer's quadric simplifier (keeps original vertices, never changes the topology).
#include <meshoptimizer.h>

#include "bench/peers/peer.h"

namespace nmc::bench {

TriangleMesh MeshoptSimplifier::simplify(std::size_t triangle_count) {
  const Vec3 center = bounding_box(mesh_).center();
  std::vector<float> positions;
  for (const Vec3& point : mesh_.positions) {
    const Vec3 p = point - center;
    for (int i = 0; i < 3; ++i) positions.push_back(static_cast<float>(p[i]));
  }
  std::vector<unsigned> indices;
  for (const Triangle& triangle : mesh_.triangles)
    indices.insert(indices.end(), triangle.begin(), triangle.end());
  std::vector<unsigned> kept(indices.size());
  constexpr float kAnyError = 1e9f;
  kept.resize(meshopt_simplify(kept.data(), indices.data(), indices.size(), positions.data(),
                               mesh_.vertex_count(), 3 * sizeof(float), 3 * triangle_count, kAnyError, 0,
                               nullptr));
  TriangleMesh simplified;
  simplified.positions = mesh_.positions;
  for (std::size_t i = 0; i + 2 < kept.size(); i += 3) {
    simplified.triangles.push_back({kept[i], kept[i + 1], kept[i + 2]});
  }
  return weld_equal_positions(simplified);
}

}  // namespace nmc::bench
