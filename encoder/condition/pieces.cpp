// SPDX-License-Identifier: Apache-2.0
#include "encoder/condition/pieces.h"

#include <algorithm>

#include "encoder/condition/disjoint_sets.h"

namespace nmc::conditioning {

Pieces find_pieces(const WorkingMesh& mesh, const std::vector<std::uint32_t>& opposite) {
  DisjointSets sets(mesh.triangles.size());
  for (std::uint32_t h = 0; h < opposite.size(); ++h)
    if (opposite[h] != kNone && h < opposite[h]) sets.unite(h / 3, opposite[h] / 3);
  Pieces pieces;
  pieces.of_triangle.resize(mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint32_t root = sets.find(t);
    const Vec3& origin = mesh.positions[mesh.triangles[root][0]];
    if (root == t) {
      pieces.of_triangle[t] = static_cast<std::uint32_t>(pieces.list.size());
      pieces.list.emplace_back();
      pieces.list.back().first_triangle = t;
      pieces.list.back().box = {origin, origin};
    }
    pieces.of_triangle[t] = pieces.of_triangle[root];
    Piece& piece = pieces.list[pieces.of_triangle[t]];
    ++piece.triangle_count;
    piece.area += 0.5 * norm(mesh.area_normal(t));
    const Vec3 a = mesh.positions[mesh.triangles[t][0]] - origin,
               b = mesh.positions[mesh.triangles[t][1]] - origin,
               c = mesh.positions[mesh.triangles[t][2]] - origin;
    piece.volume += dot(a, cross(b, c)) / 6;
    for (std::uint32_t k = 0; k < 3; ++k) {
      const Vec3& p = mesh.positions[mesh.triangles[t][k]];
      for (int axis = 0; axis < 3; ++axis) {
        piece.box.minimum[axis] = std::min(piece.box.minimum[axis], p[axis]);
        piece.box.maximum[axis] = std::max(piece.box.maximum[axis], p[axis]);
      }
      if (opposite[3 * t + k] == kNone) piece.is_closed = false;
    }
  }
  return pieces;
}

}  // namespace nmc::conditioning
