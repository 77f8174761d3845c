// SPDX-License-Identifier: Apache-2.0
// Chapter 4: the timings of section 4.4, fold-free maps of the whole corpus, and the collapse of Fig. 4.4.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bench/thesis/experiment.h"
#include "bench/thesis/svg_plot.h"
#include "encoder/sphere/initialization.h"
#include "encoder/sphere/sphere_parameterization.h"
#include "encoder/sphere/trust_region_newton.h"

namespace nmc_bench {

using namespace nmc;

namespace {

std::vector<std::string> timing_row(const std::string& mesh, std::size_t triangles,
                                    const SphereOptions& options, const SphereParameterization& result,
                                    const Stopwatch& clock, const std::string& published) {
  const SphereStatistics& s = result.statistics;
  return {mesh,
          fmt::format("{}", triangles),
          fmt::format("({:g}; {:g})", options.weights.dirichlet, options.weights.area),
          published,
          fmt::format("{:.1f}", clock.wall_seconds()),
          fmt::format("{:.1f}", clock.cpu_seconds()),
          fmt::format("{}", s.finest.iterations),
          fmt::format("{}", s.factorizations),
          fmt::format("{:.1e}", s.finest.gradient_norm),
          fmt::format("{:.6f}", s.finest.energy),
          fmt::format("{}", result.certificate.flipped_count),
          fmt::format("{:.12f}", result.certificate.solid_angle_over_4pi)};
}

const std::vector<std::string> kTimingColumns{"mesh",     "triangles", "(w_D; w_A)",   "thesis s",
                                              "wall s",   "cpu s",     "finest steps", "factorizations",
                                              "gradient", "energy",    "flips",        "solid angle / 4 pi"};

}  // namespace

void run_sphere_times(const Settings& settings) {
  const TriangleMesh igea = load_mesh(settings, "igea.ply");
  const TriangleMesh simplified = simplify_genus0(igea, 33500);
  struct Row {
    double dirichlet, area;
    const char* published;
  };
  Table table(kTimingColumns);
  for (const Row& row :
       {Row{1, 0, "2040"}, Row{1, 0.1, "300"}, Row{1, 1, "240"}, Row{0.1, 1, "720"}, Row{0, 1, "21960"}}) {
    SphereOptions options;
    options.weights.dirichlet = row.dirichlet;
    options.weights.area = row.area;
    const Stopwatch clock;
    const SphereParameterization result = parameterize_sphere(simplified, options);
    table.add(
        timing_row("igea simplified", simplified.triangle_count(), options, result, clock, row.published));
  }
  {
    const SphereOptions options;
    const Stopwatch clock;
    const SphereParameterization result = parameterize_sphere(igea, options);
    table.add(timing_row("igea", igea.triangle_count(), options, result, clock, "-"));
  }
  table.print();
  table.write_csv(settings.output + "/sphere_times.csv");
}

void run_fold_free(const Settings& settings) {
  Table table(kTimingColumns);
  Table starts({"mesh", "vertices", "start", "folds at the start", "steps until fold-free", "steps in all",
                "gradient", "folds at the end"});
  for (const std::string& file : genus0_files()) {
    if (!settings.wants(file)) continue;
    const TriangleMesh mesh = load_mesh(settings, file);
    for (const double dirichlet : {1.0, 0.2}) {
      SphereOptions options;
      options.weights.dirichlet = dirichlet;
      options.require_bijection = false;
      const Stopwatch clock;
      const SphereParameterization result = parameterize_sphere(mesh, options);
      table.add(timing_row(file, mesh.triangle_count(), options, result, clock, "-"));
    }
    // The thesis's own starts, on a mesh small enough for a solver without a hierarchy.
    const TriangleMesh small = simplify_genus0(mesh, 1500);
    const SphereProblem problem(small.positions, small.triangles, {});
    for (const bool is_centered : {true, false}) {
      std::vector<Vec3> positions = is_centered ? centered_normalization(small) : stereographic_start(small);
      const std::size_t folds = problem.flipped_count(positions);
      int first_fold_free = -1;
      OptimizationOptions options;
      options.forbid_flips = false;
      options.maximum_iterations = 1000;
      options.observer = [&](const IterationRecord& record, const std::vector<Vec3>& x) {
        const bool is_fold_free = problem.flipped_count(x) == 0;
        if (!is_fold_free) first_fold_free = -1;
        if (is_fold_free && first_fold_free < 0) first_fold_free = record.iteration;
        return true;
      };
      const OptimizationResult result = minimize_trust_region(problem, positions, options);
      starts.add({file, fmt::format("{}", small.vertex_count()), is_centered ? "centred" : "stereographic",
                  fmt::format("{}", folds),
                  first_fold_free < 0 ? "never" : fmt::format("{}", first_fold_free),
                  fmt::format("{}", result.iterations), fmt::format("{:.1e}", result.gradient_norm),
                  fmt::format("{}", certify_sphere(positions, small.triangles).flipped_count)});
    }
  }
  table.print();
  table.write_csv(settings.output + "/sphere_fold_free.csv");
  starts.print();
  starts.write_csv(settings.output + "/sphere_starts.csv");
}

void run_collapse(const Settings& settings) {
  Table table({"mesh", "energy", "without factor", "steps", "smallest energy", "with factor", "steps with",
               "final energy with"});
  Plot plot;
  plot.title = "Fig. 4.4: energy without the factor, from a valid map";
  plot.x_label = "trust-region steps";
  plot.y_label = "energy";
  plot.log_y = true;
  struct Energy {
    const char* name;
    SphereEnergyWeights weights;
  };
  const std::vector<Energy> energies{
      {"Tutte", {1, 0, 0, 0, 0, true}}, {"(1; 0)", {0, 1, 0, 0, 0, true}}, {"(1; 1)", {0, 1, 1, 0, 0, true}}};
  for (const std::string& file : genus0_files()) {
    if (!settings.wants(file)) continue;
    const TriangleMesh small = simplify_genus0(load_mesh(settings, file), 1000);
    const std::vector<Vec3> start = parameterize_sphere(small).positions;
    for (const Energy& energy : energies) {
      std::vector<std::string> row{file, energy.name};
      for (const bool upper_bound : {false, true}) {
        SphereEnergyWeights weights = energy.weights;
        weights.upper_bound = upper_bound;
        const SphereProblem problem(small.positions, small.triangles, weights);
        std::vector<Vec3> positions = start;
        OptimizationOptions options;
        options.forbid_flips = false;
        options.maximum_iterations = 1000;
        PlotSeries series{file, {}};
        const double start_energy = problem.energy(start);
        options.observer = [&](const IterationRecord& record, const std::vector<Vec3>&) {
          series.points.emplace_back(record.iteration, std::max(record.energy, 1e-8 * start_energy));
          return record.energy > 1e-8 * start_energy;
        };
        const OptimizationResult result = minimize_trust_region(problem, positions, options);
        // All vertices within a small cap: the mean is almost a unit vector.
        Vec3 mean;
        for (const Vec3& x : positions) mean += x;
        const bool collapsed = norm(mean) > 0.999 * static_cast<double>(positions.size());
        const bool is_valid = certify_sphere(positions, small.triangles).is_bijective();
        row.push_back(collapsed ? "collapses" : is_valid ? "bijective" : "folded");
        row.push_back(fmt::format("{}", result.iterations));
        row.push_back(fmt::format("{:.4g}", result.energy));
        if (!upper_bound && std::string(energy.name) == "(1; 0)" && plot.series.size() < 8)
          plot.series.push_back(std::move(series));
      }
      table.add(std::move(row));
    }
  }
  table.print();
  table.write_csv(settings.output + "/sphere_collapse.csv");
  write_plots(settings.output + "/fig_4_4_collapse.svg", {plot});
}

}  // namespace nmc_bench
