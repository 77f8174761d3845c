// SPDX-License-Identifier: Apache-2.0
#include "encoder/sphere/sphere_parameterization.h"

#include <oneapi/tbb/global_control.h>

#include <catch2/catch.hpp>
#include <numbers>

#include "encoder/core/error.h"
#include "encoder/sphere/initialization.h"
#include "encoder/sphere/kernel_point.h"
#include "encoder/sphere/lbfgs.h"
#include "encoder/sphere/newton.h"
#include "encoder/sphere/nonlinear_cg.h"
#include "encoder/sphere/trust_region_newton.h"
#include "tests/unit/sphere/sphere_test_meshes.h"

using namespace nmc;

TEST_CASE("the kernel point of a polygon has the same clearance to the edges that hold it") {
  // A square of half-width atan(0.2) around the pole, with a notch.
  const std::vector<Vec3> polygon{normalized(Vec3{0.2, -0.2, 1}), normalized(Vec3{0.2, 0.2, 1}),
                                  normalized(Vec3{0, 0.1, 1}), normalized(Vec3{-0.2, 0.2, 1}),
                                  normalized(Vec3{-0.2, -0.2, 1})};
  const KernelPoint kernel = kernel_point(polygon);
  CHECK(kernel.clearance > 0.02);
  // No other point of a fine grid does better.
  double best = -1;
  for (int i = -100; i <= 100; ++i)
    for (int j = -100; j <= 100; ++j) {
      const Vec3 x = normalized(Vec3{0.002 * i, 0.002 * j, 1});
      double clearance = 1;
      for (std::size_t k = 0; k < polygon.size(); ++k)
        clearance =
            std::min(clearance, dot(x, normalized(cross(polygon[k], polygon[(k + 1) % polygon.size()]))));
      best = std::max(best, clearance);
    }
  CHECK(kernel.clearance >= best);
  CHECK(kernel.clearance == Approx(best).epsilon(0.03));
}

TEST_CASE("a polygon without a kernel is reported") {
  // A star with deep dents.
  std::vector<Vec3> polygon;
  for (int i = 0; i < 12; ++i) {
    const double angle = std::numbers::pi * i / 6 + (i % 2 ? 0.9 : 0), radius = i % 2 ? 0.05 : 0.5;
    polygon.push_back(normalized(Vec3{radius * std::cos(angle), radius * std::sin(angle), 1}));
  }
  CHECK(kernel_point(polygon).clearance <= 0);
}

TEST_CASE("difficult shapes map to the sphere bijectively, to a stationary point, under every energy") {
  struct Shape {
    const char* name;
    TriangleMesh mesh;
  };
  const std::vector<Shape> shapes{{"spiky", nmc_test::spiky_sphere(4, 0.7)},
                                  {"capsule", nmc_test::long_capsule(4, 6)}};
  struct Weights {
    const char* name;
    SphereEnergyWeights weights;
  };
  const std::vector<Weights> energies{{"Tutte", {1, 0, 0, 0, 0, true}},
                                      {"(1,0)", {0, 1, 0, 0, 0, true}},
                                      {"(1,1)", {0, 1, 1, 0, 0, true}},
                                      {"(0.2,1)", {0, 0.2, 1, 0, 0, true}},
                                      {"(0,1)", {0, 0, 1, 0, 0, true}},
                                      {"stretch", {0, 0, 0, 1, 0, true}}};
  for (const Shape& shape : shapes) {
    for (const Weights& energy : energies) {
      SphereOptions options;
      options.weights = energy.weights;
      const SphereParameterization result = parameterize_sphere(shape.mesh, options);
      INFO(shape.name << " " << energy.name << " gradient " << result.statistics.finest.gradient_norm);
      CHECK(result.certificate.is_bijective());
      CHECK(result.statistics.finest.converged);
    }
  }
}

TEST_CASE("a sphere maps to itself: the combined energy reaches its lower bound up to the mesh size") {
  const TriangleMesh mesh = nmc_test::geodesic_sphere(5);
  const SphereParameterization result = parameterize_sphere(mesh);
  const double bound = 2 * 4 * std::numbers::pi;
  CHECK(result.statistics.finest.energy == Approx(bound).epsilon(5e-3));
  // Up to a rotation: distances are kept.
  double worst = 0;
  for (std::size_t v = 1; v < mesh.vertex_count(); v += 37)
    worst = std::max(worst, std::abs(distance(mesh.positions[v], mesh.positions[0]) -
                                     distance(result.positions[v], result.positions[0])));
  CHECK(worst < 0.02);
}

TEST_CASE("more weight on areas evens out the areas") {
  const TriangleMesh mesh = nmc_test::long_capsule(4, 6);
  const auto area_spread = [&](double dirichlet) {
    SphereOptions options;
    options.weights.dirichlet = dirichlet;
    const std::vector<Vec3> x = parameterize_sphere(mesh, options).positions;
    double total = surface_area(mesh), spread = 0;
    for (const Triangle& t : mesh.triangles) {
      const Vec3 &a = mesh.positions[t[0]], &p = x[t[0]];
      const double reference =
          norm(cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a)) / 2 * 4 * std::numbers::pi / total;
      const double log_ratio = std::log(norm(cross(x[t[1]] - p, x[t[2]] - p)) / 2 / reference);
      spread += reference * log_ratio * log_ratio;
    }
    return spread;
  };
  const double even = area_spread(0.2), medium = area_spread(1), angles = area_spread(100);
  CHECK(even < medium);
  CHECK(medium < angles);
}

TEST_CASE("all solvers find the same energy from the same start") {
  const TriangleMesh mesh = nmc_test::spiky_sphere(3, 0.3);
  const SphereProblem problem(mesh.positions, mesh.triangles, {});
  const std::vector<Vec3> start = nmc_test::geodesic_sphere(3).positions;
  OptimizationOptions options;
  options.maximum_iterations = 3000;
  options.gradient_tolerance = 1e-6;
  const auto energy = [&](auto&& minimize) {
    std::vector<Vec3> positions = start;
    const OptimizationResult result = minimize(positions);
    CHECK(result.converged);
    CHECK(problem.flipped_count(positions) == 0);
    return result.energy;
  };
  const double expected = energy([&](std::vector<Vec3>& x) { return minimize_newton(problem, x, options); });
  CHECK(energy([&](std::vector<Vec3>& x) { return minimize_trust_region(problem, x, options); }) ==
        Approx(expected).epsilon(1e-10));
  CHECK(energy([&](std::vector<Vec3>& x) { return minimize_lbfgs(problem, x, options); }) ==
        Approx(expected).epsilon(1e-10));
  CHECK(energy([&](std::vector<Vec3>& x) { return minimize_nonlinear_cg(problem, x, options); }) ==
        Approx(expected).epsilon(1e-10));
}

TEST_CASE("both starts of the thesis lead to a bijection on a star-shaped surface") {
  const TriangleMesh mesh = nmc_test::spiky_sphere(3, 0.6);
  for (const SphereStart start : {SphereStart::kCenteredNormalized, SphereStart::kStereographic}) {
    SphereOptions options;
    options.start = start;
    options.solver = SphereSolver::kTrustRegionNewton;
    options.maximum_iterations = 500;
    const SphereParameterization result = parameterize_sphere(mesh, options);
    CHECK(result.certificate.is_bijective());
    CHECK(result.statistics.finest.gradient_norm < 1e-6);
  }
}

TEST_CASE("the map is the same for any number of threads") {
  const TriangleMesh mesh = nmc_test::spiky_sphere(4, 0.5);
  const std::vector<Vec3> many = parameterize_sphere(mesh).positions;
  oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism, 1);
  const std::vector<Vec3> one = parameterize_sphere(mesh).positions;
  CHECK(many == one);
}

TEST_CASE("the map does not depend on the unit or the origin of the surface") {
  const TriangleMesh mesh = nmc_test::spiky_sphere(3, 0.5);
  TriangleMesh moved = mesh;
  for (Vec3& p : moved.positions) p = 1024 * p + Vec3{4096, -8192, 512};
  const std::vector<Vec3> a = parameterize_sphere(mesh).positions, b = parameterize_sphere(moved).positions;
  double worst = 0;
  for (std::size_t v = 0; v < a.size(); ++v)
    worst = std::max(worst, std::abs(distance(a[v], a[0]) - distance(b[v], b[0])));
  CHECK(worst < 1e-6);
}

TEST_CASE("simplification keeps the asked number of vertices, a subset of the input's") {
  const TriangleMesh mesh = nmc_test::spiky_sphere(4, 0.3);
  const TriangleMesh simple = simplify_genus0(mesh, 100);
  CHECK(simple.vertex_count() == 100);
  CHECK(simple.triangle_count() == 196);
  for (const Vec3& p : simple.positions)
    CHECK(std::find(mesh.positions.begin(), mesh.positions.end(), p) != mesh.positions.end());
}
