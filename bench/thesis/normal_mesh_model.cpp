// SPDX-License-Identifier: Apache-2.0
#include "bench/thesis/normal_mesh_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "encoder/core/error.h"
#include "encoder/fit/global_fit.h"
#include "encoder/normal_mesh/sample_correspondences.h"
#include "encoder/normal_mesh/semi_regular_input.h"
#include "encoder/normal_mesh/unconstrained_vector_mesh.h"

namespace nmc_bench {

Model on_sphere(const std::string& name, TriangleMesh mesh, const SphereBaseOptions& base, int level_count,
                const SphereEnergyWeights& weights) {
  Model model;
  model.name = name;
  model.parameterization = "sphere";
  model.input = std::make_shared<TriangleMesh>(std::move(mesh));
  SphereOptions options;
  options.weights = weights;
  options.relative_decrease = 1e-5;
  auto surface = std::make_unique<SphereParameterizedSurface>(
      model.input, parameterize_sphere(*model.input, options).positions);
  model.base = sphere_base(*surface, base);
  model.surface = std::move(surface);
  model.level_count = level_count;
  return model;
}

Model on_domain(const std::string& name, TriangleMesh mesh, int base_size, int level_count) {
  Model model;
  model.name = name;
  model.parameterization = "domain";
  model.input = std::make_shared<TriangleMesh>(std::move(mesh));
  model.domain =
      std::make_shared<Parameterization>(std::move(parameterize(*model.input, {base_size}).front()));
  model.surface = std::make_unique<DomainParameterizedSurface>(*model.domain);
  model.base = base_of(*model.domain);
  model.level_count = level_count;
  return model;
}

Model on_own_base(const std::string& name, TriangleMesh mesh) {
  const auto hierarchy = recognize_subdivision_connectivity(mesh);
  if (!hierarchy || hierarchy->hierarchy.level_count() < 2)
    throw Error(ExitCode::kInvalidInput, name + " is not a base mesh with all triangles split twice or more");
  Model model;
  model.name = name;
  model.parameterization = "own base";
  model.domain = std::make_shared<Parameterization>(identity_parameterization(*hierarchy, mesh));
  model.input = std::make_shared<TriangleMesh>(std::move(mesh));
  model.surface = std::make_unique<DomainParameterizedSurface>(*model.domain);
  model.base = base_of(*model.domain);
  model.level_count = hierarchy->hierarchy.level_count() - 1;
  return model;
}

TriangleMesh plain_remesh(const Model& model, int level_count) {
  const SubdivisionHierarchy hierarchy(model.base.faces,
                                       static_cast<std::uint32_t>(model.base.positions.size()), level_count);
  return mesh_of(
      hierarchy, level_count,
      sample_surface(*model.surface, midpoint_parameters(*model.surface, hierarchy, model.base.parameters)));
}

TriangleMesh zone_sphere(int subdivisions) {
  TriangleMesh mesh = regular_polyhedron(SphereBaseKind::kIcosahedron);
  const SubdivisionHierarchy hierarchy(mesh.triangles, 12, subdivisions);
  std::vector<Vec3> positions = mesh.positions;
  for (int l = 0; l < subdivisions; ++l) {
    const LevelTopology& topology = hierarchy.level(l);
    for (std::uint32_t e = 0; e < topology.edge_count; ++e)
      positions.push_back(normalized(positions[topology.edge_vertices[2 * e]] +
                                     positions[topology.edge_vertices[2 * e + 1]]));
  }
  for (Vec3& p : positions) {
    const double longitude = std::atan2(p.y, p.x) + std::numbers::pi;  // 0 ... 2 pi
    const double equator = std::exp(-std::pow(p.z / 0.45, 4));
    p = p * (1 + 0.02 * equator * std::sin(4 * longitude * longitude));
  }
  mesh.positions = std::move(positions);
  mesh.triangles = level_triangles(hierarchy.level(subdivisions));
  return mesh;
}

TriangleMesh mesh_of(const SubdivisionHierarchy& hierarchy, int level, const std::vector<Vec3>& positions) {
  TriangleMesh mesh;
  mesh.positions.assign(positions.begin(), positions.begin() + hierarchy.level(level).vertex_count);
  mesh.triangles = level_triangles(hierarchy.level(level));
  return mesh;
}

CompareResult compared(const Model& model, const SurfaceIndex& index, const TriangleMesh& mesh) {
  CompareOptions options;
  options.sample_count = 100000;
  options.normals = false;
  options.vertices = false;
  options.original_index = &index;
  return compare_meshes(*model.input, mesh, options);
}

InterpolatingOptions thesis_options(int level_count, ApertureRule rule) {
  InterpolatingOptions options;
  options.level_count = level_count;
  options.aperture_rule = rule;
  if (rule == ApertureRule::kParametric) {
    options.coarse_aperture = options.fine_aperture = 0.2;
    options.parameter_prediction = ParameterPrediction::kMidpoint;
  }
  return options;
}

VariationalOptions thesis_options(const InterpolatingOptions& interpolating) {
  VariationalOptions options;
  options.interpolating = interpolating;
  options.fit_base = false;
  return options;
}

TriangleMesh fitted(const Model& model, const SurfaceIndex& index, InterpolatingOptions options, int level) {
  options.level_count = level;
  InterpolatingResult inm = interpolate(*model.surface, index, model.base, options);
  // Coarse triangles need many samples to see what lies under them, 30 to 150 in the thesis; fine ones few.
  constexpr double kSamples = 5e5;
  SamplingOptions sampling;
  sampling.subdivisions =
      std::clamp(static_cast<int>(std::sqrt(kSamples / inm.mesh.hierarchy.level(level).face_count)), 3, 12);
  std::vector<SurfaceSample> samples = sample_correspondences(
      *model.surface, index, inm.mesh.hierarchy.level(level), level, inm.positions, inm.parameters, sampling);
  const std::vector<Vec3> normals = vertex_normals(model.surface->surface());
  const InputSurface input{index, normals};
  GlobalFitOptions fit;
  fit.coded_level_count = level;
  global_fit(fit, &input, samples, inm.mesh);
  return mesh_of(inm.mesh.hierarchy, level, reconstruct(inm.mesh, level));
}

}  // namespace nmc_bench
