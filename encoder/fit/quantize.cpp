// SPDX-License-Identifier: Apache-2.0
#include "encoder/fit/quantize.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "encoder/core/parallel.h"
#include "encoder/fit/context_rate_model.h"
#include "encoder/fit/coordinate_descent.h"

namespace nmc {

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

  /// Back to the correspondences of the fit, and to the frames of its mesh: a coefficient is judged by where it points.
  void restart(bool keep_correspondences) {
    std::vector<Vec3> positions;
    system.synthesis().synthesize(fitted_values, positions);
    if (at_start || keep_correspondences) return;
    system.set_samples(samples, positions, energy_options);
    moved_samples = {};
    at_start = true;
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

/// One run of the quantizer: the values of all unknowns on their way to integers.
class Quantization {
 public:
  Quantization(const QuantizeOptions& options, const SubdivisionHierarchy& hierarchy, FitSystem& system,
               std::vector<double> values, std::vector<std::uint8_t> active, const QuantizedMesh* previous,
               int ratio)
      : options_(options),
        hierarchy_(hierarchy),
        system_(system),
        layout_(system.layout()),
        values_(std::move(values)),
        active_(std::move(active)),
        previous_values_(scaled_values(hierarchy, previous, ratio)),
        previous_coordinates_(scaled_coordinates(previous, ratio)),
        field_(hierarchy, layout_.coded_level_count),
        rates_(hierarchy, layout_.coded_level_count, previous ? &previous_values_ : nullptr) {
    // What may never move (along a boundary) is not coded either.
    for (std::size_t i = layout_.tangential_begin.front(); i < layout_.count; ++i)
      if (!active_[i]) values_[i] = 0;
    fitted_base_.assign(values_.begin(),
                        values_.begin() + static_cast<std::ptrdiff_t>(3 * layout_.base_vertex_count));
    if (previous) start_at(*previous);
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
        const std::size_t vertex = hierarchy_.level(l).vertex_count + (i - begin);
        if (!active_[i] || std::abs(values_[i]) >= limit || was_nonzero(vertex)) continue;
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
    const bool anchored =
        options_.base_pull > 0 || (!previous_values_.empty() && options_.refinement_weight > 0);
    if (anchored) update_anchor();
    system_.minimize(active_, minimize, values_, anchored ? &anchor_ : nullptr);
  }

  void round_base() {
    const double grid = base_step();
    coordinates_.resize(layout_.base_vertex_count);
    for (std::size_t v = 0; v < layout_.base_vertex_count; ++v) {
      for (std::size_t k = 0; k < 3; ++k) {
        const double relative = values_[3 * v + k] - options_.base_origin[static_cast<int>(k)];
        coordinates_[v][k] = static_cast<std::int32_t>(std::lround(relative / grid));
        active_[3 * v + k] = 0;
      }
    }
    store_base();
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
    const auto* base = previous_coordinates_.empty() ? nullptr : &previous_coordinates_;
    // The quadratic that a descent trusts has frozen normals: what does not hold up when decoded is taken
    // back.
    const auto old_coordinates = coordinates_;
    if (descend_base(system_, base_step(), dual, descent, base, coordinates_) > 0) {
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
  /// A refinement starts where the previous layer ended, and so moves only where the error asks for it. The
  /// base stays: what is worth a correction is found by the descent.
  void start_at(const QuantizedMesh& previous) {
    for (std::size_t v = 0; v < layout_.base_vertex_count; ++v)
      for (std::size_t k = 0; k < 3; ++k) {
        values_[3 * v + k] =
            previous.base_origin[static_cast<int>(k)] + previous.base_step * previous.base_coordinates[v][k];
        active_[3 * v + k] = 0;
      }
    for (int l = 0; l < layout_.coded_level_count; ++l) {
      const auto level = static_cast<std::size_t>(l);
      for (std::size_t e = 0; e < previous.normal[level].size(); ++e)
        values_[layout_.normal_begin[level] + e] =
            previous.quantizers[level].normal_step * previous.normal[level][e];
      auto next = previous.tangential[level].begin();
      for (std::size_t i = 0; i < layout_.tangential_edges[level].size(); ++i) {
        double* t = values_.data() + layout_.tangential_begin[level] + 2 * i;
        t[0] = t[1] = 0;
        if (next == previous.tangential[level].end() || next->edge != layout_.tangential_edges[level][i])
          continue;
        t[0] = previous.quantizers[level].tangential_step * next->along;
        t[1] = previous.quantizers[level].tangential_step * next->across;
        ++next;
      }
    }
  }
  /// The rate's share of the quadratic at the present values: dR/d|q| = weight / (1 + |q|) as a pull towards
  /// the resting value, reweighted with every solve.
  void update_anchor() {
    anchor_.weight.assign(layout_.count, 0.0);
    anchor_.center.assign(layout_.count, 0.0);
    const double scale = lambda_ * options_.refinement_weight;
    const auto pull = [&](std::size_t i, double center, double delta) {
      const double q = std::abs(values_[i] - center) / delta;
      anchor_.center[i] = center;
      anchor_.weight[i] = scale / ((1 + q) * std::max(q, 0.5) * delta * delta);
    };
    if (options_.base_pull > 0) {
      for (std::size_t i = 0; i < fitted_base_.size(); ++i) {
        anchor_.center[i] = fitted_base_[i];
        anchor_.weight[i] = lambda_ * options_.base_pull / (base_step() * base_step());
      }
    }
    if (previous_values_.empty()) return;
    for (int l = 0; l < layout_.coded_level_count; ++l) {
      const std::size_t begin = layout_.normal_begin[static_cast<std::size_t>(l)];
      const std::size_t vertex_count = hierarchy_.level(l).vertex_count;
      for (std::size_t e = 0; e < hierarchy_.level(l).edge_count; ++e)
        if (active_[begin + e]) pull(begin + e, previous_values_[vertex_count + e] * step(l), step(l));
    }
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

  static std::vector<std::int32_t> scaled_values(const SubdivisionHierarchy& hierarchy,
                                                 const QuantizedMesh* previous, int ratio) {
    std::vector<std::int32_t> values;
    if (!previous) return values;
    values.assign(hierarchy.level(previous->level_count()).vertex_count, 0);
    for (int l = 0; l < previous->level_count(); ++l) {
      const std::vector<std::int32_t>& level = previous->normal[static_cast<std::size_t>(l)];
      for (std::size_t e = 0; e < level.size(); ++e)
        values[hierarchy.level(l).vertex_count + e] = ratio * level[e];
    }
    return values;
  }
  static std::vector<std::array<std::int32_t, 3>> scaled_coordinates(const QuantizedMesh* previous,
                                                                     int ratio) {
    std::vector<std::array<std::int32_t, 3>> coordinates;
    if (!previous) return coordinates;
    coordinates = previous->base_coordinates;
    for (auto& c : coordinates)
      for (std::int32_t& k : c) k *= ratio;
    return coordinates;
  }
  bool was_nonzero(std::size_t vertex) const {
    return !previous_values_.empty() && previous_values_[vertex] != 0;
  }

  const QuantizeOptions& options_;
  const SubdivisionHierarchy& hierarchy_;
  FitSystem& system_;
  const UnknownLayout& layout_;
  std::vector<double> values_;
  std::vector<std::uint8_t> active_;
  const std::vector<std::int32_t>
      previous_values_;  // per vertex, on the present steps; empty in the first layer
  const std::vector<std::array<std::int32_t, 3>> previous_coordinates_;
  CoefficientField field_;
  ContextRateModel rates_;
  std::vector<std::array<std::int32_t, 3>> coordinates_;
  double lambda_ = 0;
  Anchor anchor_;
  std::vector<double> fitted_base_;  // positions of the base vertices in the fit without quantization
};

}  // namespace

QuantizedMesh MeshQuantizer::quantize(const QuantizeOptions& options, QuantizeReport* report) {
  return run(options, nullptr, 1, report);
}

QuantizedMesh MeshQuantizer::refine(const QuantizedMesh& previous, int ratio, const QuantizeOptions& options,
                                    QuantizeReport* report) {
  QuantizeOptions finer = options;
  finer.normal_step = previous.quantizers.back().normal_step / ratio;
  finer.base_origin = previous.base_origin;
  return run(finer, &previous, ratio, report);
}

QuantizedMesh MeshQuantizer::run(const QuantizeOptions& options, const QuantizedMesh* previous, int ratio,
                                 QuantizeReport* report) {
  State& state = *state_;
  FitSystem& system = state.system;
  const SubdivisionHierarchy& hierarchy = state.mesh.hierarchy;
  const LevelTopology& finest = hierarchy.level(hierarchy.level_count());
  const bool kept = options.keep_correspondences && !state.at_start;
  state.restart(kept);
  Quantization run(options, hierarchy, system, state.fitted_values,
                   free_unknowns(state.mesh, system.layout(), true), previous, ratio);
  std::vector<SurfaceSample>& samples = state.moved_samples;
  int reprojections = kept ? 1 : 0;
  const auto reproject = [&] {
    if (!state.input || reprojections >= options.reprojection_count) return;
    ++reprojections;
    std::vector<Vec3> positions;
    system.synthesis().positions_of(run.values(), positions);
    if (samples.empty()) samples = state.samples;
    samples.resize(state.samples.size());
    const double rms = system.energy().root_mean_square(system.energy().value(positions));
    reproject_samples(*state.input, finest, positions, {}, samples);
    if (options.reach_multiple > 0) {
      append_input_samples(*state.input, finest, positions, samples.size() / 8, state.total_weight,
                           options.reach_multiple * rms, samples);
    }
    system.set_samples(samples, positions, state.energy_options);
    state.at_start = false;
  };
  if (previous) run.minimize(3, 30, 0.05);
  for (int round = 0; round < options.active_set_rounds; ++round) {
    run.shrink(options.dead_zone * (round == 0 ? 0.8 : 1.0));
    if (round > 0 && !kept) reproject();
    run.minimize(2, 25, 0.05);
  }
  if (report) report->fit_rms = system.energy().root_mean_square(run.energy());
  run.shrink(options.dead_zone);
  run.round_base();
  for (int l = 0; l < hierarchy.level_count() && l < system.layout().coded_level_count; ++l) {
    run.minimize(1, 15, 0.05);
    run.round_level(l);
  }
  for (int round = 0; round < options.descent_rounds; ++round) {
    if (round == 1) reproject();
    run.descend();
  }
  if (report) {
    report->final_rms = system.energy().root_mean_square(run.energy());
    report->model_bits = run.model_bits();
  }
  QuantizedMesh mesh = run.result();
  if (report) {
    report->nonzero_count = mesh.nonzero_count();
    report->tangential_count = 0;
    for (const auto& list : mesh.tangential) report->tangential_count += list.size();
  }
  return mesh;
}

}  // namespace nmc
