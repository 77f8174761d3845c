// SPDX-License-Identifier: Apache-2.0
// Figs. 4.1 and 4.5: what the energies do to areas and angles, as pictures and quantiles.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bench/thesis/experiment.h"
#include "bench/thesis/shaded_panel.h"
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
    if (!settings.wants(model.file)) continue;
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
      picture.paste(shaded_panel(sphere, normals, nullptr, normalized(front), {0.1, 0.2, 1}, kSize), left,
                    20);
      picture.paste(shaded_panel(mesh, normals, &x, model.from, model.up, kSize), left, 20 + kSize);
    }
    const std::string stem = std::string(model.file).substr(0, std::string(model.file).find('.'));
    write_png(settings.output + "/fig_4_5_" + stem + ".png", picture);
  }
  table.print();
  table.write_csv(settings.output + "/sphere_distortion.csv");
}

}  // namespace nmc_bench
