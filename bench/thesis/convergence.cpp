// SPDX-License-Identifier: Apache-2.0
// Appendix A: convergence of the solvers (Fig. A.7) and of forcing sequences (Fig. A.8) on a small spherical
// problem.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "bench/thesis/experiment.h"
#include "bench/thesis/svg_plot.h"
#include "encoder/sphere/initialization.h"
#include "encoder/sphere/lbfgs.h"
#include "encoder/sphere/newton.h"
#include "encoder/sphere/nonlinear_cg.h"
#include "encoder/sphere/sphere_parameterization.h"
#include "encoder/sphere/trust_region_newton.h"

namespace nmc_bench {

using namespace nmc;

namespace {

struct Run {
  std::string name;
  std::function<OptimizationResult(const SphereProblem&, std::vector<Vec3>&, const OptimizationOptions&)>
      minimize;
  std::vector<IterationRecord> records;
};

// Every run from the same start; the plots show the distance to the lowest energy that any of them found.
void compare(const Settings& settings, const std::string& name, const std::string& title,
             const SphereProblem& problem, const std::vector<Vec3>& start, std::vector<Run> runs) {
  Table table({"method", "steps", "evaluations and products", "cpu s", "energy", "gradient",
               "steps to 1e-6 of the energy", "seconds to it"});
  double lowest = std::numeric_limits<double>::infinity();
  for (Run& run : runs) {
    std::vector<Vec3> positions = start;
    OptimizationOptions options;
    options.forbid_flips = false;
    options.maximum_iterations = 5000;
    options.gradient_tolerance = 1e-9;
    options.observer = [&](const IterationRecord& record, const std::vector<Vec3>&) {
      run.records.push_back(record);
      return true;
    };
    run.minimize(problem, positions, options);
    lowest = std::min(lowest, run.records.back().energy);
  }
  Plot by_step{title + ", by step", "steps", "f(x) - f(x*)", false, true, {}};
  Plot by_time{title + ", by time", "seconds", "f(x) - f(x*)", true, true, {}};
  for (const Run& run : runs) {
    PlotSeries steps{run.name, {}}, times{run.name, {}};
    int steps_needed = -1;
    double seconds_needed = 0;
    for (const IterationRecord& r : run.records) {
      const double gap = std::max(r.energy - lowest, 1e-14);
      // First-order methods take thousands of steps; the beginning tells the story.
      if (r.iteration <= 300) steps.points.emplace_back(r.iteration, gap);
      times.points.emplace_back(std::max(r.seconds, 1e-4), gap);
      if (steps_needed < 0 && gap < 1e-6 * lowest) {
        steps_needed = r.iteration;
        seconds_needed = r.seconds;
      }
    }
    by_step.series.push_back(std::move(steps));
    by_time.series.push_back(std::move(times));
    const IterationRecord& last = run.records.back();
    table.add({run.name, fmt::format("{}", last.iteration), fmt::format("{}", last.evaluations),
               fmt::format("{:.3f}", last.seconds), fmt::format("{:.10f}", last.energy),
               fmt::format("{:.1e}", last.gradient_norm),
               steps_needed < 0 ? "never" : fmt::format("{}", steps_needed),
               fmt::format("{:.3f}", seconds_needed)});
  }
  table.print();
  table.write_csv(settings.output + "/" + name + ".csv");
  write_plots(settings.output + "/" + name + ".svg", {by_step, by_time});
}

}  // namespace

void run_convergence(const Settings& settings) {
  // 502 vertices, 1004 variables.
  const TriangleMesh mesh = simplify_genus0(load_mesh(settings, "igea.ply"), 502);
  const SphereProblem problem(mesh.positions, mesh.triangles, {});
  const std::vector<Vec3> start = centered_normalization(mesh);
  const auto trust_region = [](double forcing, bool block_jacobi) {
    return [=](const SphereProblem& p, std::vector<Vec3>& x, const OptimizationOptions& o) {
      TrustRegionOptions options;
      options.forcing = forcing;
      options.block_jacobi = block_jacobi;
      return minimize_trust_region(p, x, o, options);
    };
  };
  const auto conjugate = [](ConjugateGradientRule rule) {
    return [=](const SphereProblem& p, std::vector<Vec3>& x, const OptimizationOptions& o) {
      return minimize_nonlinear_cg(p, x, o, rule);
    };
  };
  compare(settings, "fig_a_7_solvers", "Fig. A.7: solvers", problem, start,
          {{"Newton trust region", trust_region(0.1, false), {}},
           {"L-BFGS",
            [](const SphereProblem& p, std::vector<Vec3>& x, const OptimizationOptions& o) {
              return minimize_lbfgs(p, x, o);
            },
            {}},
           {"CG Polak-Ribiere+", conjugate(ConjugateGradientRule::kPolakRibierePlus), {}},
           {"CG Polak-Ribiere", conjugate(ConjugateGradientRule::kPolakRibiere), {}},
           {"steepest descent", conjugate(ConjugateGradientRule::kSteepestDescent), {}},
           {"Newton, Cholesky",
            [](const SphereProblem& p, std::vector<Vec3>& x, const OptimizationOptions& o) {
              return minimize_newton(p, x, o);
            },
            {}}});
  compare(settings, "fig_a_8_forcing", "Fig. A.8: forcing terms", problem, start,
          {{"eta 1e-6", trust_region(1e-6, false), {}},
           {"eta 1e-3", trust_region(1e-3, false), {}},
           {"eta 0.1", trust_region(0.1, false), {}},
           {"eta 0.5", trust_region(0.5, false), {}},
           {"eta min(0.5; sqrt|g|)", trust_region(0, false), {}},
           {"the same, block Jacobi", trust_region(0, true), {}}});
}

}  // namespace nmc_bench
