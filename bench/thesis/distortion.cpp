// SPDX-License-Identifier: Apache-2.0
// Figs. 4.1 and 4.5: what the energies do to areas and angles, as pictures and quantiles.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bench/thesis/experiment.h"
#include "encoder/render/image.h"
#include "encoder/render/rasterizer.h"
#include "encoder/sphere/sphere_parameterization.h"

namespace nmc_bench {

using namespace nmc;

namespace {

// Ratios of areas on the sphere over areas on the surface, and the ratio of the singular values of the map
// from the surface's triangle to the sphere's: 1 is conformal.
struct Distortion {
  double area_q01 = 0, area_q99 = 0, median_stretch = 0, stretch_q99 = 0;
};

Distortion measure(const TriangleMesh& mesh, const std::vector<Vec3>& x) {
  const double scale = 4 * std::numbers::pi / surface_area(mesh);
  std::vector<double> areas, stretches;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 p1 = mesh.positions[t[1]] - mesh.positions[t[0]],
               p2 = mesh.positions[t[2]] - mesh.positions[t[0]];
    const Vec3 q1 = x[t[1]] - x[t[0]], q2 = x[t[2]] - x[t[0]];
    const double area = norm(cross(p1, p2)) * scale, image = norm(cross(q1, q2));
    if (!(area > 0)) continue;
    areas.push_back(image / area);
    // Singular values from the invariants: s1 s2 = image / area, s1^2 + s2^2 = trace of the metric.
    const double a = dot(p1, p1), b = dot(p1, p2), c = dot(p2, p2), det = a * c - b * b;
    const double trace = (c * dot(q1, q1) - 2 * b * dot(q1, q2) + a * dot(q2, q2)) / det;
    const double product = image / norm(cross(p1, p2));
    const double ratio = trace / (2 * product);
    stretches.push_back(ratio + std::sqrt(std::max(0.0, ratio * ratio - 1)));
  }
  const auto quantile = [](std::vector<double>& values, double q) {
    const std::size_t k = static_cast<std::size_t>(q * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(k), values.end());
    return values[k];
  };
  return {quantile(areas, 0.01), quantile(areas, 0.99), quantile(stretches, 0.5), quantile(stretches, 0.99)};
}

constexpr int kOversampling = 2;

// One panel: `shown` seen from `from`; the color of a point comes from the surface normal (shade) and, with a
// checker, from its longitude and latitude on the sphere.
Image panel(const TriangleMesh& shown, const std::vector<Vec3>& normals, const std::vector<Vec3>* checker,
            const Vec3& from, const Vec3& up, int size) {
  const int pixels = size * kOversampling;
  const Camera camera = camera_around(shown, from, up, pixels, pixels, 8 * kOversampling);
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

}  // namespace

void run_distortion(const Settings& settings) {
  struct Energy {
    const char* name;
    SphereEnergyWeights weights;
  };
  const std::vector<Energy> energies{{"Tutte", {1, 0, 0, 0, 0, true}},
                                     {"(1;0)", {0, 1, 0, 0, 0, true}},
                                     {"(1;1)", {0, 1, 1, 0, 0, true}},
                                     {"(0.2;1)", {0, 0.2, 1, 0, 0, true}},
                                     {"(0;1)", {0, 0, 1, 0, 0, true}}};
  struct Model {
    const char* file;
    Vec3 from, up;
  };
  Table table({"mesh", "energy", "area ratio 1 %", "99 %", "median stretch", "99 % stretch"});
  for (const Model& model :
       {Model{"igea.ply", {0.2, 0.1, 1}, {0, 1, 0}}, Model{"horse.ply", {-0.7, -1, 0.2}, {0, 0, 1}},
        Model{"armadillo.obj", {0.3, 0.2, -1}, {0, 1, 0}}}) {
    const TriangleMesh mesh = simplify_genus0(load_mesh(settings, model.file), 20000);
    const std::vector<Vec3> normals = vertex_normals(mesh);
    constexpr int kSize = 240;
    Image picture(kSize * static_cast<int>(energies.size()), 2 * kSize + 20, RgbColor{255, 255, 255});
    for (std::size_t i = 0; i < energies.size(); ++i) {
      SphereOptions options;
      options.weights = energies[i].weights;
      options.relative_decrease = 1e-6;
      const std::vector<Vec3> x = parameterize_sphere(mesh, options).positions;
      const Distortion d = measure(mesh, x);
      table.add({model.file, energies[i].name, fmt::format("{:.3g}", d.area_q01),
                 fmt::format("{:.3g}", d.area_q99), fmt::format("{:.3f}", d.median_stretch),
                 fmt::format("{:.3f}", d.stretch_q99)});
      TriangleMesh sphere;
      sphere.positions = x;
      sphere.triangles = mesh.triangles;
      const int left = kSize * static_cast<int>(i);
      // The sphere is turned so that the side seen on the surface faces the eye.
      Vec3 front;
      for (std::size_t v = 0; v < x.size(); ++v)
        front += std::max(0.0, dot(normals[v], normalized(model.from))) * x[v];
      picture.draw_text(left + 8, 6, 1, energies[i].name, RgbColor{0, 0, 0});
      picture.paste(panel(sphere, normals, nullptr, normalized(front), {0.1, 0.2, 1}, kSize), left, 20);
      picture.paste(panel(mesh, normals, &x, model.from, model.up, kSize), left, 20 + kSize);
    }
    const std::string stem = std::string(model.file).substr(0, std::string(model.file).find('.'));
    write_png(settings.output + "/fig_4_5_" + stem + ".png", picture);
  }
  table.print();
  table.write_csv(settings.output + "/sphere_distortion.csv");
}

}  // namespace nmc_bench
