// SPDX-License-Identifier: Apache-2.0
#include "encoder/fit/synthesis_operator.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "encoder/fit/fit_system.h"
#include "encoder/fit/global_fit.h"
#include "tests/unit/fit/bumpy_sphere.h"

namespace nmc {

namespace {

std::vector<Triangle> open_faces() {
  std::vector<Triangle> faces = octahedron_faces();
  faces.pop_back();
  return faces;
}

std::vector<double> numbers(std::size_t count, FixedNumbers& source) {
  std::vector<double> v(count);
  for (double& x : v) x = source.next();
  return v;
}

}  // namespace

TEST_CASE("The adjoint pass is the transpose of the forward pass") {
  for (const bool open : {false, true}) {
    for (const double tension : {1.0, 0.75}) {
      const NormalMesh mesh = interpolating_mesh({}, 4, 5, open ? open_faces() : octahedron_faces());
      SynthesisOperator synthesis(mesh.hierarchy, unknown_layout(mesh, 3), std::vector<double>(4, tension));
      std::vector<Vec3> positions;
      synthesis.synthesize(values_of(mesh, synthesis.layout()), positions);
      FixedNumbers source;
      const std::vector<double> v = numbers(synthesis.layout().count, source);
      std::vector<Vec3> w(synthesis.finest_vertex_count());
      for (Vec3& x : w) x = {source.next(), source.next(), source.next()};
      std::vector<Vec3> jv;
      synthesis.forward(v, jv);
      double left = 0, right = 0, scale = 0;
      for (std::size_t i = 0; i < w.size(); ++i) left += dot(jv[i], w[i]);
      std::vector<double> jtw;
      synthesis.adjoint(w, jtw);
      for (std::size_t i = 0; i < v.size(); ++i) {
        right += v[i] * jtw[i];
        scale += std::abs(v[i] * jtw[i]);
      }
      INFO("open " << open << ", tension " << tension << ": " << left << " against " << right);
      CHECK(std::abs(left - right) <= 1e-12 * scale);
    }
  }
}

TEST_CASE("Synthesis gives the positions of the normal mesh, and the forward pass their derivative") {
  const NormalMesh mesh = interpolating_mesh({}, 4, 7);
  SynthesisOperator synthesis(mesh.hierarchy, unknown_layout(mesh, 4));
  std::vector<double> values = values_of(mesh, synthesis.layout());
  std::vector<Vec3> positions;
  synthesis.synthesize(values, positions);
  const std::vector<Vec3> expected = reconstruct(mesh, 4);
  double largest = 0;
  for (std::size_t i = 0; i < positions.size(); ++i)
    largest = std::max(largest, distance(positions[i], expected[i]));
  CHECK(largest <= 1e-14);

  // Changes of the finest level alone move no normal: the linear map is exact.
  std::vector<double> change(values.size(), 0.0);
  for (std::size_t i = synthesis.layout().normal_begin[3]; i < synthesis.layout().normal_begin[4]; ++i)
    change[i] = 1e-3 * static_cast<double>(i % 7);
  std::vector<Vec3> displacement, moved;
  synthesis.forward(change, displacement);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] += change[i];
  synthesis.positions_of(values, moved);
  largest = 0;
  for (std::size_t i = 0; i < positions.size(); ++i)
    largest = std::max(largest, distance(moved[i], positions[i] + displacement[i]));
  CHECK(largest <= 1e-14);
}

TEST_CASE("Analysis inverts synthesis, and its transpose is its transpose") {
  const NormalMesh mesh = interpolating_mesh({}, 4);
  SynthesisOperator synthesis(mesh.hierarchy, unknown_layout(mesh, 4));
  std::vector<Vec3> positions;
  synthesis.synthesize(values_of(mesh, synthesis.layout()), positions);
  const UnknownLayout& layout = synthesis.layout();
  FixedNumbers source;
  const std::vector<double> change = numbers(layout.count, source);
  std::vector<Vec3> displacement;
  synthesis.forward(change, displacement);
  std::vector<double> scalars(layout.count);
  for (std::size_t v = 0; v < layout.base_vertex_count; ++v)
    for (int k = 0; k < 3; ++k) scalars[3 * v + static_cast<std::size_t>(k)] = displacement[v][k];
  for (int l = 0; l < 4; ++l)
    for (std::size_t e = 0; e < mesh.hierarchy.level(l).edge_count; ++e)
      scalars[layout.normal(l, e)] =
          dot(synthesis.normal(l, e), displacement[mesh.hierarchy.level(l).vertex_count + e]);
  std::vector<double> back;
  synthesis.analyze(scalars, back);
  double largest = 0;
  for (std::size_t i = 0; i < change.size(); ++i) largest = std::max(largest, std::abs(back[i] - change[i]));
  CHECK(largest <= 1e-11);

  const std::vector<double> dual = numbers(layout.count, source);
  std::vector<double> transposed;
  synthesis.analyze_transposed(dual, transposed);
  double left = 0, right = 0, scale = 0;
  for (std::size_t i = 0; i < dual.size(); ++i) {
    left += dual[i] * back[i];
    right += transposed[i] * scalars[i];
    scale += std::abs(transposed[i] * scalars[i]);
  }
  INFO(left << " against " << right);
  CHECK(std::abs(left - right) <= 1e-12 * scale);
}

TEST_CASE(
    "The quadratic energy is the sum over the samples, and Galerkin matrices are its coarse curvature") {
  const BumpySphere surface;
  const NormalMesh mesh = interpolating_mesh(surface, 3);
  const std::vector<SurfaceSample> samples = radial_samples(surface, mesh);
  FitSystem system(mesh.hierarchy, unknown_layout(mesh, 3));
  std::vector<double> values = values_of(mesh, system.layout());
  std::vector<Vec3> positions;
  system.synthesis().synthesize(values, positions);
  system.set_samples(samples, positions, {});

  FixedNumbers source;
  std::vector<Vec3> moved = positions;
  for (Vec3& p : moved) p += 0.01 * Vec3{source.next(), source.next(), source.next()};
  double expected = 0;
  for (const SurfaceSample& s : samples) {
    const std::uint32_t* t = mesh.hierarchy.level(3).face_vertices.data() + std::size_t{3} * s.face;
    Vec3 r = -s.target;
    for (int k = 0; k < 3; ++k) r += static_cast<double>(s.barycentric[k]) * moved[t[k]];
    const double d = dot(r, s.normal);
    expected += 0.5 * s.weight * (0.98 * d * d + 0.02 * dot(r, r));
  }
  CHECK(system.energy().value(moved) == Approx(expected).epsilon(1e-6));

  for (int l = 0; l < 3; ++l) {
    const std::size_t unknown = system.layout().normal(l, 5);
    std::vector<double> unit(system.layout().count, 0.0), dual;
    unit[unknown] = 1;
    std::vector<Vec3> v, av;
    system.synthesis().forward(unit, v);
    system.energy().multiply(v, av);
    system.synthesis().adjoint(av, dual);
    const GalerkinMatrix& matrix = system.galerkin().matrix(l + 1);
    const std::size_t vertex_count = mesh.hierarchy.level(l).vertex_count;
    for (std::size_t k = matrix.row_begin[vertex_count + 5]; k < matrix.row_begin[vertex_count + 6]; ++k) {
      if (matrix.column[k] < vertex_count) continue;
      const std::size_t f = matrix.column[k] - vertex_count;
      const double entry =
          dot(system.synthesis().normal(l, f), matrix.block[k] * system.synthesis().normal(l, 5));
      INFO("level " << l << ", edge " << f);
      CHECK(entry == Approx(dual[system.layout().normal(l, f)]).margin(1e-6 * dual[unknown]));
    }
  }
}

}  // namespace nmc
