// SPDX-License-Identifier: Apache-2.0
#include "encoder/measure/mpeg_point_metric.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "encoder/core/parallel.h"

namespace nmc {
namespace {

struct PointCloud {
  std::vector<Vec3> points;
  std::vector<Vec3> normals;  // unit length, of the triangle each point lies on
};

// The points where grid lines along `axis` cross the triangle, with the lines counted from `origin`.
void add_crossings(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& unit_normal, int axis,
                   double step, const Vec3& origin, PointCloud& cloud) {
  const int first = (axis + 1) % 3, second = (axis + 2) % 3;
  const double determinant =
      (b[first] - a[first]) * (c[second] - a[second]) - (b[second] - a[second]) * (c[first] - a[first]);
  if (determinant == 0) return;
  const auto line_range = [&](int i) {
    const double low = std::min({a[i], b[i], c[i]}), high = std::max({a[i], b[i], c[i]});
    return std::pair{std::ceil((low - origin[i]) / step), std::floor((high - origin[i]) / step)};
  };
  const auto [first_begin, first_end] = line_range(first);
  const auto [second_begin, second_end] = line_range(second);
  for (double i = first_begin; i <= first_end; ++i) {
    for (double k = second_begin; k <= second_end; ++k) {
      const double x = origin[first] + i * step - a[first];
      const double y = origin[second] + k * step - a[second];
      const double v = (x * (c[second] - a[second]) - y * (c[first] - a[first])) / determinant;
      const double w = (y * (b[first] - a[first]) - x * (b[second] - a[second])) / determinant;
      if (v < 0 || w < 0 || v + w > 1) continue;
      cloud.points.push_back(a + v * (b - a) + w * (c - a));
      cloud.normals.push_back(unit_normal);
    }
  }
}

PointCloud grid_points(const TriangleMesh& mesh, double step, const Vec3& origin) {
  PointCloud cloud;
  for (const Triangle& triangle : mesh.triangles) {
    const Vec3& a = mesh.positions[triangle[0]];
    const Vec3& b = mesh.positions[triangle[1]];
    const Vec3& c = mesh.positions[triangle[2]];
    const Vec3 normal = cross(b - a, c - a);
    int axis = 0;
    for (int i = 1; i < 3; ++i) {
      if (std::abs(normal[i]) > std::abs(normal[axis])) axis = i;
    }
    if (step > 0) add_crossings(a, b, c, normalized(normal), axis, step, origin, cloud);
  }
  if (cloud.points.empty()) {
    cloud.normals = vertex_normals(mesh);
    cloud.points = mesh.positions;
  }
  return cloud;
}

struct SquaredErrors {
  double to_point = 0, to_plane = 0;
  SquaredErrors& operator+=(const SquaredErrors& other) {
    to_point += other.to_point;
    to_plane += other.to_plane;
    return *this;
  }
};

SquaredErrors mean_squared_errors(const PointCloud& source, const PointCloud& target) {
  // A point is a triangle with three equal corners, so the index of triangles finds nearest points too.
  std::vector<Triangle> points_as_triangles(target.points.size());
  for (std::uint32_t i = 0; i < target.points.size(); ++i) points_as_triangles[i] = {i, i, i};
  const SurfaceIndex index(target.points, points_as_triangles);
  SquaredErrors sums = parallel_sum<SquaredErrors>(source.points.size(), [&](std::size_t i) {
    const SurfacePoint nearest = index.closest_point(source.points[i]);
    const Vec3 gap = source.points[i] - target.points[nearest.triangle];
    const double height = dot(gap, target.normals[nearest.triangle]);
    return SquaredErrors{squared_norm(gap), height * height};
  });
  const double count = static_cast<double>(source.points.size());
  return {sums.to_point / count, sums.to_plane / count};
}

}  // namespace

PointCloudPsnr mpeg_point_metric(const TriangleMesh& original, const TriangleMesh& result, int grid) {
  const BoundingBox box = bounding_box(original);
  const Vec3 size = box.maximum - box.minimum;
  const double peak = std::max({size.x, size.y, size.z});
  const double step = peak / std::max(1, grid - 1);
  const PointCloud original_cloud = grid_points(original, step, box.minimum);
  const PointCloud result_cloud = grid_points(result, step, box.minimum);
  const SquaredErrors forward = mean_squared_errors(original_cloud, result_cloud);
  const SquaredErrors backward = mean_squared_errors(result_cloud, original_cloud);
  const auto psnr = [&](double mean_squared) { return 10 * std::log10(3 * peak * peak / mean_squared); };
  return {psnr(std::max(forward.to_point, backward.to_point)),
          psnr(std::max(forward.to_plane, backward.to_plane)), original_cloud.points.size(),
          result_cloud.points.size()};
}

}  // namespace nmc
