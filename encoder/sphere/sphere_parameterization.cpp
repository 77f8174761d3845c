// SPDX-License-Identifier: Apache-2.0
#include "encoder/sphere/sphere_parameterization.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>

#include "encoder/core/error.h"
#include "encoder/sphere/collapse_hierarchy.h"
#include "encoder/sphere/initialization.h"
#include "encoder/sphere/kernel_point.h"
#include "encoder/sphere/lbfgs.h"
#include "encoder/sphere/newton.h"
#include "encoder/sphere/nonlinear_cg.h"
#include "encoder/sphere/star_relaxation.h"
#include "encoder/sphere/trust_region_newton.h"

namespace nmc {

namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

OptimizationResult minimize(const SphereProblem& problem, std::vector<Vec3>& positions, SphereSolver solver,
                            const OptimizationOptions& options) {
  switch (solver) {
    case SphereSolver::kNewton:
      return minimize_newton(problem, positions, options);
    case SphereSolver::kTrustRegionNewton:
      return minimize_trust_region(problem, positions, options);
    case SphereSolver::kLbfgs:
      return minimize_lbfgs(problem, positions, options);
    case SphereSolver::kNonlinearConjugateGradient:
      return minimize_nonlinear_cg(problem, positions, options);
    case SphereSolver::kSteepestDescent:
      return minimize_nonlinear_cg(problem, positions, options, ConjugateGradientRule::kSteepestDescent);
  }
  throw Error(ExitCode::kInternal, "unknown solver");
}

class CoarseToFine {
 public:
  CoarseToFine(const TriangleMesh& mesh, const SphereOptions& options, SphereStatistics& statistics)
      : mesh_(mesh), options_(options), statistics_(statistics), hierarchy_(mesh.positions, mesh.triangles) {
    // The stretch energy has a pole at every degenerate triangle, and insertion can come near one: reach its
    // basin by way of the combined energy.
    path_weights_ = options.weights.stretch > 0 ? SphereEnergyWeights{} : options.weights;
  }

  std::vector<Vec3> run() {
    const Clock::time_point start = Clock::now();
    report(options_.progress, "collapse", 0);
    hierarchy_.collapse_to(4);
    statistics_.collapse_seconds = seconds_since(start);

    const std::uint32_t count = static_cast<std::uint32_t>(mesh_.vertex_count());
    sphere_.assign(count, Vec3{});
    place_tetrahedron();
    // Levels at each doubling; the last one before the finest is dropped when it would be nearly as large.
    std::uint32_t next_level = 24;
    Clock::time_point insertion_start = Clock::now();
    while (true) {
      const bool is_finest = !hierarchy_.can_undo();
      if (is_finest || hierarchy_.live_count() >= next_level) {
        statistics_.insertion_seconds += seconds_since(insertion_start);
        optimize_level(is_finest);
        insertion_start = Clock::now();
        report(options_.progress, "spherical parameterization",
               static_cast<double>(hierarchy_.live_count()) / count);
        next_level = 2 * hierarchy_.live_count();
        if (next_level > 0.7 * count) next_level = count + 1;
      }
      if (is_finest) break;
      insert();
    }
    return std::move(sphere_);
  }

 private:
  void place_tetrahedron() {
    const HierarchyLevel level = hierarchy_.level();
    const double c = 1 / std::sqrt(3.0);
    const Vec3 corners[4] = {{c, c, c}, {c, -c, -c}, {-c, c, -c}, {-c, -c, c}};
    for (int k = 0; k < 4; ++k) sphere_[level.vertices[k]] = corners[k];
    const Triangle& t = level.triangles[0];
    if (dot(sphere_[level.vertices[t[0]]],
            cross(sphere_[level.vertices[t[1]]], sphere_[level.vertices[t[2]]])) < 0)
      std::swap(sphere_[level.vertices[0]], sphere_[level.vertices[1]]);
  }

  void insert() {
    const std::uint32_t v = hierarchy_.undo();
    hierarchy_.link(v, link_);
    polygon_.clear();
    for (const std::uint32_t w : link_) polygon_.push_back(sphere_[w]);
    const KernelPoint kernel = kernel_point(polygon_);
    sphere_[v] = kernel.position;
    if (!(kernel.clearance > 0)) ++statistics_.insertions_without_kernel;

    const double sphere_area = 4 * std::numbers::pi;
    const double minimum_area = 1e-4 * sphere_area / (2.0 * hierarchy_.live_count());
    if (area_scale_ == 0) area_scale_ = sphere_area / surface_area(mesh_);
    star_.clear();
    for (std::size_t i = 0; i < link_.size(); ++i) {
      const std::uint32_t p = link_[i], q = link_[(i + 1) % link_.size()];
      star_.push_back({sphere_[p], sphere_[q],
                       reference_triangle(mesh_.positions[v], mesh_.positions[p], mesh_.positions[q],
                                          area_scale_, minimum_area)});
    }
    constexpr int kIterations = 3;
    sphere_[v] = relax_star(path_weights_, star_, sphere_[v], kIterations);
  }

  void optimize_level(bool is_finest) {
    const Clock::time_point start = Clock::now();
    HierarchyLevel level = hierarchy_.level();
    std::vector<Vec3> reference(level.vertices.size()), positions(level.vertices.size());
    for (std::size_t i = 0; i < level.vertices.size(); ++i) {
      reference[i] = mesh_.positions[level.vertices[i]];
      positions[i] = sphere_[level.vertices[i]];
    }
    const SphereProblem path(reference, level.triangles, path_weights_);
    constexpr int kSweeps = 2;
    for (int sweep = 0; sweep < kSweeps; ++sweep) gauss_seidel_sweep(path, positions);

    // The next level starts from here: precision beyond its own insertion error is wasted.
    OptimizationOptions rough;
    rough.maximum_iterations = 4;
    rough.relative_decrease = 1e-3;
    rough.forbid_flips = path.flipped_count(positions) == 0;
    OptimizationResult result;
    const auto solver_of = [&](SphereSolver wanted) {
      return wanted == SphereSolver::kNewton && path.vertex_count() > options_.direct_solver_limit
                 ? SphereSolver::kLbfgs
                 : wanted;
    };
    if (!is_finest || options_.weights.stretch > 0) {
      result = minimize(path, positions, solver_of(SphereSolver::kNewton), rough);
      count_work(result);
    }
    if (is_finest) {
      const SphereProblem problem(reference, std::move(level.triangles), options_.weights);
      OptimizationOptions fine;
      fine.maximum_iterations = options_.maximum_iterations;
      fine.gradient_tolerance = options_.gradient_tolerance;
      fine.relative_decrease = options_.relative_decrease;
      fine.forbid_flips = problem.flipped_count(positions) == 0;
      result = minimize(problem, positions, solver_of(options_.solver), fine);
      count_work(result);
    }
    for (std::size_t i = 0; i < level.vertices.size(); ++i) sphere_[level.vertices[i]] = positions[i];
    statistics_.optimization_seconds += seconds_since(start);
    if (is_finest) {
      statistics_.finest = result;
      statistics_.finest_seconds = seconds_since(start);
    }
  }

  void count_work(const OptimizationResult& result) {
    statistics_.newton_iterations += result.iterations;
    statistics_.factorizations += result.factorizations;
  }

  const TriangleMesh& mesh_;
  const SphereOptions& options_;
  SphereEnergyWeights path_weights_;
  SphereStatistics& statistics_;
  CollapseHierarchy hierarchy_;
  std::vector<Vec3> sphere_;
  std::vector<std::uint32_t> link_;
  std::vector<Vec3> polygon_;
  std::vector<StarTriangle> star_;
  double area_scale_ = 0;
};

}  // namespace

SphereParameterization parameterize_sphere(const TriangleMesh& closed_genus0, const SphereOptions& options) {
  const Clock::time_point start = Clock::now();
  SphereParameterization result;
  if (options.start == SphereStart::kHierarchy) {
    result.positions = CoarseToFine(closed_genus0, options, result.statistics).run();
  } else {
    // The hierarchy's constructor is also the check of the input.
    const CollapseHierarchy check(closed_genus0.positions, closed_genus0.triangles);
    result.positions = options.start == SphereStart::kCenteredNormalized
                           ? centered_normalization(closed_genus0)
                           : stereographic_start(closed_genus0);
    const SphereProblem problem(closed_genus0.positions, closed_genus0.triangles, options.weights);
    OptimizationOptions optimization;
    optimization.maximum_iterations = options.maximum_iterations;
    optimization.gradient_tolerance = options.gradient_tolerance;
    optimization.relative_decrease = options.relative_decrease;
    optimization.forbid_flips = problem.flipped_count(result.positions) == 0;
    const Clock::time_point optimization_start = Clock::now();
    result.statistics.finest = minimize(problem, result.positions, options.solver, optimization);
    result.statistics.newton_iterations = result.statistics.finest.iterations;
    result.statistics.factorizations = result.statistics.finest.factorizations;
    result.statistics.finest_seconds = result.statistics.optimization_seconds =
        seconds_since(optimization_start);
  }
  result.certificate = certify_sphere(result.positions, closed_genus0.triangles);
  result.statistics.total_seconds = seconds_since(start);
  if (options.require_bijection && !result.certificate.is_bijective())
    throw Error(
        ExitCode::kInternal,
        fmt::format("the map to the sphere is not a bijection: {} flipped triangles, solid angle {} of 4 pi",
                    result.certificate.flipped_count, result.certificate.solid_angle_over_4pi));
  return result;
}

TriangleMesh simplify_genus0(const TriangleMesh& mesh, std::uint32_t vertex_count) {
  CollapseHierarchyOptions options;
  options.edge_length_weight = 1e-6;
  CollapseHierarchy hierarchy(mesh.positions, mesh.triangles, options);
  hierarchy.collapse_to(vertex_count);
  HierarchyLevel level = hierarchy.level();
  TriangleMesh result;
  for (const std::uint32_t v : level.vertices) result.positions.push_back(mesh.positions[v]);
  result.triangles = std::move(level.triangles);
  return result;
}

}  // namespace nmc
