// SPDX-License-Identifier: Apache-2.0
#include "encoder/normal_mesh/variational_normal_mesh.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <utility>

#include "encoder/normal_mesh/unconstrained_vector_mesh.h"
#include "tests/unit/normal_mesh/synthetic_surfaces.h"

namespace nmc {
namespace {

struct Scene {
  Parameterization map;
  DomainParameterizedSurface surface;
  SurfaceIndex index;
  explicit Scene(Parameterization parameterization)
      : map(std::move(parameterization)), surface(map), index(*map.surface) {}
};

/// RMS of |R o p - S| over one level, by an own, finer quadrature.
double rms(const ParameterizedSurface& surface, const LevelTopology& topology, int level,
           const std::vector<Vec3>& positions, const std::vector<SurfaceParameter>& parameters) {
  double sum = 0, weights = 0;
  const auto centroids = sub_triangle_centroids(12);
  for (std::uint32_t f = 0; f < topology.face_count; ++f) {
    const std::uint32_t* v = topology.face_vertices.data() + 3 * f;
    const SurfaceParameter corners[3] = {parameters[v[0]], parameters[v[1]], parameters[v[2]]};
    LocalChart chart;
    ChartPoint at[3];
    REQUIRE(surface.make_chart(f >> (2 * level), corners, chart, at));
    const double area = norm(cross(positions[v[1]] - positions[v[0]], positions[v[2]] - positions[v[0]]));
    for (const auto& b : centroids) {
      const Vec3 own = b[0] * positions[v[0]] + b[1] * positions[v[1]] + b[2] * positions[v[2]];
      const ChartPoint u = (b[0] * at[0] + b[1] * at[1]) + b[2] * at[2];
      sum += area * squared_norm(surface.position(surface.locate(surface.from_chart(chart, u))) - own);
      weights += area;
    }
  }
  return std::sqrt(sum / weights);
}

TEST_CASE("vertex system: conjugate gradients solve a mass matrix to the tolerance", "[vertex_system]") {
  const test::BaseShape base = test::icosahedron();
  const SubdivisionHierarchy hierarchy(base.faces, 12, 3);
  const LevelTopology& topology = hierarchy.level(3);
  test::Random random(3);
  std::vector<VertexSystem::FaceMatrix> matrices;
  for (std::uint32_t f = 0; f < topology.face_count; ++f) {
    const double a = random.uniform(0.01, 1);
    matrices.push_back({a / 6, a / 6, a / 6, a / 12, a / 12, a / 12});
  }
  const VertexSystem system(topology, matrices);
  std::vector<double> x(topology.vertex_count), b, solution;
  for (double& value : x) value = random.uniform(-1, 1);
  system.multiply(x, b);
  const int iterations = system.solve(b, {1e-12, 200}, solution);
  double worst = 0;
  for (std::size_t i = 0; i < x.size(); ++i) worst = std::max(worst, std::abs(x[i] - solution[i]));
  CHECK(worst < 1e-10);
  CHECK(iterations < 60);
}

TEST_CASE("quadrature: mass matrices are the exact ones", "[quadrature]") {
  const Scene scene(make_parameterization(test::icosahedron(), 2, 0, test::on_unit_sphere));
  const ParameterizedBase base = base_of(scene.map);
  const SubdivisionHierarchy hierarchy(base.faces, 12, 0);
  QuadratureOptions options;
  options.weighting = AreaWeighting::kUniform;
  options.subdivisions = {12, 12, 12};
  for (const FaceIntegrals& f :
       integrate_faces(scene.surface, hierarchy.level(0), 0, base.positions, base.parameters, options)) {
    for (std::size_t k = 0; k < 3; ++k) {
      CHECK(f.mass[k] == Approx(1.0 / 6).epsilon(0.01));
      CHECK(f.mass[3 + k] == Approx(1.0 / 12).epsilon(0.01));
    }
  }
}

TEST_CASE("variational normal mesh: better than interpolating on every level, not better than free vectors",
          "[variational]") {
  const Scene scene(make_parameterization(test::icosahedron(), 5, 0.1, [](const Vec3& p) {
    const Vec3 n = test::on_bumpy_sphere(p);
    return (1 + 0.02 * std::sin(25 * n.x) * std::sin(23 * n.y)) * n;
  }));
  VariationalOptions options;
  options.interpolating.level_count = 3;
  const ParameterizedBase base = base_of(scene.map);
  const VariationalResult variational = variational_normal_mesh(scene.surface, scene.index, base, options);
  const InterpolatingResult interpolating =
      interpolate(scene.surface, scene.index, base, options.interpolating);
  const auto vectors =
      unconstrained_vector_mesh(scene.surface, variational.hierarchy, variational.parameters);
  REQUIRE(variational.positions.size() == 4);
  CHECK(variational.non_normal_share() < 0.01);
  for (int l = 1; l <= 3; ++l) {
    const LevelTopology& topology = variational.hierarchy.level(l);
    const auto i = static_cast<std::size_t>(l);
    const double best = rms(scene.surface, topology, l, variational.positions[i], variational.parameters);
    const double free = rms(scene.surface, topology, l, vectors[i], variational.parameters);
    const double interpolated =
        rms(scene.surface, topology, l, reconstruct(interpolating.mesh, l), interpolating.parameters);
    INFO("level " << l << ": interpolating " << interpolated << ", variational " << best << ", vectors "
                  << free);
    CHECK(best < 0.95 * interpolated);
    CHECK(free <= 1.02 * best);
    CHECK(variational.solver_iterations[i - 1] < 100);
  }
}

TEST_CASE("variational normal mesh: vertices never leave their normal lines", "[variational]") {
  const Scene scene(make_parameterization(test::octahedron(), 4, 0.2, test::on_bumpy_sphere));
  VariationalOptions options;
  options.interpolating.level_count = 3;
  const VariationalResult result =
      variational_normal_mesh(scene.surface, scene.index, base_of(scene.map), options);
  double worst = 0;
  for (std::size_t l = 2; l <= 3; ++l) {
    for (std::size_t v = 0; v < result.positions[l - 1].size(); ++v) {
      const Vec3 step = result.positions[l][v] - result.positions[l - 1][v];
      worst = std::max(worst, norm(step - result.coefficients[l][v] * result.directions[v]));
    }
  }
  CHECK(worst < 1e-14);
}

TEST_CASE("variational normal mesh: every normal line passes through the point of the input at its parameter",
          "[variational]") {
  const Scene scene(make_parameterization(test::octahedron(), 4, 0.2, test::on_bumpy_sphere));
  for (const bool fit_base : {false, true}) {
    VariationalOptions options;
    options.interpolating.level_count = 3;
    options.fit_base = fit_base;
    const ParameterizedBase base = base_of(scene.map);
    const VariationalResult result = variational_normal_mesh(scene.surface, scene.index, base, options);
    double worst = 0;
    for (std::size_t v = 0; v < result.directions.size(); ++v) {
      const Vec3 offset =
          scene.surface.position(scene.surface.locate(result.parameters[v])) - result.positions[3][v];
      worst = std::max(worst, norm(cross(offset, result.directions[v])));
    }
    CHECK(worst < 1e-10);
    CHECK((result.positions[0] == base.positions) == !fit_base);
  }
}

TEST_CASE("variational normal mesh: the solution is a minimum along every line", "[variational]") {
  const Scene scene(make_parameterization(test::octahedron(), 4, 0, test::on_bumpy_sphere));
  VariationalOptions options;
  options.interpolating.level_count = 2;
  options.quadrature.subdivisions = {12, 12, 12};
  options.quadrature.weighting = AreaWeighting::kUniform;
  const VariationalResult result =
      variational_normal_mesh(scene.surface, scene.index, base_of(scene.map), options);
  const LevelTopology& topology = result.hierarchy.level(2);
  // The gradient along each line: integral of hat times (S - R o p) . n.
  std::vector<double> gradient(topology.vertex_count, 0);
  const auto integrals =
      integrate_faces(scene.surface, topology, 2, result.positions[2], result.parameters, options.quadrature);
  for (std::uint32_t f = 0; f < topology.face_count; ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
      const std::uint32_t* v = topology.face_vertices.data() + 3 * f;
      const Vec3 present = integrals[f].mass[k] * result.positions[2][v[k]] +
                           integrals[f].mass[3 + j] * result.positions[2][v[i]] +
                           integrals[f].mass[3 + i] * result.positions[2][v[j]];
      gradient[v[k]] += dot(result.directions[v[k]], present - integrals[f].load[k]);
    }
  }
  double worst = 0;
  for (const double g : gradient) worst = std::max(worst, std::abs(g));
  CHECK(worst < 1e-7);
}

TEST_CASE("unconstrained vectors: a flat surface is reproduced exactly", "[vectors]") {
  const Scene scene(make_parameterization(test::sheet(2), 3, 0, test::unchanged));
  const ParameterizedBase base = base_of(scene.map);
  const SubdivisionHierarchy hierarchy(base.faces, static_cast<std::uint32_t>(base.positions.size()), 2);
  const auto parameters = midpoint_parameters(scene.surface, hierarchy, base.parameters);
  const auto remesh = sample_surface(scene.surface, parameters);
  const auto vectors = unconstrained_vector_mesh(scene.surface, hierarchy, parameters, {}, {1e-13, 500});
  double worst = 0;
  for (std::size_t v = 0; v < remesh.size(); ++v) worst = std::max(worst, distance(remesh[v], vectors[2][v]));
  CHECK(worst < 1e-10);
}

}  // namespace
}  // namespace nmc
