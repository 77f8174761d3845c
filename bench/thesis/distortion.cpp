// SPDX-License-Identifier: Apache-2.0
// Fig. 4.1: what the energies do to areas and angles, as pictures and quantiles. Fig. 4.5: whole scans.
#include <fmt/format.h>

#include <algorithm>
#include <array>
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

struct View {
  const char* file;
  Vec3 from, up;
};

constexpr int kSize = 240;

// Orthonormal: towards the eye, upwards, to the side.
std::array<Vec3, 3> frame_of(const Vec3& front, const Vec3& up) {
  const Vec3 x = normalized(front), z = normalized(cross(x, up));
  return {x, cross(z, x), z};
}

// The domain over the surface. The domain is shaded with the surface's normals and turned so that the side seen on the
// surface faces the eye, upright: then the light falls on both alike. The surface shows fields of longitude and
// latitude.
void draw_map(Image& picture, int left, const std::string& title, const TriangleMesh& mesh,
              const std::vector<Vec3>& normals, const std::vector<Vec3>& x, const View& view) {
  Vec3 center, front, top;
  for (const Vec3& p : mesh.positions) center += (1 / static_cast<double>(x.size())) * p;
  for (std::size_t v = 0; v < x.size(); ++v) {
    front += std::max(0.0, dot(normals[v], normalized(view.from))) * x[v];
    top += dot(mesh.positions[v] - center, view.up) * x[v];
  }
  const std::array<Vec3, 3> on_sphere = frame_of(front, top), on_surface = frame_of(view.from, view.up);
  TriangleMesh sphere;
  sphere.triangles = mesh.triangles;
  for (const Vec3& p : x) {
    Vec3 turned;
    for (std::size_t k = 0; k < 3; ++k) turned += dot(p, on_sphere[k]) * on_surface[k];
    sphere.positions.push_back(turned);
  }
  picture.draw_text(left + 8, 6, 1, title, RgbColor{0, 0, 0});
  picture.paste(shaded_panel(sphere, normals, nullptr, view.from, view.up, kSize), left, 20);
  picture.paste(shaded_panel(mesh, normals, &x, view.from, view.up, kSize), left, 20 + kSize);
}

// Fig. 4.5: meshes as they are, with the combined energy.
void draw_whole_scans(const Settings& settings) {
  struct Scan {
    View view;
    double dirichlet, area;
  };
  const std::vector<Scan> scans{{{"igea.ply", {0.2, 0.1, 1}, {0, 1, 0}}, 1, 1},
                                {{"armadillo.obj", {0.3, 0.2, -1}, {0, 1, 0}}, 1, 0},
                                {{"armadillo.obj", {0.3, 0.2, -1}, {0, 1, 0}}, 1, 1},
                                {{"armadillo.obj", {0.3, 0.2, -1}, {0, 1, 0}}, 0.2, 1},
                                {{"horse.ply", {-0.7, -1, 0.2}, {0, 0, 1}}, 0.2, 1}};
  Image picture(kSize * static_cast<int>(scans.size()), 2 * kSize + 20, RgbColor{255, 255, 255});
  Table table({"mesh", "triangles", "(w_D; w_A)", "flips", "solid angle / 4 pi"});
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const Scan& scan = scans[i];
    const TriangleMesh mesh = load_mesh(settings, scan.view.file);
    SphereOptions options;
    options.weights.dirichlet = scan.dirichlet;
    options.weights.area = scan.area;
    options.relative_decrease = 1e-6;
    const SphereParameterization map = parameterize_sphere(mesh, options);
    const std::string name = std::string(scan.view.file).substr(0, std::string(scan.view.file).find('.'));
    const std::string weights = fmt::format("({:g};{:g})", scan.dirichlet, scan.area);
    table.add({name, fmt::format("{}", mesh.triangle_count()), weights,
               fmt::format("{}", map.certificate.flipped_count),
               fmt::format("{:.12f}", map.certificate.solid_angle_over_4pi)});
    draw_map(picture, kSize * static_cast<int>(i), name + " " + weights, mesh, vertex_normals(mesh), map.positions,
             scan.view);
  }
  table.print();
  write_png(settings.output + "/fig_4_5_scans.png", picture);
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
  Table table({"mesh", "energy", "area ratio 1 %", "99 %", "median stretch", "99 % stretch"});
  for (const View& model :
       {View{"igea.ply", {0.2, 0.1, 1}, {0, 1, 0}}, View{"horse.ply", {-0.7, -1, 0.2}, {0, 0, 1}},
        View{"armadillo.obj", {0.3, 0.2, -1}, {0, 1, 0}}}) {
    if (!settings.wants(model.file)) continue;
    const TriangleMesh mesh = simplify_genus0(load_mesh(settings, model.file), 20000);
    const std::vector<Vec3> normals = vertex_normals(mesh);
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
      draw_map(picture, kSize * static_cast<int>(i), energies[i].name, mesh, normals, x, model);
    }
    const std::string stem = std::string(model.file).substr(0, std::string(model.file).find('.'));
    write_png(settings.output + "/fig_4_1_" + stem + ".png", picture);
  }
  table.print();
  table.write_csv(settings.output + "/sphere_distortion.csv");
  if (settings.model.empty()) draw_whole_scans(settings);
}

}  // namespace nmc_bench
