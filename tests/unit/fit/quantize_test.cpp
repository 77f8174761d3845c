// SPDX-License-Identifier: Apache-2.0
#include "encoder/fit/quantize.h"

#include <oneapi/tbb/global_control.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "encoder/fit/context_rate_model.h"
#include "encoder/fit/coordinate_descent.h"
#include "encoder/fit/quality_layers.h"
#include "tests/unit/fit/bumpy_sphere.h"

namespace nmc {

namespace {

struct Fitted {
  explicit Fitted(int levels = 5)
      : mesh(interpolating_mesh(surface, levels, 11)), samples(radial_samples(surface, mesh)) {
    global_fit({}, nullptr, samples, mesh);
  }
  double rms_of(const QuantizedMesh& quantized) const {
    const int level = mesh.level_count();
    QuadraticEnergy energy(mesh.hierarchy.level(level));
    const std::vector<Vec3> x = reconstruct(quantized, mesh.hierarchy, level);
    energy.assemble(samples, x, {});
    return energy.root_mean_square(energy.value(x));
  }
  BumpySphere surface;
  NormalMesh mesh;
  std::vector<SurfaceSample> samples;
};

double bits_of(const QuantizedMesh& mesh, const SubdivisionHierarchy& hierarchy) {
  CoefficientField field(hierarchy, mesh.level_count());
  for (int l = 0; l < mesh.level_count(); ++l)
    for (std::size_t e = 0; e < mesh.normal[static_cast<std::size_t>(l)].size(); ++e)
      field.values[hierarchy.level(l).vertex_count + e] = mesh.normal[static_cast<std::size_t>(l)][e];
  ContextRateModel rates(hierarchy, mesh.level_count());
  rates.learn(field);
  return rates.total_bits();
}

}  // namespace

TEST_CASE("Finer steps give smaller errors and more bits") {
  const Fitted fitted;
  MeshQuantizer quantizer(fitted.mesh, 5, fitted.samples, nullptr);
  double previous_rms = 1, previous_bits = 0;
  for (const double step : {2e-2, 5e-3, 1e-3}) {
    QuantizeOptions options;
    options.normal_step = step;
    QuantizeReport report;
    const QuantizedMesh mesh = quantizer.quantize(options, &report);
    const double rms = fitted.rms_of(mesh);
    INFO("step " << step << ": rms " << rms << ", bits " << report.model_bits);
    CHECK(rms == Approx(report.final_rms).epsilon(1e-3));
    CHECK(rms < previous_rms);
    CHECK(report.model_bits > previous_bits);
    CHECK(bits_of(mesh, fitted.mesh.hierarchy) == Approx(report.model_bits));
    previous_rms = rms;
    previous_bits = report.model_bits;
  }
}

TEST_CASE("Quantizing is a function of its arguments") {
  const Fitted fitted(4);
  MeshQuantizer quantizer(fitted.mesh, 4, fitted.samples, nullptr);
  QuantizeOptions options;
  options.normal_step = 5e-3;
  const QuantizedMesh first = quantizer.quantize(options);
  options.normal_step = 1e-3;
  quantizer.quantize(options);
  options.normal_step = 5e-3;
  const QuantizedMesh second = quantizer.quantize(options);
  CHECK(first.normal == second.normal);
  CHECK(first.base_coordinates == second.base_coordinates);
}

TEST_CASE("The first call keeps the tangential parts that later calls keep") {
  Fitted fitted(4);
  constexpr std::uint32_t kEdge = 5;
  fitted.mesh.details[1][kEdge].along += 0.25;
  // The mesh with its sideways peak is the surface itself: its own points are the targets.
  const int finest = fitted.mesh.level_count();
  const LevelTopology& topology = fitted.mesh.hierarchy.level(finest);
  const std::vector<Vec3> x = reconstruct(fitted.mesh, finest);
  for (SurfaceSample& sample : fitted.samples) {
    const std::uint32_t* corners = topology.face_vertices.data() + std::size_t{3} * sample.face;
    sample.target = {};
    for (int k = 0; k < 3; ++k) sample.target += static_cast<double>(sample.barycentric[k]) * x[corners[k]];
    sample.normal = normalized(cross(x[corners[1]] - x[corners[0]], x[corners[2]] - x[corners[0]]));
  }
  MeshQuantizer quantizer(fitted.mesh, 4, fitted.samples, nullptr);
  QuantizeOptions options;
  options.normal_step = 5e-3;
  const QuantizedMesh first = quantizer.quantize(options);
  const QuantizedMesh second = quantizer.quantize(options);
  REQUIRE(first.tangential[1].size() == 1);
  REQUIRE(second.tangential[1].size() == 1);
  CHECK(first.tangential[1][0].edge == kEdge);
  CHECK(first.tangential[1][0].along == second.tangential[1][0].along);
  CHECK(first.normal == second.normal);
  CHECK(fitted.rms_of(first) < 5e-3);
}

TEST_CASE("Rate-distortion descent lowers the cost that it is asked to lower") {
  const Fitted fitted;
  MeshQuantizer quantizer(fitted.mesh, 5, fitted.samples, nullptr);
  QuantizeOptions options;
  options.normal_step = 5e-3;
  options.descent_rounds = 0;
  const QuantizedMesh rounded = quantizer.quantize(options);
  options.descent_rounds = 3;
  const QuantizedMesh descended = quantizer.quantize(options);
  // lambda of the options, written out: the cost of one bit in units of the mean square.
  FitSystem system(fitted.mesh.hierarchy, unknown_layout(fitted.mesh, 5));
  const std::vector<Vec3> x = reconstruct(rounded, fitted.mesh.hierarchy, 5);
  system.set_samples(fitted.samples, x, {});
  double curvature = 0;
  const LevelTopology& finest = fitted.mesh.hierarchy.level(4);
  for (std::size_t e = 0; e < finest.edge_count; ++e) {
    const SymmetricMatrix3& block = system.galerkin().diagonal(5, finest.vertex_count + e);
    curvature += (double{block.xx} + block.yy + block.zz) / finest.edge_count;
  }
  const double lambda = options.lambda_factor * 0.5 * curvature * options.normal_step * options.normal_step;
  const auto cost = [&](const QuantizedMesh& mesh) {
    return system.energy().value(reconstruct(mesh, fitted.mesh.hierarchy, 5)) +
           lambda * bits_of(mesh, fitted.mesh.hierarchy);
  };
  INFO("rounded " << cost(rounded) << ", descended " << cost(descended));
  CHECK(cost(descended) < cost(rounded));
}

TEST_CASE("The rate model's differences are those of its totals") {
  const SubdivisionHierarchy hierarchy(octahedron_faces(), 6, 4);
  FixedNumbers source;
  for (const int layers : {0, 1, 2, 3}) {
    const bool refined = (layers & 1) != 0, followed = (layers & 2) != 0;
    CoefficientField field(hierarchy, 4);
    for (std::size_t v = 6; v < field.values.size(); ++v)
      field.values[v] = static_cast<std::int32_t>(std::lround(3 * std::pow(source.next(), 5)));
    std::vector<std::int32_t> previous(field.values.size());
    for (std::size_t v = 6; v < previous.size(); ++v)
      previous[v] = 3 * static_cast<std::int32_t>(source.next() * 1.5);
    std::vector<std::int32_t> next;
    if (followed) {
      next = field.values;
      for (std::size_t v = 6; v < next.size(); ++v)
        next[v] = 3 * next[v] + static_cast<std::int32_t>(std::lround(2 * source.next()));
    }
    ContextRateModel rates(hierarchy, 4, refined ? &previous : nullptr, next, 3);
    rates.learn(field);
    for (int trial = 0; trial < 200; ++trial) {
      const int level = trial % 4;
      const auto edge =
          static_cast<std::size_t>((source.next() + 1) / 2 * (hierarchy.level(level).edge_count - 1));
      const std::int32_t candidates[2] = {field.at(level, edge), field.at(level, edge) == 0 ? 1 : 0};
      double bits[2];
      rates.costs(level, edge, candidates, 2, bits);
      const double before = rates.total_bits();
      rates.set(level, edge, candidates[1]);
      const double after = rates.total_bits();
      INFO("level " << level << ", edge " << edge);
      REQUIRE(after - before == Approx(bits[1] - bits[0]).margin(1e-3));
      rates.set(level, edge, candidates[0]);
    }
  }
}

TEST_CASE("Layers refine: steps divide, errors fall, differences cost less than a fresh start") {
  const Fitted fitted;
  MeshQuantizer quantizer(fitted.mesh, 5, fitted.samples, nullptr);
  LayerOptions options;
  options.finest.normal_step = 1e-3;
  options.layer_count = 3;
  options.ratio = 3;
  std::vector<QuantizeReport> reports;
  const std::vector<QuantizedMesh> layers = quantize_layers(options, quantizer, &reports);
  REQUIRE(layers.size() == 3);
  for (std::size_t k = 1; k < 3; ++k) {
    CHECK(layers[k].quantizers[2].normal_step == Approx(layers[k - 1].quantizers[2].normal_step / 3));
    CHECK(layers[k].base_step == Approx(layers[k - 1].base_step / 3));
    CHECK(fitted.rms_of(layers[k]) < fitted.rms_of(layers[k - 1]));
  }
  for (std::size_t k = 0; k < 2; ++k)
    for (std::size_t v = 0; v < 6; ++v)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        // Only the last layer's base may be moved again when it is polished, and hardly ever is.
        const int correction =
            layers[k + 1].base_coordinates[v][axis] - 3 * layers[k].base_coordinates[v][axis];
        CHECK(std::abs(correction) <= (k == 0 ? 1 : 3));
      }
  const QuantizedMesh single = quantizer.quantize(options.finest);
  const double fresh = bits_of(single, fitted.mesh.hierarchy);
  INFO("last layer " << reports[2].model_bits << " bits, fresh " << fresh);
  CHECK(reports[2].model_bits < fresh);
  const double loss = 20 * std::log10(fitted.rms_of(layers[2]) / fitted.rms_of(single));
  INFO("loss " << loss << " dB");
  CHECK(loss < 0.5);
}

TEST_CASE(
    "A boundary is quantized with its tangential coefficients and decodes to the same bits in any range") {
  std::vector<Triangle> faces = octahedron_faces();
  faces.pop_back();
  const BumpySphere surface;
  NormalMesh mesh = interpolating_mesh(surface, 4, 0, faces);
  std::vector<SurfaceSample> samples = radial_samples(surface, mesh);
  global_fit({}, nullptr, samples, mesh);
  MeshQuantizer quantizer(mesh, 4, samples, nullptr);
  QuantizeOptions options;
  options.normal_step = 2e-3;
  const QuantizedMesh quantized = quantizer.quantize(options);
  std::size_t curve_count = 0;
  for (int l = 0; l < 4; ++l)
    for (const TangentialCoefficient& t : quantized.tangential[static_cast<std::size_t>(l)]) {
      REQUIRE(mesh.hierarchy.level(l).is_curve(t.edge));
      CHECK(t.along == 0);
      ++curve_count;
    }
  CHECK(curve_count > 0);
  const std::vector<Vec3> all = reconstruct(quantized, mesh.hierarchy, 4);
  std::vector<Vec3> whole = reconstruct(quantized, mesh.hierarchy, 3);
  whole.resize(all.size());
  LevelCoefficients coefficients;
  REQUIRE(coefficients.normal.resize(quantized.normal[3].size()));
  REQUIRE(coefficients.tangential.resize(quantized.tangential[3].size()));
  std::copy(quantized.normal[3].begin(), quantized.normal[3].end(), coefficients.normal.data());
  std::copy(quantized.tangential[3].begin(), quantized.tangential[3].end(), coefficients.tangential.data());
  const LevelTopology& level = mesh.hierarchy.level(3);
  reconstruct_odd_vertices(level, mesh.hierarchy.ring_weights(), quantized.quantizers[3], &coefficients, 0,
                           level.edge_count, whole.data());
  CHECK(all == whole);
}

TEST_CASE("Smoothing levels carry no coefficients, and a mesh without levels quantizes its base") {
  const BumpySphere surface;
  for (const int coded : {0, 3}) {
    const NormalMesh mesh = interpolating_mesh(surface, 4);
    MeshQuantizer quantizer(mesh, coded, radial_samples(surface, mesh), nullptr);
    QuantizeOptions options;
    options.normal_step = 1e-3;
    QuantizeReport report;
    const QuantizedMesh quantized = quantizer.quantize(options, &report);
    CHECK(quantized.level_count() == coded);
    CHECK(quantized.smoothing_level_count == 4 - coded);
    CHECK(quantized.base_coordinates.size() == 6);
    CHECK(report.final_rms < (coded == 0 ? 0.5 : 0.02));
    CHECK(reconstruct(quantized, mesh.hierarchy, 4).size() == mesh.hierarchy.level(4).vertex_count);
  }
}

TEST_CASE("One thread and many give the same integers") {
  const auto quantize_with = [](std::size_t thread_count) {
    const oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism,
                                            thread_count);
    const BumpySphere surface;
    NormalMesh mesh = interpolating_mesh(surface, 4, 13);
    std::vector<SurfaceSample> samples = radial_samples(surface, mesh);
    const TriangleMesh fine = fine_mesh(surface, 5);
    const SurfaceIndex index(fine);
    const std::vector<Vec3> normals = vertex_normals(fine);
    const InputSurface input{index, normals};
    global_fit({}, &input, samples, mesh);
    MeshQuantizer quantizer(mesh, 4, samples, &input);
    QuantizeOptions options;
    options.normal_step = 2e-3;
    return quantizer.quantize(options);
  };
  const QuantizedMesh one = quantize_with(1), many = quantize_with(4);
  CHECK(one.normal == many.normal);
  CHECK(one.base_coordinates == many.base_coordinates);
}

}  // namespace nmc
