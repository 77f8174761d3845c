// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "encoder/core/error.h"
#include "encoder/render/comparison_picture.h"
#include "encoder/render/rasterizer.h"
#include "encoder/spatial/surface_index.h"
#include "tests/unit/spatial/test_meshes.h"

namespace nmc {
namespace {

TEST_CASE("the rasterizer sees at each pixel what a ray through it hits first") {
  const TriangleMesh mesh = test::triangle_soup(12, 200, 0.3);
  const Camera camera = camera_around(mesh, {0.4, 0.3, 1}, {0, 1, 0}, 160, 120, 4);
  const VisibleSurface visible = rasterize(mesh, camera, 160, 120);
  const SurfaceIndex index(mesh);
  int covered = 0, different = 0;
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      const Vec3 direction = ((x + 0.5 - camera.center_x) / camera.focal) * camera.right +
                             ((camera.center_y - y - 0.5) / camera.focal) * camera.up - camera.back;
      const SurfacePoint hit = index.first_hit(camera.eye, direction, 0, 1e9);
      const VisibleSurface::Pixel& pixel = visible.pixels[static_cast<std::size_t>(y * 160 + x)];
      if (pixel.triangle != hit.triangle) {
        ++different;
        continue;
      }
      if (!hit.found()) continue;
      ++covered;
      for (int i = 0; i < 3; ++i) {
        REQUIRE(static_cast<double>(pixel.barycentric[i]) == Approx(hit.barycentric[i]).margin(1e-5));
      }
    }
  }
  CHECK(covered > 2000);
  CHECK(different == 0);
}

TEST_CASE("the camera shows the whole mesh within the margin") {
  const TriangleMesh mesh = test::triangle_soup(2, 60, 0.2, {1e6, 2e6, -1e6});
  const Camera camera = camera_around(mesh, {1, 0.2, 0.4}, {0, 0, 1}, 200, 200, 10);
  const VisibleSurface visible = rasterize(mesh, camera, 200, 200);
  int low = 200, high = 0;
  for (int y = 0; y < 200; ++y) {
    for (int x = 0; x < 200; ++x) {
      if (visible.pixels[static_cast<std::size_t>(y * 200 + x)].triangle == VisibleSurface::kNothing)
        continue;
      for (const int coordinate : {x, y}) {
        low = std::min(low, coordinate);
        high = std::max(high, coordinate);
      }
    }
  }
  CHECK(low >= 9);
  CHECK(low <= 12);
  CHECK(high <= 190);
  CHECK(high >= 187);
}

TEST_CASE("the comparison picture is written as PNG and colours a known error") {
  const TriangleMesh low = test::sheet(6, [](double, double) { return 0.0; });
  const TriangleMesh high = test::sheet(6, [](double, double) { return 0.5; });
  PictureOptions options;
  options.panel_size = 120;
  options.view_from = Vec3{0, 0, 1};
  options.scale_end = 1;
  const Image image = comparison_picture(low, high, compare_meshes(low, high), options);
  CHECK(image.width() == 360);
  const RgbColor middle = image.at(300, 56 + 60), expected = ramp_color(0.5);
  CAPTURE(int(middle[0]), int(middle[1]), int(middle[2]));
  for (std::size_t i = 0; i < 3; ++i) CHECK(std::abs(int(middle[i]) - int(expected[i])) < 40);

  const std::string path = (std::filesystem::temp_directory_path() / "nmc_render_test.png").string();
  write_png(path, image);
  char signature[4] = {};
  std::ifstream(path, std::ios::binary).read(signature, 4);
  CHECK(std::string(signature + 1, 3) == "PNG");
  std::remove(path.c_str());
  CHECK_THROWS_AS(write_png("/nowhere/at/all.png", image), Error);
}

TEST_CASE("a legend ends at a round number not below the value") {
  CHECK(round_scale_end(0.00121) == Approx(0.0016));
  CHECK(round_scale_end(1) == Approx(1));
  CHECK(round_scale_end(83) == Approx(100));
  CHECK(round_scale_end(0) == 1);
}

TEST_CASE("the colour ramp grows brighter with the error and marks what is beyond its end") {
  double last = -1;
  for (double value = 0; value <= 1; value += 0.05) {
    const RgbColor color = ramp_color(value);
    const double luma = 0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2];
    CHECK(luma > last);
    last = luma;
  }
  CHECK(ramp_color(1.01)[0] > 2 * ramp_color(1.01)[1]);
}

}  // namespace
}  // namespace nmc
