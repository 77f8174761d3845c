// SPDX-License-Identifier: Apache-2.0
#include "encoder/fit/global_fit.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/unit/fit/bumpy_sphere.h"

namespace nmc {

namespace {

double decibels(double rms) { return -20 * std::log10(rms); }

/// RMS over the samples that unconstrained finest vertices reach: conjugate gradients on the vertices
/// themselves.
double unconstrained_rms(const NormalMesh& mesh, const std::vector<SurfaceSample>& samples) {
  QuadraticEnergy energy(mesh.hierarchy.level(mesh.level_count()));
  std::vector<Vec3> x = reconstruct(mesh, mesh.level_count()), r, z, p, ap;
  energy.assemble(samples, x, {});
  energy.gradient(x, r);
  for (Vec3& v : r) v = -v;
  p = r;
  const auto inner = [](const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
    double s = 0;
    for (std::size_t i = 0; i < a.size(); ++i) s += dot(a[i], b[i]);
    return s;
  };
  double rr = inner(r, r);
  for (int it = 0; it < 300; ++it) {
    energy.multiply(p, ap);
    const double step = rr / inner(p, ap);
    for (std::size_t i = 0; i < x.size(); ++i) {
      x[i] += step * p[i];
      r[i] -= step * ap[i];
    }
    const double next = inner(r, r);
    for (std::size_t i = 0; i < x.size(); ++i) p[i] = r[i] + (next / rr) * p[i];
    rr = next;
  }
  return energy.root_mean_square(energy.value(x));
}

}  // namespace

TEST_CASE("One scalar per vertex comes within half a decibel of unconstrained vectors") {
  const BumpySphere surface;
  NormalMesh mesh = interpolating_mesh(surface, 5);
  std::vector<SurfaceSample> samples = radial_samples(surface, mesh);
  const double vectors = unconstrained_rms(mesh, samples);
  GlobalFitOptions options;
  options.minimize.maximum_outer = 8;
  const GlobalFitResult result = global_fit(options, nullptr, samples, mesh);
  INFO("interpolating " << decibels(result.initial_rms) << " dB, fit " << decibels(result.final_rms)
                        << " dB, unconstrained vectors " << decibels(vectors) << " dB");
  CHECK(decibels(result.final_rms) >= decibels(vectors) - 0.5);
  CHECK(decibels(result.final_rms) >= decibels(result.initial_rms) + 2);
}

TEST_CASE("The fit never raises the energy, and does not depend on the start") {
  const BumpySphere surface;
  const NormalMesh start = interpolating_mesh(surface, 4, 9);
  const std::vector<SurfaceSample> samples = radial_samples(surface, start);
  FitSystem system(start.hierarchy, unknown_layout(start, 4));
  std::vector<double> values = values_of(start, system.layout());
  std::vector<Vec3> positions;
  system.synthesis().positions_of(values, positions);
  system.set_samples(samples, positions, {});
  const std::vector<std::uint8_t> active = free_unknowns(start, system.layout(), true);
  MinimizeOptions options;
  options.maximum_outer = 12;
  options.maximum_inner = 200;
  options.inner_tolerance = 1e-3;
  options.outer_tolerance = 1e-7;
  std::vector<double> first = values;
  const MinimizeResult from_start = system.minimize(active, options, first);
  CHECK(from_start.final_energy <= from_start.initial_energy);

  FixedNumbers source;
  std::vector<double> second = values;
  for (double& v : second) v += 0.01 * source.next();
  const double disturbed = system.energy_of(second);
  const MinimizeResult from_disturbed = system.minimize(active, options, second);
  CHECK(from_disturbed.initial_energy == Approx(disturbed));
  CHECK(from_disturbed.final_energy < disturbed);
  INFO(from_start.final_energy << " against " << from_disturbed.final_energy);
  CHECK(from_disturbed.final_energy == Approx(from_start.final_energy).epsilon(0.02));

  MinimizeOptions once;
  once.maximum_outer = 1;
  double energy = disturbed;
  std::vector<double> third = values;
  FixedNumbers again;
  for (double& v : third) v += 0.01 * again.next();
  for (int i = 0; i < 5; ++i) {
    const double lower = system.minimize(active, once, third).final_energy;
    CHECK(lower <= energy);
    energy = lower;
  }
}

TEST_CASE("A subset of the unknowns leaves the others untouched") {
  const BumpySphere surface;
  const NormalMesh mesh = interpolating_mesh(surface, 4);
  const std::vector<SurfaceSample> samples = radial_samples(surface, mesh);
  FitSystem system(mesh.hierarchy, unknown_layout(mesh, 4));
  std::vector<double> values = values_of(mesh, system.layout());
  std::vector<Vec3> positions;
  system.synthesis().positions_of(values, positions);
  system.set_samples(samples, positions, {});
  std::vector<std::uint8_t> active(values.size(), 0);
  for (std::size_t i = 0; i < values.size(); i += 3) active[i] = 1;
  const std::vector<double> before = values;
  const MinimizeResult result = system.minimize(active, {}, values);
  CHECK(result.final_energy < result.initial_energy);
  std::size_t touched = 0;
  for (std::size_t i = 0; i < values.size(); ++i) touched += !active[i] && values[i] != before[i];
  CHECK(touched == 0);
}

TEST_CASE("Robust weights keep wrong correspondences from bending the surface") {
  const BumpySphere surface;
  const NormalMesh start = interpolating_mesh(surface, 4);
  const std::vector<SurfaceSample> clean = radial_samples(surface, start);
  std::vector<SurfaceSample> spoilt = clean;
  for (std::size_t i = 0; i < spoilt.size(); i += 500) spoilt[i].target = 0.5 * spoilt[i].target;
  const auto clean_rms = [&](double huber_multiple) {
    NormalMesh mesh = interpolating_mesh(surface, 4);
    std::vector<SurfaceSample> samples = spoilt;
    GlobalFitOptions options;
    options.energy.huber_multiple = huber_multiple;
    global_fit(options, nullptr, samples, mesh);
    QuadraticEnergy energy(mesh.hierarchy.level(4));
    const std::vector<Vec3> x = reconstruct(mesh, 4);
    energy.assemble(clean, x, {});
    return energy.root_mean_square(energy.value(x));
  };
  const double squared = clean_rms(0), robust = clean_rms(1);
  INFO("squares " << squared << ", Huber " << robust);
  CHECK(robust < 0.5 * squared);
}

TEST_CASE("Re-projection moves targets to the closest points and never away") {
  const BumpySphere surface;
  NormalMesh mesh = interpolating_mesh(surface, 4);
  std::vector<SurfaceSample> samples = radial_samples(surface, mesh);
  const TriangleMesh fine = fine_mesh(surface, 6);
  const SurfaceIndex index(fine);
  const std::vector<Vec3> normals = vertex_normals(fine);
  const std::vector<Vec3> x = reconstruct(mesh, 4);
  const LevelTopology& finest = mesh.hierarchy.level(4);
  const std::vector<SurfaceSample> before = samples;
  const ReprojectionResult result = reproject_samples({index, normals}, finest, x, {}, samples);
  CHECK(result.moved + result.kept == samples.size());
  CHECK(result.moved > samples.size() / 2);
  std::size_t farther = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const std::uint32_t* t = finest.face_vertices.data() + std::size_t{3} * samples[i].face;
    Vec3 y;
    for (int k = 0; k < 3; ++k) y += static_cast<double>(samples[i].barycentric[k]) * x[t[k]];
    farther += distance(y, samples[i].target) > distance(y, before[i].target) * (1 + 1e-6);
  }
  CHECK(farther == 0);
}

TEST_CASE("Samples keep their place when the level is split") {
  const BumpySphere surface;
  const NormalMesh mesh = interpolating_mesh(surface, 3);
  const std::vector<SurfaceSample> coarse = radial_samples(surface, mesh);
  const std::vector<SurfaceSample> fine = samples_on_next_level(coarse);
  const SubdivisionHierarchy hierarchy(octahedron_faces(), 6, 4);
  // Linear subdivision: a midpoint stands for every odd vertex.
  std::vector<Vec3> x = reconstruct(mesh, 3);
  const LevelTopology& level = hierarchy.level(3);
  for (std::uint32_t e = 0; e < level.edge_count; ++e)
    x.push_back(0.5 * (x[level.edge_vertices[2 * e]] + x[level.edge_vertices[2 * e + 1]]));
  const auto point = [&](const LevelTopology& t, const SurfaceSample& s) {
    Vec3 y;
    for (std::uint32_t k = 0; k < 3; ++k)
      y += static_cast<double>(s.barycentric[k]) * x[t.face_vertices[3 * s.face + k]];
    return y;
  };
  double largest = 0;
  for (std::size_t i = 0; i < coarse.size(); ++i)
    largest = std::max(largest, distance(point(level, coarse[i]), point(hierarchy.level(4), fine[i])));
  CHECK(largest <= 1e-6);
}

TEST_CASE("Points of the input that the surface does not reach pull on it") {
  const BumpySphere surface;
  NormalMesh mesh = interpolating_mesh(surface, 3);
  const TriangleMesh fine = fine_mesh(surface, 6);
  const SurfaceIndex index(fine);
  const std::vector<Vec3> normals = vertex_normals(fine);
  std::vector<Vec3> x = reconstruct(mesh, 3);
  // One vertex is pushed in by a fifth: the input above it is out of reach.
  x[40] = 0.8 * x[40];
  std::vector<SurfaceSample> samples;
  const std::size_t count =
      append_input_samples({index, normals}, mesh.hierarchy.level(3), x, 20000, 1.0, 0.05, samples);
  CHECK(count == samples.size());
  REQUIRE(count > 0);
  std::size_t elsewhere = 0;
  for (const SurfaceSample& s : samples) {
    bool touches = false;
    for (std::uint32_t k = 0; k < 3; ++k)
      touches |= mesh.hierarchy.level(3).face_vertices[3 * s.face + k] == 40;
    elsewhere += !touches;
  }
  CHECK(elsewhere == 0);
}

}  // namespace nmc
