// SPDX-License-Identifier: Apache-2.0
#include "encoder/sphere/spherical_energy.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "encoder/sphere/exact_orientation.h"
#include "encoder/sphere/sphere_problem.h"
#include "tests/unit/sphere/sphere_test_meshes.h"

using namespace nmc;

namespace {

struct NamedWeights {
  const char* name;
  SphereEnergyWeights weights;
};

std::vector<NamedWeights> all_energies() {
  std::vector<NamedWeights> energies;
  const auto add = [&](const char* name, double tutte, double dirichlet, double area, double stretch,
                       double barrier) {
    energies.push_back({name, {tutte, dirichlet, area, stretch, barrier, true}});
  };
  add("Tutte", 1, 0, 0, 0, 0);
  add("Dirichlet", 0, 1, 0, 0, 0);
  add("area", 0, 0, 1, 0, 0);
  add("combined", 0, 0.2, 1, 0, 0);
  add("stretch", 0, 0, 0, 1, 0);
  add("barrier", 0, 1, 1, 0, 0.1);
  return energies;
}

}  // namespace

TEST_CASE("the Riemannian gradient and Hessian agree with differences of the energy") {
  const TriangleMesh mesh = nmc_test::spiky_sphere(1, 0.3);
  const std::vector<Vec3> positions = nmc_test::jiggled(nmc_test::geodesic_sphere(1).positions, 0.2, 7);
  std::vector<TangentFrame> frames;
  for (const Vec3& x : positions) frames.push_back(tangent_frame(x));
  for (const NamedWeights& energy : all_energies()) {
    const SphereProblem problem(mesh.positions, mesh.triangles, energy.weights);
    std::vector<Tangent2> gradient;
    BlockMatrix hessian;
    problem.hessian(positions, frames, HessianKind::kExact, gradient, hessian);

    // One smooth direction in all vertices at once, along geodesics.
    std::vector<Tangent2> direction(positions.size());
    for (std::size_t v = 0; v < direction.size(); ++v)
      direction[v] = {std::sin(3.0 * static_cast<double>(v) + 1), std::cos(2.0 * static_cast<double>(v))};
    const auto energy_at = [&](double s) {
      std::vector<Vec3> moved(positions.size());
      for (std::size_t v = 0; v < moved.size(); ++v) {
        const Vec3 d = direction[v][0] * frames[v].u + direction[v][1] * frames[v].v;
        const double length = norm(d);
        moved[v] = std::cos(s * length) * positions[v] + (std::sin(s * length) / length) * d;
      }
      return problem.energy(moved);
    };
    const double h = 1e-4;
    const double slope = (energy_at(h) - energy_at(-h)) / (2 * h);
    const double curvature = (energy_at(h) - 2 * energy_at(0) + energy_at(-h)) / (h * h);
    std::vector<Tangent2> image;
    hessian.multiply(problem.graph(), direction, image);
    INFO(energy.name);
    CHECK(dot(gradient, direction) == Approx(slope).epsilon(1e-5));
    CHECK(dot(direction, image) == Approx(curvature).epsilon(1e-4));

    std::vector<Vec3> spatial_gradient;
    problem.gradient(positions, spatial_gradient);
    for (std::size_t v = 0; v < positions.size(); ++v) {
      CHECK(dot(spatial_gradient[v], frames[v].u) == Approx(gradient[v][0]).margin(1e-9));
      CHECK(dot(spatial_gradient[v], frames[v].v) == Approx(gradient[v][1]).margin(1e-9));
    }
  }
}

TEST_CASE("the derivatives of the solid angle agree with differences by the edge lengths' corners") {
  const Vec3 x0 = normalized(Vec3{1, 0.1, 0.2}), x2 = normalized(Vec3{0.1, 0.3, 1});
  const auto corner = [](double s) { return normalized(Vec3{0.2, 1 + s, 0.1 - s * s}); };
  const auto lengths = [&](double s) {
    const Vec3 x1 = corner(s);
    return std::array<double, 3>{squared_norm(x2 - x1), squared_norm(x0 - x2), squared_norm(x1 - x0)};
  };
  const auto angle = [&](double s) { return solid_angle_hessian(x0, corner(s), x2); };
  CHECK(angle(0).value == Approx(signed_solid_angle(x0, corner(0), x2)));
  const double h = 1e-5;
  const TriangleEnergy before = angle(-h), here = angle(0), after = angle(h);
  double slope = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double by = (lengths(h)[i] - lengths(-h)[i]) / (2 * h);
    slope += here.gradient[i] * by;
    double change = 0;
    for (std::size_t j = 0; j < 3; ++j)
      change += here.hessian[i][j] * (lengths(h)[j] - lengths(-h)[j]) / (2 * h);
    CHECK(change == Approx((after.gradient[i] - before.gradient[i]) / (2 * h)).epsilon(1e-6));
  }
  CHECK(slope == Approx((after.value - before.value) / (2 * h)).epsilon(1e-6));
}

TEST_CASE("the projected Hessian has no negative curvature") {
  const TriangleMesh mesh = nmc_test::spiky_sphere(2, 0.4);
  const std::vector<Vec3> positions = nmc_test::jiggled(nmc_test::geodesic_sphere(2).positions, 0.3, 3);
  std::vector<TangentFrame> frames;
  for (const Vec3& x : positions) frames.push_back(tangent_frame(x));
  for (const NamedWeights& energy : all_energies()) {
    const SphereProblem problem(mesh.positions, mesh.triangles, energy.weights);
    std::vector<Tangent2> gradient, image;
    BlockMatrix hessian;
    problem.hessian(positions, frames, HessianKind::kProjected, gradient, hessian);
    double smallest = 1e300;
    for (int trial = 0; trial < 200; ++trial) {
      std::vector<Tangent2> direction(positions.size());
      for (std::size_t v = 0; v < direction.size(); ++v)
        direction[v] = {std::sin(7.1 * trial + 3.7 * static_cast<double>(v)),
                        std::sin(5.3 * trial + 2.9 * static_cast<double>(v) + 1)};
      hessian.multiply(problem.graph(), direction, image);
      smallest = std::min(smallest, dot(direction, image));
    }
    INFO(energy.name);
    CHECK(smallest >= 0);
  }
}

TEST_CASE(
    "the bounds enclose the spherical Dirichlet energy, and close quadratically in the triangle's size") {
  // Numerical quadrature of the Dirichlet energy of the gnomonic map of one triangle onto the sphere.
  const auto quadrature = [](const Vec3& a, const Vec3& b, const Vec3& c) {
    // Isometric reference: the secant triangle itself, so that f is the identity.
    constexpr int kSteps = 200;
    double sum = 0;
    const Vec3 e1 = b - a, e2 = c - a;
    const Vec3 u = normalized(e1), n = normalized(cross(e1, e2));
    const Vec3 v = cross(n, u);
    for (int i = 0; i < kSteps; ++i)
      for (int j = 0; i + j < kSteps; ++j)
        for (int half = 0; half < (i + j + 1 < kSteps ? 2 : 1); ++half) {
          const double s = (i + (half ? 2.0 : 1.0) / 3) / kSteps, t = (j + (half ? 2.0 : 1.0) / 3) / kSteps;
          const Vec3 y = a + s * e1 + t * e2;
          const double r = norm(y);
          const Vec3 x = y / r;
          // D(y / |y|) = (I - x x^T) / |y|
          const Vec3 du = (u - dot(u, x) * x) / r, dv = (v - dot(v, x) * x) / r;
          sum += squared_norm(du) + squared_norm(dv);
        }
    // tr(Df^T Df) / 2, so that an isometry costs its area.
    return sum / 2 * norm(cross(e1, e2)) / 2 / (kSteps * kSteps);
  };
  const SphereEnergyWeights dirichlet{0, 1, 0, 0, 0, true};
  const SphereEnergyWeights secant{0, 1, 0, 0, 0, false};
  double previous_gap = 0;
  for (int step = 0; step < 4; ++step) {
    const double radius = 0.4 / (1 << step);
    const auto corner = [&](double angle) {
      return Vec3{std::sin(radius) * std::cos(angle), std::sin(radius) * std::sin(angle), std::cos(radius)};
    };
    const Vec3 a = corner(0.1), b = corner(2.0), c = corner(4.3);
    const ReferenceTriangle reference = reference_triangle(a, b, c, 1, 0);
    const double lower = triangle_energy(secant, reference, a, b, c);
    const double upper = triangle_energy(dirichlet, reference, a, b, c);
    const double exact = quadrature(a, b, c);
    INFO("radius " << radius);
    CHECK(lower <= exact);
    CHECK(exact <= upper);
    const double gap = (upper - exact) / exact;
    if (step > 0) CHECK(std::log2(previous_gap / gap) == Approx(2).margin(0.15));
    previous_gap = gap;
  }
}

TEST_CASE("a triangle that reaches a hemisphere costs infinitely much, unless the bound is switched off") {
  const ReferenceTriangle reference = reference_triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 1, 0);
  const auto corner = [](double angle) { return Vec3{std::cos(angle), std::sin(angle), 0}; };
  const Vec3 a = corner(0), b = corner(2.1), c = corner(4.2);
  CHECK(std::isinf(triangle_energy({0, 1, 1, 0, 0, true}, reference, a, b, c)));
  CHECK(std::isfinite(triangle_energy({0, 1, 1, 0, 0, false}, reference, a, b, c)));
}

TEST_CASE("an isometry costs its area in every energy but Tutte's") {
  const Vec3 a = normalized(Vec3{0.01, 0, 1}), b = normalized(Vec3{-0.006, 0.008, 1}),
             c = normalized(Vec3{-0.006, -0.009, 1});
  const ReferenceTriangle reference = reference_triangle(a, b, c, 1, 0);
  for (const NamedWeights& energy : all_energies()) {
    if (energy.weights.tutte > 0) continue;
    const SphereEnergyWeights& w = energy.weights;
    const double sum = w.dirichlet + w.area + w.stretch + w.barrier;
    INFO(energy.name);
    CHECK(triangle_energy(w, reference, a, b, c) == Approx(sum * reference.area).epsilon(1e-3));
  }
}
