// SPDX-License-Identifier: Apache-2.0
#include "encoder/core/triangle_mesh.h"

#include <algorithm>

namespace nmc {

namespace {
void extend(BoundingBox& box, const Vec3& p) {
  for (int k = 0; k < 3; ++k) {
    box.minimum[k] = std::min(box.minimum[k], p[k]);
    box.maximum[k] = std::max(box.maximum[k], p[k]);
  }
}
}  // namespace

BoundingBox bounding_box(const TriangleMesh& mesh) {
  if (mesh.positions.empty()) return {};
  if (mesh.triangles.empty()) {
    BoundingBox box{mesh.positions[0], mesh.positions[0]};
    for (const Vec3& p : mesh.positions) extend(box, p);
    return box;
  }
  BoundingBox box{mesh.positions[mesh.triangles[0][0]], mesh.positions[mesh.triangles[0][0]]};
  for (const Triangle& t : mesh.triangles)
    for (const std::uint32_t v : t) extend(box, mesh.positions[v]);
  return box;
}

double surface_area(const TriangleMesh& mesh) {
  double area = 0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3& a = mesh.positions[t[0]];
    area += 0.5 * norm(cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a));
  }
  return area;
}

std::vector<Vec3> vertex_normals(const TriangleMesh& mesh) {
  std::vector<Vec3> normals(mesh.vertex_count());
  for (const Triangle& t : mesh.triangles) {
    const Vec3& a = mesh.positions[t[0]];
    const Vec3 n = cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a);
    for (const std::uint32_t v : t) normals[v] += n;
  }
  for (Vec3& n : normals) n = normalized(n);
  return normals;
}

}  // namespace nmc
