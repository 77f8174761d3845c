// SPDX-License-Identifier: Apache-2.0
#include "encoder/pipeline/candidate.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "encoder/fit/quality_layers.h"
#include "encoder/measure/compare_meshes.h"
#include "encoder/normal_mesh/closest_samples.h"
#include "encoder/normal_mesh/sample_correspondences.h"
#include "encoder/pipeline/maximum_repair.h"
#include "encoder/pipeline/renumber.h"

namespace nmc {

struct Candidate::State {
  std::shared_ptr<const Parameterization> parameterization;
  const ReferenceSurface* reference = nullptr;
  CandidateOptions options;
  CandidateStatistics statistics;
  std::unique_ptr<SurfaceIndex> index;      // of the parameterized surface
  std::vector<Vec3> vertex_normals;         // of it
  std::unique_ptr<InputSurface> input;
  std::vector<std::uint8_t> base_creases;
  NormalMesh mesh;                          // in stream order, fitted
  std::unique_ptr<MeshQuantizer> quantizer;
};

Candidate::Candidate(std::shared_ptr<const Parameterization> parameterization, const ReferenceSurface& reference,
                     const CandidateOptions& options, const Progress& progress)
    : Candidate(DomainParameterizedSurface(*parameterization), base_of(*parameterization), reference, options,
                progress) {
  state_->parameterization = std::move(parameterization);
}

Candidate::Candidate(const ParameterizedSurface& surface, const ParameterizedBase& base,
                     const ReferenceSurface& reference, const CandidateOptions& options, const Progress& progress)
    : state_(std::make_unique<State>()) {
  State& state = *state_;
  state.reference = &reference;
  state.options = options;

  report(progress, "normal mesh", 0);
  state.index = std::make_unique<SurfaceIndex>(surface.surface());
  state.vertex_normals = vertex_normals(surface.surface());
  state.input = std::make_unique<InputSurface>(InputSurface{*state.index, state.vertex_normals, false});
  InterpolatingOptions interpolating;
  interpolating.level_count = options.coded_level_count;
  interpolating.tension = options.tension;
  InterpolatingResult interpolated = interpolate(surface, *state.index, base, interpolating);
  for (const LevelStatistics& level : interpolated.levels) {
    state.statistics.odd_vertex_count += level.vertex_count;
    state.statistics.non_normal_count += level.non_normal_count;
  }

  report(progress, "normal mesh", 0.5);
  SamplingOptions sampling;
  sampling.subdivisions = options.samples_per_face_side;
  // Nine samples per face serve one unknown per two faces; on large meshes four do, at half the memory.
  constexpr std::size_t kManySamples = 1'500'000;
  const std::size_t face_count = interpolated.mesh.hierarchy.level(options.coded_level_count).face_count;
  if (face_count * static_cast<std::size_t>(sampling.subdivisions * sampling.subdivisions) > kManySamples)
    sampling.subdivisions = std::min(sampling.subdivisions, 2);
  SampleStatistics sampled;
  std::vector<SurfaceSample> samples = sample_correspondences(
      surface, *state.index, interpolated.mesh.hierarchy.level(options.coded_level_count), options.coded_level_count,
      interpolated.positions, interpolated.parameters, sampling, &sampled);
  state.statistics.replaced_samples = sampled.replaced;
  state.statistics.doubtful_samples = sampled.doubtful;

  fit(interpolated.mesh, std::move(samples), progress);
}

Candidate::Candidate(const TriangleMesh& base, const TriangleMesh& surface, const ReferenceSurface& reference,
                     const CandidateOptions& options, const Progress& progress)
    : state_(std::make_unique<State>()) {
  State& state = *state_;
  state.reference = &reference;
  state.options = options;
  state.index = std::make_unique<SurfaceIndex>(surface);
  state.vertex_normals = vertex_normals(surface);
  state.input = std::make_unique<InputSurface>(InputSurface{*state.index, state.vertex_normals, true});
  NormalMesh mesh;
  mesh.base_positions = base.positions;
  mesh.hierarchy = SubdivisionHierarchy(base.triangles, static_cast<std::uint32_t>(base.vertex_count()),
                                        options.coded_level_count);
  mesh.tension.assign(static_cast<std::size_t>(options.coded_level_count), options.tension);
  for (int l = 0; l < options.coded_level_count; ++l) {
    const std::size_t edge_count = mesh.hierarchy.level(l).edge_count;
    mesh.details.emplace_back(edge_count);
    mesh.non_normal.emplace_back(edge_count, std::uint8_t{0});
    state.statistics.odd_vertex_count += mesh.hierarchy.level(l).edge_count;
  }
  constexpr std::size_t kSamples = 80000;
  std::vector<SurfaceSample> samples =
      closest_samples(*state.index, mesh.hierarchy.level(options.coded_level_count),
                      nmc::reconstruct(mesh, options.coded_level_count), kSamples);
  fit(mesh, std::move(samples), progress);
}

void Candidate::fit(const NormalMesh& mesh, std::vector<SurfaceSample> samples, const Progress& progress) {
  State& state = *state_;
  const CandidateOptions& options = state.options;
  const StreamOrder order = stream_order(mesh.hierarchy);
  state.base_creases = order.base_creases;
  state.mesh = renumber(mesh, order, samples);
  state.statistics.base_vertex_count = state.mesh.hierarchy.level(0).vertex_count;
  state.statistics.base_face_count = state.mesh.hierarchy.level(0).face_count;
  for (int i = 0; i < options.smoothing_level_count; ++i) {
    state.mesh.hierarchy.refine_to(state.mesh.hierarchy.level_count() + 1);
    samples = samples_on_next_level(samples);
  }

  report(progress, "fit", 0);
  GlobalFitOptions fit_options;
  fit_options.coded_level_count = options.coded_level_count;
  fit_options.reprojection_count = options.reprojection_count;
  state.statistics.fit = global_fit(fit_options, state.input.get(), samples, state.mesh);
  state.quantizer = std::make_unique<MeshQuantizer>(state.mesh, options.coded_level_count, std::move(samples),
                                                    state.input.get());
  report(progress, "fit", 1);
}

Candidate::~Candidate() = default;

const CandidateStatistics& Candidate::statistics() const { return state_->statistics; }
int Candidate::coded_level_count() const { return state_->options.coded_level_count; }
const SubdivisionHierarchy& Candidate::hierarchy() const { return state_->mesh.hierarchy; }
const ReferenceSurface& Candidate::reference() const { return *state_->reference; }
const NormalMesh& Candidate::fitted_mesh() const { return state_->mesh; }
const std::vector<std::uint8_t>& Candidate::base_creases() const { return state_->base_creases; }

MeasuredError Candidate::measure(const std::vector<Vec3>& positions, int level, std::size_t sample_count) const {
  TriangleMesh result;
  result.positions = positions;
  result.triangles = level_triangles(hierarchy().level(level));
  CompareOptions options;
  options.normals = false;
  options.colors = false;
  options.sample_count = sample_count;
  options.original_index = state_->reference->index.get();
  const CompareResult compared = compare_meshes(state_->reference->mesh, result, options);
  return {compared.rms, compared.maximum};
}

std::vector<Vec3> Candidate::fitted_positions() const {
  const int coded = state_->options.coded_level_count, shown = hierarchy().level_count();
  std::vector<Vec3> positions = reconstruct(state_->mesh, coded);
  for (int l = coded; l < shown; ++l) {
    const LevelTopology& topology = hierarchy().level(l);
    positions.resize(std::size_t{topology.vertex_count} + topology.edge_count);
    reconstruct_odd_vertices(topology, hierarchy().ring_weights(), {}, nullptr, 0, topology.edge_count,
                             positions.data());
  }
  return positions;
}

MeasuredError Candidate::fitted_error() const { return measure(fitted_positions(), hierarchy().level_count(), 0); }

bool Candidate::is_out_of_reach(double tolerance) const {
  const std::vector<Vec3> positions = fitted_positions();
  const std::size_t beyond = count_beyond(*state_->reference->index, positions,
                                          level_triangles(hierarchy().level(hierarchy().level_count())), tolerance);
  return static_cast<double>(beyond) > MaximumRepairOptions{}.largest_share * static_cast<double>(positions.size());
}

QuantizeOptions quantize_options(const StreamSteps& steps, int coded_level_count, const StreamDescription& description,
                                 const Vec3& center, const TrialOptions& options) {
  QuantizeOptions quantize;
  quantize.normal_step = steps.normal_step(coded_level_count - 1);
  quantize.step_ratio = std::exp2(options.eighths_per_level / 8.0);
  quantize.tangential_ratio = std::exp2(options.eighths_tangential / 8.0);
  quantize.base_step_factor = std::exp2((options.eighths_per_level - options.eighths_base_to_level_0) / 8.0);
  quantize.base_origin = stream_origin(steps, description.box.minimum).position(steps) - center;
  quantize.lambda_factor = options.lambda_factor;
  return quantize;
}

Trial Candidate::quantize(double normal_step, const StreamDescription& description, const TrialOptions& options) {
  Trial trial;
  const int layer_count = options.quality_layer_count;
  trial.steps = stream_steps(normal_step, state_->options.coded_level_count, options.eighths_per_level,
                             options.eighths_base_to_level_0, options.eighths_tangential);
  trial.layer_ratio = layer_count > 1 ? options.layer_ratio : 1;
  QuantizeOptions quantize = quantize_options(trial.steps, state_->options.coded_level_count, description,
                                              state_->reference->center, options);
  quantize.keep_correspondences = options.keep_correspondences && layer_count == 1;
  trial.normal_step = quantize.normal_step;
  if (layer_count > 1) {
    LayerOptions layers;
    layers.finest = quantize;
    layers.layer_count = layer_count;
    layers.ratio = options.layer_ratio;
    trial.coarser_layers = quantize_layers(layers, *state_->quantizer);
    trial.mesh = std::move(trial.coarser_layers.back());
    trial.coarser_layers.pop_back();
  } else {
    trial.mesh = state_->quantizer->quantize(quantize);
  }
  assess(description, options, trial);
  return trial;
}

void Candidate::assess(const StreamDescription& description, const TrialOptions& options, Trial& trial) const {
  trial.byte_count = code(trial, description, {}).bytes.size();
  const int level = hierarchy().level_count();
  trial.error = measure(reconstruct(trial.mesh, hierarchy(), level), level,
                        static_cast<std::size_t>(options.measure_sample_count));
}

MeasuredError Candidate::measured_error(const Trial& trial) const {
  const int level = hierarchy().level_count();
  return measure(reconstruct(trial.mesh, hierarchy(), level), level, 0);
}

std::size_t Candidate::repair(const MaximumRepairOptions& repair, const StreamDescription& description,
                              const TrialOptions& options, Trial& trial) const {
  const MaximumRepairResult result = repair_maximum(*state_->reference->index, hierarchy(), repair, trial.mesh);
  assess(description, options, trial);
  return result.initial_beyond;
}

StreamBytes Candidate::finish(const Trial& trial, const StreamDescription& description,
                              const ColorStream* colors) {
  const auto measure_level = [&](const std::vector<Vec3>& decoded, int level) {
    std::vector<Vec3> positions = decoded;
    for (Vec3& p : positions) p -= state_->reference->center;
    return measure(positions, level, 0);
  };
  return code(trial, description, measure_level, colors);
}

StreamBytes Candidate::code(const Trial& trial, const StreamDescription& description,
                            const MeasureLevel& measure_level, const ColorStream* colors) const {
  std::vector<const QuantizedMesh*> layers;
  for (const QuantizedMesh& layer : trial.coarser_layers) layers.push_back(&layer);
  layers.push_back(&trial.mesh);
  return serialize(layers, trial.layer_ratio, hierarchy(), base_creases(), trial.steps, description, measure_level,
                   colors);
}

}  // namespace nmc
