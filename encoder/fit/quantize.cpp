// SPDX-License-Identifier: Apache-2.0
#include "encoder/fit/quantize.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "encoder/core/parallel.h"
#include "encoder/fit/context_rate_model.h"
#include "encoder/fit/coordinate_descent.h"

namespace nmc {

/// Of the RMS distance: samples farther off weigh more once the integers are being chosen.
constexpr double kSpikeMultiple = 3;

struct MeshQuantizer::State {
  State(const NormalMesh& mesh_of, int coded_level_count, std::vector<SurfaceSample> samples_of,
        const InputSurface* input_of, const QuadraticEnergyOptions& energy_options_of)
      : mesh(mesh_of),
        samples(std::move(samples_of)),
        input(input_of),
        energy_options(energy_options_of),
        system(mesh_of.hierarchy, unknown_layout(mesh_of, coded_level_count), mesh_of.tension),
        fitted_values(values_of(mesh_of, system.layout())) {
    std::vector<Vec3> positions;
    system.synthesis().positions_of(fitted_values, positions);
    system.set_samples(samples, positions, energy_options);
    total_weight = system.energy().total_weight();
    system.galerkin();
  }

  /// Back to the correspondences of the fit, and to the frames of its mesh: a coefficient is judged by where
  /// it points.
  void restart(bool keep_correspondences) {
    std::vector<Vec3> positions;
    system.synthesis().synthesize(fitted_values, positions);
    if (at_start || keep_correspondences) return;
    system.set_samples(samples, positions, energy_options);
    moved_samples = {};
    at_start = true;
  }

  /// Brings the correspondences to where the surface of `values` now is; without an input they stay.
  void follow(const std::vector<double>& values, double reach_multiple) {
    if (!input) return;
    const LevelTopology& finest = mesh.hierarchy.level(mesh.hierarchy.level_count());
    std::vector<Vec3> positions;
    system.synthesis().positions_of(values, positions);
    if (moved_samples.empty()) moved_samples = samples;
    moved_samples.resize(samples.size());
    const double rms = system.energy().root_mean_square(system.energy().value(positions));
    reproject_samples(*input, finest, positions, {}, moved_samples);
    if (reach_multiple > 0) {
      append_input_samples(*input, finest, positions, moved_samples.size() / 8, total_weight,
                           reach_multiple * rms, moved_samples);
    }
    QuadraticEnergyOptions weighted = energy_options;
    weighted.spike_distance = kSpikeMultiple * rms;
    system.set_samples(moved_samples, positions, weighted);
    at_start = false;
  }

  const NormalMesh& mesh;
  const std::vector<SurfaceSample> samples;
  std::vector<SurfaceSample> moved_samples;  // where the correspondences have gone; empty at the start
  bool at_start = true;
  double total_weight = 0;  // of the samples of the fit
  const InputSurface* input;
  QuadraticEnergyOptions energy_options;
  FitSystem system;
  std::vector<double> fitted_values;
};

MeshQuantizer::MeshQuantizer(const NormalMesh& mesh, int coded_level_count,
                             std::vector<SurfaceSample> samples, const InputSurface* input,
                             const QuadraticEnergyOptions& energy)
    : state_(std::make_unique<State>(mesh, coded_level_count, std::move(samples), input, energy)) {}

MeshQuantizer::~MeshQuantizer() = default;

const SubdivisionHierarchy& MeshQuantizer::hierarchy() const { return state_->mesh.hierarchy; }

namespace {

/// The quality layers before and after the one at hand, with `ratio` between the steps of neighbours; either
/// may be null.
struct LayerNeighbours {
  const QuantizedMesh* coarser = nullptr;
  const QuantizedMesh* finer = nullptr;
  int ratio = 1;
};

/// One run of the quantizer: the values of all unknowns on their way to integers.
class Quantization {
 public:
  Quantization(const QuantizeOptions& options, const SubdivisionHierarchy& hierarchy, FitSystem& system,
               std::vector<double> values, std::vector<std::uint8_t> active, const LayerNeighbours& layers)
      : options_(options),
        hierarchy_(hierarchy),
        system_(system),
        layout_(system.layout()),
        values_(std::move(values)),
        active_(std::move(active)),
        coarser_values_(vertex_values(hierarchy, layers.coarser, layers.ratio)),
        coarser_coordinates_(scaled_coordinates(layers)),
        base_is_held_(layers.finer != nullptr),
        field_(hierarchy, layout_.coded_level_count),
        rates_(hierarchy, layout_.coded_level_count, layers.coarser ? &coarser_values_ : nullptr,
               vertex_values(hierarchy, layers.finer, 1), layers.ratio) {
    // What may never move (along a boundary) is not coded either.
    for (std::size_t i = layout_.tangential_begin.front(); i < layout_.count; ++i)
      if (!active_[i]) values_[i] = 0;
    // The odd vertices of the finest coded level; without any level, the base vertices. The trace counts the
    // plane residual once.
    const int coded = layout_.coded_level_count;
    const std::size_t first = coded > 0 ? hierarchy.level(coded - 1).vertex_count : 0;
    const std::size_t last = hierarchy.level(coded).vertex_count;
    double curvature = 0;
    for (std::size_t v = first; v < last; ++v) {
      const SymmetricMatrix3& block = system.galerkin().diagonal(coded, v);
      curvature += double{block.xx} + block.yy + block.zz;
    }
    curvature /= static_cast<double>(last - first);
    lambda_ = options.lambda_factor * 0.5 * curvature * options.normal_step * options.normal_step;
  }

  double step(int level) const {
    return options_.normal_step * std::pow(options_.step_ratio, level - (layout_.coded_level_count - 1));
  }
  double tangential_step(int level) const { return options_.tangential_ratio * step(level); }
  double base_step() const { return step(-1) * options_.base_step_factor; }

  /// Small coefficients become zero and leave the system.
  void shrink(double threshold) {
    for (int l = 0; l < layout_.coded_level_count; ++l) {
      const auto level = static_cast<std::size_t>(l);
      const double limit = threshold * step(l);
      const std::size_t begin = layout_.normal_begin[level];
      for (std::size_t i = begin; i < layout_.normal_begin[level + 1]; ++i) {
        if (!active_[i] || std::abs(values_[i]) >= limit) continue;
        values_[i] = 0;
        active_[i] = 0;
      }
      const double tangential_limit = threshold * tangential_step(l);
      const LevelTopology& topology = hierarchy_.level(l);
      for (std::size_t k = 0; k < layout_.tangential_edges[level].size(); ++k) {
        const std::size_t i = layout_.tangential_begin[level] + 2 * k;
        const std::uint32_t edge = layout_.tangential_edges[level][k];
        bool keep = std::hypot(values_[i], values_[i + 1]) >= tangential_limit;
        if (keep && !topology.is_curve(edge)) {
          // The place and the two numbers cost far more than a normal coefficient, and sliding along the
          // surface gains little.
          constexpr double kTangentialBits = 26;
          const Vec3* frame = system_.synthesis().tangential_frame(l, k);
          const Vec3 displacement = values_[i] * frame[0] + values_[i + 1] * frame[1];
          const SymmetricMatrix3& block = system_.galerkin().diagonal(l + 1, topology.vertex_count + edge);
          keep = 0.5 * dot(displacement, block * displacement) > lambda_ * kTangentialBits;
        }
        if (keep) continue;
        values_[i] = values_[i + 1] = 0;
        active_[i] = active_[i + 1] = 0;
      }
    }
  }

  void minimize(int outer, int inner, double tolerance) {
    MinimizeOptions minimize;
    minimize.maximum_outer = outer;
    minimize.maximum_inner = inner;
    minimize.inner_tolerance = tolerance;
    system_.minimize(active_, minimize, values_);
  }

  /// Starts at the layer that follows, with the base where its vertices round to; they stay there.
  void start_before(const QuantizedMesh& finer, int ratio) {
    take_values(finer);
    coordinates_ = finer.base_coordinates;
    for (auto& vertex : coordinates_)
      for (std::int32_t& x : vertex)
        x = static_cast<std::int32_t>(
            std::floor((x + 0.5 * ratio - 0.25) / ratio));  // the nearest, ties downwards
    hold_base();
  }
  /// Starts at integers of this layer's own steps.
  void start_at(const QuantizedMesh& mesh) {
    take_values(mesh);
    coordinates_ = mesh.base_coordinates;
    for (int l = 0; l < layout_.coded_level_count; ++l) {
      const std::vector<std::int32_t>& level = mesh.normal[static_cast<std::size_t>(l)];
      std::copy(level.begin(), level.end(), field_.values.begin() + hierarchy_.level(l).vertex_count);
    }
    hold_base();
  }

  void round_base() {
    if (base_is_held_) return;
    const double grid = base_step();
    coordinates_.resize(layout_.base_vertex_count);
    for (std::size_t v = 0; v < layout_.base_vertex_count; ++v) {
      for (std::size_t k = 0; k < 3; ++k) {
        const double relative = values_[3 * v + k] - options_.base_origin[static_cast<int>(k)];
        coordinates_[v][k] = static_cast<std::int32_t>(std::lround(relative / grid));
      }
    }
    hold_base();
  }

  void round_level(int l) {
    const auto level = static_cast<std::size_t>(l);
    const double delta = step(l);
    const std::size_t vertex_count = hierarchy_.level(l).vertex_count;
    const std::size_t begin = layout_.normal_begin[level];
    for (std::size_t e = 0; e < hierarchy_.level(l).edge_count; ++e) {
      const double c = values_[begin + e];
      std::int32_t q = 0;
      if (active_[begin + e]) {
        q = static_cast<std::int32_t>(std::min(std::abs(c) / delta + 0.45, 6e7));
        if (c < 0) q = -q;
      }
      field_.values[vertex_count + e] = q;
      values_[begin + e] = q * delta;
      active_[begin + e] = 0;
    }
    const double tangential = tangential_step(l);
    for (std::size_t i = layout_.tangential_begin[level]; i < layout_.tangential_begin[level + 1]; ++i) {
      values_[i] = std::round(values_[i] / tangential) * tangential;
      active_[i] = 0;
    }
  }

  /// Coordinate descent over the base and all levels.
  void descend() {
    std::vector<Vec3> positions, force;
    std::vector<double> dual;
    const auto linearize = [&] {
      system_.synthesis().synthesize(values_, positions);
      const double value = system_.energy().gradient(positions, force);
      system_.synthesis().adjoint(force, dual);
      return value;
    };
    rates_.learn(field_);
    double energy = linearize();
    DescentOptions descent;
    descent.lambda = lambda_;
    const auto* base = coarser_coordinates_.empty() ? nullptr : &coarser_coordinates_;
    // The quadratic that a descent trusts has frozen normals: what does not hold up when decoded is taken
    // back.
    const auto old_coordinates = coordinates_;
    if (!base_is_held_ && descend_base(system_, base_step(), dual, descent, base, coordinates_) > 0) {
      store_base();
      const double lower = linearize();
      if (lower > energy && !base) {
        coordinates_ = old_coordinates;
        store_base();
        linearize();
      } else {
        energy = lower;
      }
    }
    for (int l = 0; l < layout_.coded_level_count; ++l) {
      const std::vector<std::int32_t> old_values = field_.values;
      const double old_bits = rates_.total_bits();
      if (descend_level(system_, l, step(l), dual, descent, rates_, field_) == 0) continue;
      store_level(l);
      const double lower = linearize();
      if (lower + lambda_ * rates_.total_bits() > energy + lambda_ * old_bits) {
        field_.values = old_values;
        rates_.learn(field_);
        store_level(l);
        linearize();
      } else {
        energy = lower;
      }
    }
  }

  double energy() const { return system_.energy_of(values_); }
  double model_bits() {
    rates_.learn(field_);
    return rates_.total_bits();
  }
  const std::vector<double>& values() const { return values_; }

  QuantizedMesh result() const {
    QuantizedMesh mesh;
    mesh.base_origin = options_.base_origin;
    mesh.base_step = base_step();
    mesh.base_coordinates = coordinates_;
    mesh.smoothing_level_count = hierarchy_.level_count() - layout_.coded_level_count;
    for (int l = 0; l < layout_.coded_level_count; ++l) {
      const auto level = static_cast<std::size_t>(l);
      LevelQuantizer quantizer;
      quantizer.normal_step = step(l);
      quantizer.tangential_step = tangential_step(l);
      quantizer.tension = Tension{system_.synthesis().tension()[level]};
      mesh.quantizers.push_back(quantizer);
      const auto begin = field_.values.begin() + hierarchy_.level(l).vertex_count;
      mesh.normal.emplace_back(begin, begin + hierarchy_.level(l).edge_count);
      auto& list = mesh.tangential.emplace_back();
      for (std::size_t i = 0; i < layout_.tangential_edges[level].size(); ++i) {
        const std::size_t unknown = layout_.tangential_begin[level] + 2 * i;
        TangentialCoefficient t;
        t.edge = layout_.tangential_edges[level][i];
        t.along = static_cast<std::int32_t>(std::lround(values_[unknown] / tangential_step(l)));
        t.across = static_cast<std::int32_t>(std::lround(values_[unknown + 1] / tangential_step(l)));
        if (t.along != 0 || t.across != 0) list.push_back(t);
      }
    }
    return mesh;
  }

 private:
  /// Normal and tangential coefficients of a layer as values of the unknowns.
  void take_values(const QuantizedMesh& mesh) {
    for (int l = 0; l < layout_.coded_level_count; ++l) {
      const auto level = static_cast<std::size_t>(l);
      for (std::size_t e = 0; e < mesh.normal[level].size(); ++e)
        values_[layout_.normal_begin[level] + e] = mesh.quantizers[level].normal_step * mesh.normal[level][e];
      auto next = mesh.tangential[level].begin();
      for (std::size_t i = 0; i < layout_.tangential_edges[level].size(); ++i) {
        double* t = values_.data() + layout_.tangential_begin[level] + 2 * i;
        t[0] = t[1] = 0;
        if (next == mesh.tangential[level].end() || next->edge != layout_.tangential_edges[level][i])
          continue;
        t[0] = mesh.quantizers[level].tangential_step * next->along;
        t[1] = mesh.quantizers[level].tangential_step * next->across;
        ++next;
      }
    }
  }
  void hold_base() {
    std::fill_n(active_.begin(), 3 * layout_.base_vertex_count, std::uint8_t{0});
    store_base();
  }
  void store_level(int l) {
    const std::size_t begin = layout_.normal_begin[static_cast<std::size_t>(l)];
    const std::size_t vertex_count = hierarchy_.level(l).vertex_count;
    const double delta = step(l);
    for (std::size_t e = 0; e < hierarchy_.level(l).edge_count; ++e)
      values_[begin + e] = field_.values[vertex_count + e] * delta;
  }
  void store_base() {
    for (std::size_t v = 0; v < layout_.base_vertex_count; ++v)
      for (std::size_t k = 0; k < 3; ++k)
        values_[3 * v + k] = options_.base_origin[static_cast<int>(k)] + base_step() * coordinates_[v][k];
  }

  /// The normal coefficients of a layer, times `factor`, by vertex; empty without a layer.
  static std::vector<std::int32_t> vertex_values(const SubdivisionHierarchy& hierarchy,
                                                 const QuantizedMesh* layer, int factor) {
    std::vector<std::int32_t> values;
    if (!layer) return values;
    values.assign(hierarchy.level(layer->level_count()).vertex_count, 0);
    for (int l = 0; l < layer->level_count(); ++l) {
      const std::vector<std::int32_t>& level = layer->normal[static_cast<std::size_t>(l)];
      for (std::size_t e = 0; e < level.size(); ++e)
        values[hierarchy.level(l).vertex_count + e] = factor * level[e];
    }
    return values;
  }
  static std::vector<std::array<std::int32_t, 3>> scaled_coordinates(const LayerNeighbours& layers) {
    std::vector<std::array<std::int32_t, 3>> coordinates;
    if (!layers.coarser) return coordinates;
    coordinates = layers.coarser->base_coordinates;
    for (auto& c : coordinates)
      for (std::int32_t& k : c) k *= layers.ratio;
    return coordinates;
  }

  const QuantizeOptions& options_;
  const SubdivisionHierarchy& hierarchy_;
  FitSystem& system_;
  const UnknownLayout& layout_;
  std::vector<double> values_;
  std::vector<std::uint8_t> active_;
  const std::vector<std::int32_t>
      coarser_values_;  // per vertex, in the present steps; empty in the first layer
  const std::vector<std::array<std::int32_t, 3>> coarser_coordinates_;
  const bool base_is_held_;
  CoefficientField field_;
  ContextRateModel rates_;
  std::vector<std::array<std::int32_t, 3>> coordinates_;
  double lambda_ = 0;
};

void report_on(Quantization& run, const FitSystem& system, const QuantizedMesh& mesh,
               QuantizeReport* report) {
  if (!report) return;
  report->final_rms = system.energy().root_mean_square(run.energy());
  report->model_bits = run.model_bits();
  report->nonzero_count = mesh.nonzero_count();
  report->tangential_count = 0;
  for (const auto& list : mesh.tangential) report->tangential_count += list.size();
}

}  // namespace

QuantizedMesh MeshQuantizer::quantize(const QuantizeOptions& options, QuantizeReport* report) {
  return run(options, nullptr, 1, report);
}

QuantizedMesh MeshQuantizer::coarsen(const QuantizedMesh& finer, int ratio, const QuantizeOptions& options,
                                     QuantizeReport* report) {
  QuantizeOptions coarse = options;
  coarse.normal_step = finer.quantizers.back().normal_step * ratio;
  coarse.base_origin = finer.base_origin;
  coarse.keep_correspondences = true;
  return run(coarse, &finer, ratio, report);
}

QuantizedMesh MeshQuantizer::polish(const QuantizedMesh& mesh, const QuantizedMesh* coarser,
                                    const QuantizedMesh* finer, int ratio, const QuantizeOptions& options,
                                    QuantizeReport* report) {
  QuantizeOptions own = options;
  own.normal_step = mesh.quantizers.back().normal_step;
  own.base_origin = mesh.base_origin;
  State& state = *state_;
  state.restart(true);
  Quantization run(own, state.mesh.hierarchy, state.system, state.fitted_values,
                   free_unknowns(state.mesh, state.system.layout(), true), {coarser, finer, ratio});
  run.start_at(mesh);
  state.follow(run.values(), own.reach_multiple);
  constexpr int kRounds = 2;
  for (int round = 0; round < kRounds; ++round) run.descend();
  QuantizedMesh result = run.result();
  report_on(run, state.system, result, report);
  return result;
}

QuantizedMesh MeshQuantizer::run(const QuantizeOptions& options, const QuantizedMesh* finer, int ratio,
                                 QuantizeReport* report) {
  State& state = *state_;
  FitSystem& system = state.system;
  const bool kept = options.keep_correspondences && !state.at_start;
  state.restart(kept);
  Quantization run(options, state.mesh.hierarchy, system, state.fitted_values,
                   free_unknowns(state.mesh, system.layout(), true), {nullptr, finer, ratio});
  if (finer) run.start_before(*finer, ratio);
  int reprojections = kept ? 1 : 0;
  const auto reproject = [&] {
    if (reprojections >= options.reprojection_count) return;
    ++reprojections;
    state.follow(run.values(), options.reach_multiple);
  };
  for (int round = 0; round < options.active_set_rounds; ++round) {
    run.shrink(options.dead_zone * (round == 0 ? 0.8 : 1.0));
    if (round > 0 && !kept) reproject();
    run.minimize(2, 25, 0.05);
  }
  if (report) report->fit_rms = system.energy().root_mean_square(run.energy());
  run.shrink(options.dead_zone);
  run.round_base();
  for (int l = 0; l < system.layout().coded_level_count; ++l) {
    run.minimize(1, 15, 0.05);
    run.round_level(l);
  }
  for (int round = 0; round < options.descent_rounds; ++round) {
    if (round == 1) reproject();
    run.descend();
  }
  QuantizedMesh mesh = run.result();
  report_on(run, system, mesh, report);
  return mesh;
}

}  // namespace nmc
