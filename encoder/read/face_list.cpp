// SPDX-License-Identifier: Apache-2.0
#include "encoder/read/face_list.h"

#include <fmt/format.h>

#include <utility>

#include "encoder/read/polygon_triangulation.h"

namespace nmc {

void FaceList::add_other(std::span<const std::uint32_t> corners) {
  if (corners.size() < 3) {
    ++faces_without_area_;
    return;
  }
  polygons_.push_back(
      {triangles_.size(), polygon_corners_.size(), static_cast<std::uint32_t>(corners.size())});
  polygon_corners_.insert(polygon_corners_.end(), corners.begin(), corners.end());
  triangles_.resize(triangles_.size() + corners.size() - 2);
}

void FaceList::add_strip(std::span<const std::int64_t> indices) {
  std::size_t start = 0;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    if (indices[i] < 0) {
      start = i + 1;
      continue;
    }
    if (i < start + 2) continue;
    const auto a = static_cast<std::uint32_t>(indices[i - 2]), b = static_cast<std::uint32_t>(indices[i - 1]),
               c = static_cast<std::uint32_t>(indices[i]);
    if (a == b || b == c || c == a) continue;
    if ((i - start) % 2 == 0) {
      triangles_.push_back({a, b, c});
    } else {
      triangles_.push_back({b, a, c});
    }
  }
}

void FaceList::finish(TriangleMesh& mesh) {
  std::vector<Vec3> positions;
  std::vector<std::array<std::uint32_t, 3>> local;
  for (const Polygon& polygon : polygons_) {
    const std::span<const std::uint32_t> corners(&polygon_corners_[polygon.first_corner],
                                                 polygon.corner_count);
    positions.clear();
    local.clear();
    for (const std::uint32_t corner : corners) positions.push_back(mesh.positions[corner]);
    triangulate_polygon(positions, local);
    for (std::size_t i = 0; i < local.size(); ++i)
      triangles_[polygon.first_triangle + i] = {corners[local[i][0]], corners[local[i][1]],
                                                corners[local[i][2]]};
  }
  if (faces_without_area_ > 0)
    mesh.dropped_properties.push_back(
        fmt::format("{} faces of fewer than three corners (they have no area)", faces_without_area_));
  mesh.triangles = std::move(triangles_);
  *this = FaceList();
}

}  // namespace nmc
