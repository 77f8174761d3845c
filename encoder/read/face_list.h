// SPDX-License-Identifier: Apache-2.0
// Collects the faces of a file in file order while its vertices may still be to come.
#ifndef NMC_ENCODER_READ_FACE_LIST_H_
#define NMC_ENCODER_READ_FACE_LIST_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "encoder/core/triangle_mesh.h"

namespace nmc {

/// Triangles go straight into the list. A larger polygon reserves its n - 2 places and is triangulated by
/// finish(), because that needs positions. Corner indices must already be checked against the number of
/// vertices.
class FaceList {
 public:
  void reserve(std::size_t face_count) { triangles_.reserve(face_count); }

  /// A face of any number of corners; one of fewer than three has no area and is only counted.
  void add(std::span<const std::uint32_t> corners) {
    if (corners.size() == 3) {
      triangles_.push_back({corners[0], corners[1], corners[2]});
    } else {
      add_other(corners);
    }
  }

  /// A triangle strip as PLY files have it: -1 starts a new strip, every second triangle is turned, and
  /// triangles with two equal corners only connect strips and are left out.
  void add_strip(std::span<const std::int64_t> indices);

  std::size_t triangle_count() const { return triangles_.size(); }

  /// Triangulates the polygons, moves all triangles to `mesh` and lists what was left out as dropped.
  void finish(TriangleMesh& mesh);

 private:
  struct Polygon {
    std::size_t first_triangle;
    std::size_t first_corner;
    std::uint32_t corner_count;
  };

  void add_other(std::span<const std::uint32_t> corners);

  std::vector<Triangle> triangles_;
  std::vector<Polygon> polygons_;
  std::vector<std::uint32_t> polygon_corners_;
  std::size_t faces_without_area_ = 0;
};

}  // namespace nmc

#endif  // NMC_ENCODER_READ_FACE_LIST_H_
