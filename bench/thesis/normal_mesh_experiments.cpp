// SPDX-License-Identifier: Apache-2.0
// Chapter 3 on surfaces: Table 3.1, the zone sphere of Fig. 3.7, and Figs. 3.8 and 3.10 (error and volume per
// level).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

#include "bench/thesis/experiment.h"
#include "bench/thesis/normal_mesh_model.h"
#include "bench/thesis/svg_plot.h"
#include "encoder/normal_mesh/unconstrained_vector_mesh.h"
#include "encoder/normal_mesh/variational_normal_mesh.h"

namespace nmc_bench {

using namespace nmc;

namespace {

struct Published {
  double inm_error, vnm_error, inm_seconds, vnm_seconds;
  int inm_non_normal, vnm_non_normal;
};

/// The thesis's kind of input: a hierarchy of meshes R^0 ... R^5, recognized from the finest one's triangles.
Model remeshed_horse(const Settings& settings) {
  constexpr int kBaseSize = 140, kLevels = 4;
  const Model horse = on_domain("horse", load_mesh(settings, "horse.ply"), kBaseSize, kLevels);
  return on_own_base("horse remeshed", plain_remesh(horse, kLevels + 1));
}

}  // namespace

void run_table_3_1(const Settings& settings) {
  Table table({"model", "parameterization", "base (levels)", "vertices", "aperture", "method",
               "thesis non-normal", "non-normal", "thesis L2 %", "L2 %", "INM / VNM", "thesis s", "cpu s"});
  SphereBaseOptions icosahedron;
  SphereBaseOptions adaptive;
  adaptive.kind = SphereBaseKind::kAdaptive;
  adaptive.adaptive_vertex_count = 140;
  const SphereEnergyWeights even{0, 0.2, 1, 0, 0, true};
  struct Row {
    std::string name;
    std::function<Model()> make;
    std::optional<Published> published;
  };
  const auto igea = [&] { return load_mesh(settings, "igea.ply"); };
  const auto horse = [&] { return load_mesh(settings, "horse.ply"); };
  std::vector<Row> rows{
      {"igea domain", [&] { return on_domain("igea", igea(), 196, 4); },
       Published{0.0148, 0.0096, 2.3, 14.9, 136, 121}},
      {"igea sphere", [&] { return on_sphere("igea", igea(), icosahedron, 6); },
       Published{0.0156, 0.0099, 2.1, 15.1, 24, 38}},
      {"horse domain", [&] { return on_domain("horse", horse(), 140, 4); },
       Published{0.0117, 0.0081, 1.6, 11.7, 256, 317}},
      {"horse sphere", [&] { return on_sphere("horse", horse(), adaptive, 4, even); },
       Published{0.0117, 0.0081, 1.6, 11.7, 256, 317}},
      {"fandisk domain", [&] { return on_domain("fandisk", load_mesh(settings, "fandisk.obj"), 73, 3); },
       Published{0.0573, 0.0345, 0.2, 1.5, 103, 104}},
      {"zone sphere sphere", [&] { return on_sphere("zone sphere", zone_sphere(7), icosahedron, 6); },
       Published{0.0611, 0.0327, 2.8, 17.2, 570, 146}},
      {"bimba sphere", [&] { return on_sphere("bimba", load_mesh(settings, "bimba.off"), icosahedron, 5); },
       std::nullopt},
      {"m1phobos sphere",
       [&] { return on_sphere("m1phobos", load_mesh(settings, "m1phobos.obj"), icosahedron, 5); },
       std::nullopt},
      {"horse remesh", [&] { return remeshed_horse(settings); },
       Published{0.0117, 0.0081, 1.6, 11.7, 256, 317}}};
  if (!settings.semi_regular.empty()) {
    rows.push_back({settings.semi_regular,
                    [&] { return on_own_base(settings.semi_regular, load_mesh(settings.semi_regular)); },
                    std::nullopt});
  }
  for (const Row& row : rows) {
    if (!settings.wants(row.name)) continue;
    const Model model = row.make();
    const SurfaceIndex index(model.surface->surface());
    const SurfaceIndex input_index(*model.input);
    for (const ApertureRule rule : {ApertureRule::kParametric, ApertureRule::kAdaptive}) {
      const InterpolatingOptions options = thesis_options(model.level_count, rule);
      const auto count = [](const std::vector<LevelStatistics>& levels) {
        std::uint32_t sum = 0;
        for (const LevelStatistics& l : levels) sum += l.non_normal_count;
        return sum;
      };
      const auto add = [&](const char* method, std::uint32_t non_normal, double error, double ratio,
                           double seconds, std::size_t vertices, double published_error,
                           double published_seconds, int published_count) {
        const auto shown = [&](auto value) {
          return row.published ? fmt::format("{}", value) : std::string("-");
        };
        table.add({model.name, model.parameterization,
                   fmt::format("{} ({})", model.base.positions.size(), model.level_count),
                   fmt::format("{}", vertices), rule == ApertureRule::kParametric ? "0.2" : "adaptive",
                   method, shown(published_count), fmt::format("{}", non_normal), shown(published_error),
                   fmt::format("{:.4f}", 100 * error), ratio > 0 ? fmt::format("{:.2f}", ratio) : "",
                   shown(published_seconds), fmt::format("{:.1f}", seconds)});
      };
      const Published p = row.published.value_or(Published{});
      const Stopwatch inm_clock;
      const InterpolatingResult inm = interpolate(*model.surface, index, model.base, options);
      const double inm_seconds = inm_clock.cpu_seconds();
      const double inm_error =
          compared(model, input_index, mesh_of(inm.mesh.hierarchy, model.level_count, inm.positions))
              .relative_rms();
      add("INM", count(inm.levels), inm_error, 0, inm_seconds, inm.positions.size(), p.inm_error,
          p.inm_seconds, p.inm_non_normal);
      const VariationalOptions variational = thesis_options(options);
      const Stopwatch vnm_clock;
      const VariationalResult vnm = variational_normal_mesh(*model.surface, index, model.base, variational);
      const double vnm_seconds = vnm_clock.cpu_seconds();
      const double vnm_error =
          compared(model, input_index, mesh_of(vnm.hierarchy, model.level_count, vnm.positions.back()))
              .relative_rms();
      add("VNM", count(vnm.levels), vnm_error, inm_error / vnm_error, vnm_seconds, inm.positions.size(),
          p.vnm_error, p.vnm_seconds, p.vnm_non_normal);
    }
  }
  table.print();
  table.write_csv(settings.output + "/table_3_1.csv");
}

void run_levels(const Settings& settings) {
  SphereBaseOptions icosahedron, tetrahedron;
  tetrahedron.kind = SphereBaseKind::kTetrahedron;
  struct Row {
    std::string figure;
    std::function<Model()> make;
  };
  std::vector<Row> rows{
      {"igea", [&] { return on_sphere("igea", load_mesh(settings, "igea.ply"), icosahedron, 5); }},
      {"zone_sphere", [&] { return on_sphere("zone sphere", zone_sphere(7), icosahedron, 6); }},
      {"bimba_tetrahedron",
       [&] {
         return on_sphere("bimba over a tetrahedron", load_mesh(settings, "bimba.off"), tetrahedron, 6);
       }},
      {"horse_remesh", [&] { return remeshed_horse(settings); }}};
  if (!settings.semi_regular.empty()) {
    rows.push_back({"semi_regular",
                    [&] { return on_own_base(settings.semi_regular, load_mesh(settings.semi_regular)); }});
  }
  Table table({"model", "level", "vertices", "INM %", "VNM %", "VVM %", "remesh %", "fit %", "volume INM %",
               "volume VNM %", "volume VVM %", "volume remesh %", "volume fit %"});
  for (const Row& row : rows) {
    if (!settings.wants(row.figure)) continue;
    const Model model = row.make();
    const SurfaceIndex index(model.surface->surface());
    const SurfaceIndex input_index(*model.input);
    InterpolatingOptions options = thesis_options(model.level_count, ApertureRule::kParametric);
    const InterpolatingResult inm = interpolate(*model.surface, index, model.base, options);
    const VariationalOptions variational = thesis_options(options);
    const VariationalResult vnm = variational_normal_mesh(*model.surface, index, model.base, variational);
    const SubdivisionHierarchy& hierarchy = inm.mesh.hierarchy;
    const std::vector<std::vector<Vec3>> vvm =
        unconstrained_vector_mesh(*model.surface, hierarchy, inm.parameters);
    const std::vector<Vec3> remesh =
        sample_surface(*model.surface, midpoint_parameters(*model.surface, hierarchy, model.base.parameters));
    Plot error{"Fig. 3.8: " + model.name, "vertices", "L2 error, % of the diagonal", true, true, {}};
    Plot volume{"Fig. 3.10: " + model.name, "level", "volume, % of the input's", false, false, {}};
    for (const char* name : {"INM", "VNM", "VVM", "plain remesh", "fit"}) {
      error.series.push_back({name, {}});
      volume.series.push_back({name, {}});
    }
    for (int l = 0; l <= model.level_count; ++l) {
      const std::size_t s = static_cast<std::size_t>(l);
      // The fit minimizes the error of its finest level, so each level has a fit of its own.
      const TriangleMesh meshes[5] = {mesh_of(hierarchy, l, inm.positions),
                                      mesh_of(hierarchy, l, vnm.positions[s]), mesh_of(hierarchy, l, vvm[s]),
                                      mesh_of(hierarchy, l, remesh), fitted(model, index, options, l)};
      std::vector<std::string> cells{model.name, fmt::format("{}", l),
                                     fmt::format("{}", meshes[0].vertex_count())};
      std::vector<std::string> volumes;
      for (std::size_t k = 0; k < 5; ++k) {
        const CompareResult c = compared(model, input_index, meshes[k]);
        const double percent = 100 * c.relative_rms();
        const double share =
            c.original_volume && c.result_volume ? 100 * *c.result_volume / *c.original_volume : 0;
        cells.push_back(fmt::format("{:.4f}", percent));
        volumes.push_back(fmt::format("{:.2f}", share));
        error.series[k].points.emplace_back(static_cast<double>(meshes[k].vertex_count()), percent);
        volume.series[k].points.emplace_back(l, share);
      }
      cells.insert(cells.end(), volumes.begin(), volumes.end());
      table.add(std::move(cells));
    }
    write_plots(settings.output + "/fig_3_8_3_10_" + row.figure + ".svg", {error, volume});
  }
  table.print();
  table.write_csv(settings.output + "/levels.csv");
}

void run_zone_sphere(const Settings& settings) {
  const Model model = on_sphere("zone sphere", zone_sphere(7), {}, 5);
  const SurfaceIndex index(model.surface->surface());
  const InterpolatingOptions options = thesis_options(model.level_count, ApertureRule::kParametric);
  const InterpolatingResult inm = interpolate(*model.surface, index, model.base, options);
  const VariationalOptions variational = thesis_options(options);
  const VariationalResult vnm = variational_normal_mesh(*model.surface, index, model.base, variational);
  // The radius along the equator, where the local frequency grows from 0 to 16 pi waves per turn: the share
  // of the displacement's energy in windows of longitude. What a level cannot resolve should be zero, not
  // noise.
  constexpr int kWindows = 32, kSamples = 8192;
  const auto profile = [&](const TriangleMesh& mesh) {
    const SurfaceIndex mesh_index(mesh);
    std::vector<double> deviation(kWindows, 0);
    for (int i = 0; i < kSamples; ++i) {
      const double longitude = 2 * std::numbers::pi * (i + 0.5) / kSamples - std::numbers::pi;
      const SurfacePoint hit =
          mesh_index.first_hit({0, 0, 0}, {std::cos(longitude), std::sin(longitude), 0.05}, 0.1, 3);
      if (!hit.found()) continue;
      const double d = norm(hit.position) - 1;
      deviation[static_cast<std::size_t>(i * kWindows / kSamples)] += d * d * kWindows / kSamples;
    }
    for (double& d : deviation) d = std::sqrt(d);
    return deviation;
  };
  std::vector<Plot> plots;
  Table table({"level", "vertices", "waves per turn resolved", "INM beyond them", "VNM beyond them",
               "fit beyond them", "INM / VNM"});
  const std::vector<double> reference = profile(*model.input);
  for (int l = 1; l <= 4; ++l) {
    const std::vector<double> a = profile(mesh_of(inm.mesh.hierarchy, l, inm.positions));
    const std::vector<double> b =
        profile(mesh_of(vnm.hierarchy, l, vnm.positions[static_cast<std::size_t>(l)]));
    const std::vector<double> c = profile(fitted(model, index, options, l));
    Plot plot{
        fmt::format("Fig. 3.7, level {}", l), "waves per turn", "RMS of the radius - 1", false, false, {}};
    plot.series = {{"input", {}}, {"INM", {}}, {"VNM", {}}, {"fit", {}}};
    // An icosahedron's equator has about 5 edges of a turn each, doubled on every level; two of them make a
    // wave.
    const double resolved = 5 * std::pow(2, l) / 2;
    double inm_energy = 0, vnm_energy = 0, fit_energy = 0;
    for (std::size_t w = 0; w < kWindows; ++w) {
      const double frequency = 2 * 4 * 2 * std::numbers::pi * (static_cast<double>(w) + 0.5) / kWindows;
      plot.series[0].points.emplace_back(frequency, reference[w]);
      plot.series[1].points.emplace_back(frequency, a[w]);
      plot.series[2].points.emplace_back(frequency, b[w]);
      plot.series[3].points.emplace_back(frequency, c[w]);
      if (frequency > resolved) {
        inm_energy += a[w] * a[w];
        vnm_energy += b[w] * b[w];
        fit_energy += c[w] * c[w];
      }
    }
    plots.push_back(std::move(plot));
    table.add({fmt::format("{}", l), fmt::format("{}", inm.mesh.hierarchy.level(l).vertex_count),
               fmt::format("{:.0f}", resolved), fmt::format("{:.5f}", std::sqrt(inm_energy / kWindows)),
               fmt::format("{:.5f}", std::sqrt(vnm_energy / kWindows)),
               fmt::format("{:.5f}", std::sqrt(fit_energy / kWindows)),
               fmt::format("{:.2f}", std::sqrt(inm_energy / vnm_energy))});
  }
  table.print();
  table.write_csv(settings.output + "/zone_sphere.csv");
  write_plots(settings.output + "/fig_3_7_zone_sphere.svg", plots);
}

}  // namespace nmc_bench
