// SPDX-License-Identifier: Apache-2.0
#include "encoder/render/rasterizer.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "encoder/core/parallel.h"

namespace nmc {
namespace {

// Distance of the eye in units of the box's diagonal: about a 35 degree lens for a compact object.
constexpr double kEyeDistance = 1.9;
constexpr int kRowsPerBand = 16;

struct ScreenVertex {
  double x, y, inverse_depth;
};

ScreenVertex project(const Camera& camera, const Vec3& p) {
  const Vec3 relative = p - camera.eye;
  const double inverse_depth = -1 / dot(relative, camera.back);
  return {camera.center_x + camera.focal * dot(relative, camera.right) * inverse_depth,
          camera.center_y - camera.focal * dot(relative, camera.up) * inverse_depth, inverse_depth};
}

void draw_triangle(const ScreenVertex& a, const ScreenVertex& b, const ScreenVertex& c, std::uint32_t index,
                   int row_begin, int row_end, VisibleSurface& surface, std::vector<double>& nearest) {
  const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  if (area == 0) return;
  const int x_begin = std::max(0, static_cast<int>(std::ceil(std::min({a.x, b.x, c.x}) - 0.5)));
  const int x_end =
      std::min(surface.width, static_cast<int>(std::floor(std::max({a.x, b.x, c.x}) - 0.5)) + 1);
  const int y_begin = std::max(row_begin, static_cast<int>(std::ceil(std::min({a.y, b.y, c.y}) - 0.5)));
  const int y_end = std::min(row_end, static_cast<int>(std::floor(std::max({a.y, b.y, c.y}) - 0.5)) + 1);
  for (int row = y_begin; row < y_end; ++row) {
    const double y = row + 0.5;
    for (int column = x_begin; column < x_end; ++column) {
      const double x = column + 0.5;
      const double u = ((b.x - x) * (c.y - y) - (b.y - y) * (c.x - x)) / area;
      const double v = ((c.x - x) * (a.y - y) - (c.y - y) * (a.x - x)) / area;
      const double w = 1 - u - v;
      if (u < 0 || v < 0 || w < 0) continue;
      const double inverse_depth = u * a.inverse_depth + v * b.inverse_depth + w * c.inverse_depth;
      const std::size_t pixel = static_cast<std::size_t>(row) * surface.width + column;
      if (inverse_depth <= nearest[pixel]) continue;
      nearest[pixel] = inverse_depth;
      surface.pixels[pixel] = {index,
                               {static_cast<float>(u * a.inverse_depth / inverse_depth),
                                static_cast<float>(v * b.inverse_depth / inverse_depth),
                                static_cast<float>(w * c.inverse_depth / inverse_depth)}};
    }
  }
}

}  // namespace

Camera camera_around(const TriangleMesh& mesh, const Vec3& from, const Vec3& up, int width, int height,
                     int margin) {
  const BoundingBox box = bounding_box(mesh);
  Camera camera;
  camera.back = normalized(from);
  camera.right = normalized(cross(up, camera.back), {1, 0, 0});
  camera.up = cross(camera.back, camera.right);
  const double diagonal = box.diagonal() > 0 ? box.diagonal() : 1;
  camera.eye = box.center() + kEyeDistance * diagonal * camera.back;

  double low_x = std::numeric_limits<double>::infinity(), high_x = -low_x, low_y = low_x, high_y = -low_x;
  for (const Triangle& triangle : mesh.triangles) {
    for (const std::uint32_t corner : triangle) {
      const ScreenVertex seen = project(camera, mesh.positions[corner]);
      low_x = std::min(low_x, seen.x);
      high_x = std::max(high_x, seen.x);
      low_y = std::min(low_y, seen.y);
      high_y = std::max(high_y, seen.y);
    }
  }
  const double focal =
      std::min((width - 2 * margin) / (high_x - low_x), (height - 2 * margin) / (high_y - low_y));
  camera.focal = std::isfinite(focal) && focal > 0 ? focal : 1;
  camera.center_x = 0.5 * width - 0.5 * camera.focal * (low_x + high_x);
  camera.center_y = 0.5 * height - 0.5 * camera.focal * (low_y + high_y);
  return camera;
}

VisibleSurface rasterize(const TriangleMesh& mesh, const Camera& camera, int width, int height) {
  VisibleSurface surface;
  surface.width = width;
  surface.height = height;
  surface.pixels.resize(static_cast<std::size_t>(width) * height);
  std::vector<double> nearest(surface.pixels.size(), 0.0);
  std::vector<ScreenVertex> screen(mesh.vertex_count());
  parallel_for(mesh.vertex_count(), [&](std::size_t v) { screen[v] = project(camera, mesh.positions[v]); });

  // Bands of rows are independent and each visits the triangles in index order.
  const int bands = (height + kRowsPerBand - 1) / kRowsPerBand;
  std::vector<std::vector<std::uint32_t>> triangles_of_band(static_cast<std::size_t>(bands));
  for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
    const Triangle& corners = mesh.triangles[t];
    const auto [low, high] = std::minmax({screen[corners[0]].y, screen[corners[1]].y, screen[corners[2]].y});
    if (!(high >= 0 && low < height)) continue;
    const int last = std::min(bands - 1, static_cast<int>(high) / kRowsPerBand);
    for (int band = std::max(0, static_cast<int>(low) / kRowsPerBand); band <= last; ++band) {
      triangles_of_band[static_cast<std::size_t>(band)].push_back(t);
    }
  }
  oneapi::tbb::parallel_for(0, bands, [&](int band) {
    for (const std::uint32_t t : triangles_of_band[static_cast<std::size_t>(band)]) {
      const Triangle& corners = mesh.triangles[t];
      draw_triangle(screen[corners[0]], screen[corners[1]], screen[corners[2]], t, band * kRowsPerBand,
                    std::min(height, (band + 1) * kRowsPerBand), surface, nearest);
    }
  });
  return surface;
}

}  // namespace nmc
