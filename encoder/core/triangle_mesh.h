// SPDX-License-Identifier: Apache-2.0
// The plain indexed triangle mesh that all rooms of the encoder exchange.
#ifndef NMC_ENCODER_CORE_TRIANGLE_MESH_H_
#define NMC_ENCODER_CORE_TRIANGLE_MESH_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "libnmc/common/vec3.h"

namespace nmc {

/// Three vertex indices, counter-clockwise seen from outside.
using Triangle = std::array<std::uint32_t, 3>;

/// A named signal with one value per vertex, for example "quality" or "nx" "ny" "nz".
struct VertexAttribute {
  std::string name;
  int component_count = 1;
  std::vector<float> values;  // component_count per vertex
};

struct TriangleMesh {
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;
  std::vector<std::array<std::uint8_t, 3>> colors;  // sRGB; empty, or one per vertex
  std::vector<VertexAttribute> attributes;
  std::vector<std::string> dropped_properties;  // what the file holds and this mesh does not: name and reason

  std::size_t vertex_count() const { return positions.size(); }
  std::size_t triangle_count() const { return triangles.size(); }
};

struct BoundingBox {
  Vec3 minimum, maximum;
  double diagonal() const { return distance(minimum, maximum); }
  Vec3 center() const { return 0.5 * (minimum + maximum); }
};

/// The box of the vertices that a triangle uses; of all vertices when there is no triangle. O(n).
BoundingBox bounding_box(const TriangleMesh& mesh);

/// Sum of the triangles' areas in squared units of the positions. O(n).
double surface_area(const TriangleMesh& mesh);

/// Area-weighted vertex normals of unit length ((0,0,1) where the triangles cancel out). O(n).
std::vector<Vec3> vertex_normals(const TriangleMesh& mesh);

}  // namespace nmc

#endif  // NMC_ENCODER_CORE_TRIANGLE_MESH_H_
