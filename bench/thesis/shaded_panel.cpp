// SPDX-License-Identifier: Apache-2.0
#include "bench/thesis/shaded_panel.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "encoder/render/rasterizer.h"

namespace nmc_bench {

using namespace nmc;

Image shaded_panel(const TriangleMesh& shown, const std::vector<Vec3>& normals,
                   const std::vector<Vec3>* checker, const Vec3& from, const Vec3& up, int size,
                   const TriangleMesh* frame) {
  constexpr int kOversampling = 2;
  const int pixels = size * kOversampling;
  const Camera camera = camera_around(frame ? *frame : shown, from, up, pixels, pixels, 8 * kOversampling);
  const VisibleSurface visible = rasterize(shown, camera, pixels, pixels);
  Image image(pixels, pixels, RgbColor{255, 255, 255});
  const Vec3 light = normalized(camera.back + 0.5 * camera.up - 0.3 * camera.right);
  for (int y = 0; y < pixels; ++y) {
    for (int x = 0; x < pixels; ++x) {
      const auto& pixel = visible.pixels[static_cast<std::size_t>(y) * pixels + x];
      if (pixel.triangle == VisibleSurface::kNothing) continue;
      const Triangle& t = shown.triangles[pixel.triangle];
      Vec3 normal, place;
      for (int k = 0; k < 3; ++k) {
        normal += pixel.barycentric[k] * normals[t[k]];
        if (checker) place += pixel.barycentric[k] * (*checker)[t[k]];
      }
      normal = normalized(normal);
      double shade = 0.25 + 0.75 * std::max(0.0, dot(normal, light));
      Vec3 color{230, 225, 215};
      if (checker) {
        place = normalized(place);
        const double longitude = std::atan2(place.y, place.x) / std::numbers::pi * 18;
        const double latitude = std::asin(std::clamp(place.z, -1.0, 1.0)) / std::numbers::pi * 18;
        const bool dark =
            (static_cast<int>(std::floor(longitude)) + static_cast<int>(std::floor(latitude))) % 2 != 0;
        if (dark) color = {90, 120, 170};
      }
      const auto channel = [&](double v) {
        return static_cast<std::uint8_t>(std::clamp(v * shade, 0.0, 255.0));
      };
      image.at(x, y) = RgbColor{channel(color.x), channel(color.y), channel(color.z)};
    }
  }
  return reduce(image, kOversampling);
}

}  // namespace nmc_bench
