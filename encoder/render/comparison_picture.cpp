// SPDX-License-Identifier: Apache-2.0
#include "encoder/render/comparison_picture.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "encoder/core/parallel.h"
#include "encoder/render/rasterizer.h"
#include "encoder/spatial/surface_index.h"

namespace nmc {
namespace {

constexpr int kSupersampling = 2;
constexpr RgbColor kPaper = {255, 255, 255};
constexpr RgbColor kInk = {30, 30, 34};
constexpr RgbColor kFaintInk = {110, 110, 118};
constexpr Vec3 kClay = {0.80, 0.74, 0.66};
constexpr int kTextScale = 2;
constexpr int kCaptionHeight = 56;
constexpr int kLegendHeight = 76;

// A corner keeps its smooth normal up to this angle from the triangle's own; sharper ones are shown as edges.
constexpr double kSmoothCosine = 0.80;

Vec3 seen_normal(const TriangleMesh& mesh, const std::vector<Vec3>& normals,
                 const VisibleSurface::Pixel& pixel) {
  const Triangle& corners = mesh.triangles[pixel.triangle];
  const Vec3& a = mesh.positions[corners[0]];
  const Vec3 flat = normalized(cross(mesh.positions[corners[1]] - a, mesh.positions[corners[2]] - a));
  Vec3 sum;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3& smooth = normals[corners[i]];
    sum += static_cast<double>(pixel.barycentric[i]) * (dot(smooth, flat) < kSmoothCosine ? flat : smooth);
  }
  return normalized(sum, flat);
}

// A key light over the left shoulder, a weak fill from the right, and light from the sky, in the camera's
// axes.
double brightness(const Vec3& normal, const Camera& camera) {
  Vec3 n = {dot(normal, camera.right), dot(normal, camera.up), dot(normal, camera.back)};
  if (n.z < 0) n = -n;
  static const Vec3 key = normalized({-0.5, 0.65, 0.75}), fill = normalized({0.8, 0.1, 0.5});
  return 0.22 + 0.12 * (0.5 + 0.5 * n.y) + 0.62 * std::max(0.0, dot(n, key)) +
         0.14 * std::max(0.0, dot(n, fill));
}

RgbColor lit(const Vec3& albedo, double light) {
  RgbColor color;
  for (int i = 0; i < 3; ++i) {
    color[static_cast<std::size_t>(i)] =
        static_cast<std::uint8_t>(std::lround(255 * std::clamp(albedo[i] * light, 0.0, 1.0)));
  }
  return color;
}

/// The surface's own colour at a pixel, 0 ... 1.
Vec3 own_color(const TriangleMesh& mesh, const VisibleSurface::Pixel& pixel) {
  Vec3 sum;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& rgb = mesh.colors[mesh.triangles[pixel.triangle][i]];
    sum += (pixel.barycentric[i] / 255.0) *
           Vec3{static_cast<double>(rgb[0]), static_cast<double>(rgb[1]), static_cast<double>(rgb[2])};
  }
  return sum;
}

Image shaded_panel(const TriangleMesh& mesh, const Camera& camera, int size, bool shows_colors) {
  const VisibleSurface visible = rasterize(mesh, camera, size, size);
  const std::vector<Vec3> normals = vertex_normals(mesh);
  const bool has_colors = shows_colors && !mesh.colors.empty();
  Image image(size, size, kPaper);
  parallel_for(visible.pixels.size(), [&](std::size_t i) {
    const VisibleSurface::Pixel& pixel = visible.pixels[i];
    if (pixel.triangle == VisibleSurface::kNothing) return;
    const double light = brightness(seen_normal(mesh, normals, pixel), camera);
    // Over a surface's own colours the shading is weak, as in the panel of distances.
    image.at(static_cast<int>(i) % size, static_cast<int>(i) / size) =
        has_colors ? lit(own_color(mesh, pixel), 0.6 + 0.42 * light) : lit(kClay, light);
  });
  return reduce(image, kSupersampling);
}

Image error_panel(const TriangleMesh& result, const SurfaceIndex& original, const Camera& camera, int size,
                  double scale_end) {
  const VisibleSurface visible = rasterize(result, camera, size, size);
  const std::vector<Vec3> normals = vertex_normals(result);
  Image image(size, size, kPaper);
  parallel_for(visible.pixels.size(), [&](std::size_t i) {
    const VisibleSurface::Pixel& pixel = visible.pixels[i];
    if (pixel.triangle == VisibleSurface::kNothing) return;
    const Triangle& corners = result.triangles[pixel.triangle];
    Vec3 point;
    for (std::size_t k = 0; k < 3; ++k) {
      point += static_cast<double>(pixel.barycentric[k]) * result.positions[corners[k]];
    }
    const RgbColor color = ramp_color(original.closest_point(point).t / scale_end);
    const Vec3 albedo = {color[0] / 255.0, color[1] / 255.0, color[2] / 255.0};
    // Weak shading only: it shows the shape and leaves the colour readable.
    const double light = 0.72 + 0.33 * brightness(seen_normal(result, normals, pixel), camera);
    image.at(static_cast<int>(i) % size, static_cast<int>(i) / size) = lit(albedo, light);
  });
  return reduce(image, kSupersampling);
}

Vec3 direction_at(double azimuth_degrees, const Vec3& side, const Vec3& front, const Vec3& up) {
  constexpr double kElevation = 15 * std::numbers::pi / 180;
  const double azimuth = azimuth_degrees * std::numbers::pi / 180;
  return std::cos(kElevation) * (std::cos(azimuth) * front + std::sin(azimuth) * side) +
         std::sin(kElevation) * up;
}

// The direction, around the up axis, against which the surface shows the largest area.
Vec3 most_telling_side(const TriangleMesh& mesh, const Vec3& up) {
  const Vec3 unit_up = normalized(up);
  const Vec3 reference = std::abs(unit_up.z) < 0.9 ? Vec3{0, 0, 1} : Vec3{0, -1, 0};
  const Vec3 side = normalized(cross(unit_up, reference));
  const Vec3 front = cross(side, unit_up);
  Vec3 best = front;
  double best_area = -1;
  for (int azimuth = 0; azimuth < 360; azimuth += 30) {
    const Vec3 direction = direction_at(azimuth, side, front, unit_up);
    const double area = parallel_sum<double>(mesh.triangle_count(), [&](std::size_t t) {
      const Vec3& a = mesh.positions[mesh.triangles[t][0]];
      return std::abs(dot(direction, cross(mesh.positions[mesh.triangles[t][1]] - a,
                                           mesh.positions[mesh.triangles[t][2]] - a)));
    });
    if (area > best_area * (1 + 1e-9)) {
      best_area = area;
      best = direction;
    }
  }
  return best;
}

void draw_legend(Image& image, int x, int y, int width, double scale_end, double diagonal) {
  constexpr int kBarHeight = 18;
  constexpr int kOverflowWidth = 26;
  const int ramp_width = width - kOverflowWidth;
  for (int column = 0; column < ramp_width; ++column) {
    image.fill_rectangle(x + column, y, 1, kBarHeight, ramp_color((column + 0.5) / ramp_width));
  }
  image.fill_rectangle(x + ramp_width, y, kOverflowWidth, kBarHeight, ramp_color(2));
  for (int tick = 0; tick <= 4; ++tick) {
    const int column = x + ramp_width * tick / 4;
    image.fill_rectangle(column, y + kBarHeight, 1, 6, kInk);
    const std::string label = fmt::format("{:.3g}", scale_end * tick / 4);
    const int label_width = text_width(label, kTextScale);
    const int left = tick == 0 ? column : column - label_width / 2;
    image.draw_text(left, y + kBarHeight + 10, kTextScale, label, kInk);
  }
  const std::string unit =
      fmt::format("distance in units of the model; the scale ends at {:.2g} % of the diagonal",
                  100 * scale_end / diagonal);
  image.draw_text(x, y + kBarHeight + 34, 1, unit, kFaintInk);
}

}  // namespace

Image comparison_picture(const TriangleMesh& original, const TriangleMesh& result,
                         const CompareResult& compared, const PictureOptions& options) {
  const int size = options.panel_size;
  const double scale_end = options.scale_end > 0 ? options.scale_end : round_scale_end(3 * compared.rms);
  const Vec3 from = options.view_from ? *options.view_from : most_telling_side(original, options.up);
  const int fine_size = size * kSupersampling;
  const Camera camera = camera_around(original, from, options.up, fine_size, fine_size, fine_size / 40);

  Image image(3 * size, kCaptionHeight + size + kLegendHeight, kPaper);
  image.paste(shaded_panel(original, camera, fine_size, options.shows_colors), 0, kCaptionHeight);
  image.paste(shaded_panel(result, camera, fine_size, options.shows_colors), size, kCaptionHeight);
  image.paste(error_panel(result, SurfaceIndex(original), camera, fine_size, scale_end), 2 * size,
              kCaptionHeight);

  const auto caption = [&](int panel, const std::string& title, const std::string& detail) {
    image.draw_text(panel * size + 16, 12, kTextScale, title, kInk);
    image.draw_text(panel * size + 16, 36, 1, detail, kFaintInk);
  };
  caption(0, options.original_title,
          fmt::format("{} vertices, {} triangles", original.vertex_count(), original.triangle_count()));
  caption(1, options.result_title,
          fmt::format("{} vertices, {} triangles", result.vertex_count(), result.triangle_count()));
  caption(2, "distance to the original",
          fmt::format("RMS {:.3g} ({:.2g} % of the diagonal), max {:.3g} ({:.2g} %)", compared.rms,
                      100 * compared.relative_rms(), compared.maximum, 100 * compared.relative_maximum()));
  draw_legend(image, 2 * size + 16, kCaptionHeight + size + 4, size - 32, scale_end, compared.diagonal);
  return image;
}

}  // namespace nmc
