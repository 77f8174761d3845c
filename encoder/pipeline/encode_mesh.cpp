// SPDX-License-Identifier: Apache-2.0
#include "encoder/pipeline/encode_mesh.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "encoder/core/error.h"
#include "encoder/domain/certificate.h"
#include "encoder/domain/maps_collapse.h"
#include "encoder/domain/relaxation.h"
#include "encoder/domain/simplify.h"
#include "encoder/measure/compare_meshes.h"
#include "encoder/normal_mesh/semi_regular_input.h"
#include "encoder/pipeline/target_search.h"
#include "encoder/sphere/sphere_base.h"
#include "encoder/sphere/sphere_parameterization.h"

namespace nmc {

namespace {

class StageClock {
 public:
  explicit StageClock(std::vector<StageTime>& times) : times_(times) {}
  /// Ends the running stage and starts another.
  void start(const std::string& stage) {
    stop();
    stage_ = stage;
    begin_ = std::chrono::steady_clock::now();
  }
  void stop() {
    if (stage_.empty()) return;
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
    const auto found =
        std::find_if(times_.begin(), times_.end(), [&](const StageTime& t) { return t.stage == stage_; });
    if (found != times_.end())
      found->seconds += seconds;
    else
      times_.push_back({stage_, seconds});
    stage_.clear();
  }

 private:
  std::vector<StageTime>& times_;
  std::string stage_;
  std::chrono::steady_clock::time_point begin_;
};

/// How hard to look for the best base size, by effort.
struct SearchPlan {
  int extra_candidates;
  int trials_per_candidate;
};
SearchPlan plan_of(int effort) {
  constexpr SearchPlan kPlans[9] = {{0, 3}, {0, 4}, {1, 4}, {2, 4}, {4, 4}, {5, 5}, {6, 6}, {8, 6}, {10, 8}};
  return kPlans[std::clamp(effort, 1, 9) - 1];
}

constexpr std::size_t kLargestBase = 60000;
constexpr int kMostSplits = 8;  // that are undone of an input: the levels of a stream

/// Of a size that geometry and colours share. Colours that need less leave the rest unused.
constexpr double kGeometryShare = 0.5;
/// Share of the asked error that the fit may leave before quantization.
constexpr double kLargestFloor = 0.75;
/// A level is worth its work where it brings the fit's error to this share at least; smooth surfaces reach a quarter.
constexpr double kHelpfulLevel = 0.7;
/// With more of it a rival is not even tried.
constexpr double kHopelessFloor = 0.97;

/// Share of the inner edges whose faces meet at more than 30 degrees. A scan has a few percent of them at most, and
/// noise; a machine part has many along its creases.
double sharp_edge_share(const TriangleMesh& mesh) {
  struct Side {
    std::uint32_t low, high, triangle;
  };
  std::vector<Side> sides;
  sides.reserve(3 * mesh.triangle_count());
  for (std::uint32_t f = 0; f < mesh.triangle_count(); ++f) {
    const Triangle& t = mesh.triangles[f];
    for (std::size_t k = 0; k < 3; ++k)
      sides.push_back({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3]), f});
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    if (a.low != b.low) return a.low < b.low;
    return a.high != b.high ? a.high < b.high : a.triangle < b.triangle;
  });
  const auto normal = [&](std::uint32_t f) {
    const Triangle& t = mesh.triangles[f];
    const Vec3& a = mesh.positions[t[0]];
    return normalized(cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a));
  };
  std::size_t inner = 0, sharp = 0;
  for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
    if (sides[i].low != sides[i + 1].low || sides[i].high != sides[i + 1].high) continue;
    ++inner;
    sharp += dot(normal(sides[i].triangle), normal(sides[i + 1].triangle)) < 0.8660254037844386;
  }
  return inner ? static_cast<double>(sharp) / static_cast<double>(inner) : 0;
}

class MeshEncoder {
 public:
  MeshEncoder(const TriangleMesh& input, const EncodeOptions& options)
      : input_(input), options_(options), plan_(plan_of(options.effort)), clock_(result_.times) {
    if (has_colors() && options.target.kind == TargetKind::kSize) options_.target.value *= kGeometryShare;
  }

  EncodeResult run() {
    prepare();
    if (options_.domain == DomainChoice::kSphere) {
      choose_on_sphere();
    } else if (options_.domain == DomainChoice::kInput) {
      choose_on_input(input_hierarchy());
    } else {
      choose();
      if (options_.domain == DomainChoice::kAuto && best_.met && has_sphere()) {
        Outcome general = std::move(best_);
        choose_on_sphere();
        if (!better(best_, general)) best_ = std::move(general);
      }
      if (options_.domain == DomainChoice::kAuto) {
        const int most = options_.level_count.value_or(kMostSplits);
        auto own = recognize_subdivision_connectivity(surface_, most);
        if (own && own->base_vertex_count <= kLargestBase) {
          Outcome other = std::exchange(best_, {});
          noise_ = {};
          choose_on_input(std::move(*own));
          if (!better(best_, other)) best_ = std::move(other);
        }
      }
    }
    finish();
    clock_.stop();
    return std::move(result_);
  }

 private:
  struct Outcome {
    std::size_t base_index = 0;
    std::unique_ptr<Candidate> candidate;
    std::shared_ptr<const Parameterization> parameterization;
    Trial trial;
    bool was_tried = false;  // else out of reach, and no trial was made
    bool met = false;
    DomainChoice domain = DomainChoice::kGeneral;
    bool is_simplified = false;  // on a base that simplification alone has made
    /// What the target would take at least on this candidate, as its trials foretell: where it is out of reach the last
    /// of them are spent in vain.
    double foretold_bytes = 0;
  };

  void prepare() {
    clock_.start("condition");
    report(options_.progress, "conditioning", 0);
    // A filled hole may lie a sixth of its loop's length from the input, so the fills are held to the asked error.
    ConditionOptions conditions = options_.condition;
    const double box_diagonal = measurable_box(input_).diagonal();
    if (options_.target.kind != TargetKind::kSize && box_diagonal > 0) {
      conditions.small_hole_length_fraction =
          std::min(conditions.small_hole_length_fraction, 3 * options_.target.value / box_diagonal);
    }
    if (options_.domain == DomainChoice::kInput) conditions.small_hole_edges = 0;  // a fill is no split triangle
    ConditionedMesh conditioned = condition(input_, conditions);
    result_.condition = conditioned.report;
    surface_ = std::move(conditioned.mesh);

    // All rooms work around the centre of the box, where doubles are densest: georeferenced scans lie millions of units
    // from their origin. Only the stream's grid knows where the centre was.
    reference_.mesh = measurable_part(input_);
    description_.box = bounding_box(reference_.mesh);
    reference_.center = description_.box.center();
    for (Vec3& p : reference_.mesh.positions) p -= reference_.center;
    for (Vec3& p : surface_.positions) p -= reference_.center;
    reference_.index = std::make_unique<SurfaceIndex>(reference_.mesh);
    reference_.diagonal = result_.diagonal = description_.box.diagonal();
    description_.input_vertex_count = input_.vertex_count();
    description_.input_triangle_count = input_.triangle_count();
    description_.units = options_.units;
    description_.up_axis = options_.up_axis;
    description_.region_count = options_.region_count;

    if (options_.domain == DomainChoice::kInput) return;
    clock_.start("collapse");
    report(options_.progress, "base mesh", 0);
    // The largest base is the surface itself: with it every error can be reached.
    const int largest = static_cast<int>(std::min<std::size_t>(surface_.vertex_count(), kLargestBase));
    if (options_.base_vertex_count) {
      base_sizes_ = {std::min(*options_.base_vertex_count, static_cast<int>(surface_.vertex_count()))};
    } else {
      for (double size = 32; size < 0.8 * largest; size *= 1.5) base_sizes_.push_back(static_cast<int>(size));
      base_sizes_.push_back(largest);
    }
    CollapseOptions collapse;
    collapse.crease_angle_degrees = options_.crease_angle_degrees;
    history_ = maps_collapse(surface_, base_sizes_, collapse, options_.progress);
    keep_reached_base_sizes();
  }

  /// Every component, handle and boundary loop needs base vertices of its own, so a base can come out far larger than
  /// asked: from here on base_sizes_ says what was reached, each size once.
  void keep_reached_base_sizes() {
    std::vector<std::size_t>& steps = history_->base_step_counts;
    steps.erase(std::unique(steps.begin(), steps.end()), steps.end());
    base_sizes_.clear();
    for (const std::size_t count : steps)
      base_sizes_.push_back(static_cast<int>(history_->surface->vertex_count() - count));
  }

  /// The error that the target stands for, relative to the diagonal; for a size, what a typical scan reaches.
  double relative_target() const {
    const double value = options_.target.value / result_.diagonal;
    switch (options_.target.kind) {
      case TargetKind::kMaximumError:
        return value / 16;  // at the usual mixture of errors; single spikes want finer meshes than the mean does
      case TargetKind::kRmsError:
        return value;
      case TargetKind::kSize: {
        // Typical scans need about 6 kB at 1e-4, and twice the error for 0.55 of the bytes.
        return 1e-4 * std::pow(6000 / std::max(options_.target.value, 100.0), 1.16);
      }
    }
    return 1e-4;
  }

  std::size_t first_base_index() const {
    const double wanted = std::clamp(300 * std::pow(1e-4 / relative_target(), 0.35), 48.0, 3000.0);
    return nearest_base_index(wanted);
  }

  /// Of the base of about so many vertices; ratios count.
  std::size_t nearest_base_index(double wanted) const {
    std::size_t best = 0;
    for (std::size_t i = 1; i < base_sizes_.size(); ++i) {
      if (std::abs(std::log(base_sizes_[i] / wanted)) < std::abs(std::log(base_sizes_[best] / wanted))) best = i;
    }
    return best;
  }

  /// Bounds memory: 0.5 kB per vertex of the finest level.
  double largest_vertex_count() const { return 24 * static_cast<double>(surface_.vertex_count()) + 500000; }

  /// Beyond a few times the input's own vertices more levels are tried only where time does not matter.
  double worthwhile_vertex_count() const {
    return options_.effort >= 7 ? largest_vertex_count() : 3 * static_cast<double>(surface_.vertex_count()) + 60000;
  }

  int level_count_for(int base_size) const {
    if (options_.level_count) return *options_.level_count;
    if (base_size >= static_cast<int>(surface_.vertex_count())) return 1;
    // A smooth surface wants 3 to 10 vertices per unit of 1 / error, the more of them the more detail the input
    // has; beyond a few times the input's own vertices there is nothing left to follow.
    const double vertices = static_cast<double>(surface_.vertex_count());
    const double error = relative_target();
    const double asked = finer_ * std::min(4 * vertices, std::clamp(7e-5 * vertices / error, 3 / error, 10 / error));
    const double wanted = std::min(asked, worthwhile_vertex_count());
    const double ratio = std::max(1.0, wanted / base_size);
    return std::clamp(static_cast<int>(std::ceil(std::log(ratio) / std::log(4.0) - 0.2)), 1, 8);
  }

  const std::shared_ptr<const Parameterization>& parameterization_of(std::size_t base_index) {
    if (!parameterization_ || parameterized_index_ != base_index) {
      clock_.start("parameterize");
      report(options_.progress, "parameterization", 0);
      parameterization_.reset();
      parameterization_ = std::make_shared<const Parameterization>(relax(*history_, base_index));
      parameterized_index_ = base_index;
    }
    return parameterization_;
  }

  Outcome evaluate(std::size_t base_index) {
    Outcome outcome;
    outcome.base_index = base_index;
    outcome.parameterization = parameterization_of(base_index);
    CandidateOptions candidate;
    candidate.coded_level_count = level_count_for(base_sizes_[base_index]);
    candidate.tension = tension_;
    double coarser_rms = std::numeric_limits<double>::infinity();
    for (;;) {
      clock_.start("normal mesh and fit");
      outcome.candidate.reset();
      outcome.candidate =
          std::make_unique<Candidate>(outcome.parameterization, reference_, candidate, options_.progress);
      // What the fit cannot resolve no step can bring back, and the nearer the fit's own error is to the target, the
      // finer the steps that are left: another level costs a few zeros. A rival gets no more levels than the best has.
      const bool too_coarse = options_.target.kind == TargetKind::kRmsError &&
                              outcome.candidate->statistics().fit.final_rms > kLargestFloor * options_.target.value;
      const double next_size = base_sizes_[base_index] * std::pow(4.0, candidate.coded_level_count + 1);
      const bool enough = best_.met && !best_.is_simplified &&
                          candidate.coded_level_count >= best_.candidate->coded_level_count();
      // Along a crease that no base edge follows levels help little: there more base vertices do.
      const double fit_rms = outcome.candidate->statistics().fit.final_rms;
      const bool no_help = fit_rms > kHelpfulLevel * coarser_rms;
      if (!too_coarse || enough || no_help || options_.level_count || next_size > worthwhile_vertex_count()) break;
      coarser_rms = fit_rms;
      ++candidate.coded_level_count;
    }
    const bool hopeless = best_.met && options_.target.kind == TargetKind::kRmsError &&
                          outcome.candidate->statistics().fit.final_rms > kHopelessFloor * options_.target.value;
    if (!hopeless) search(candidate.coded_level_count, outcome);
    return outcome;
  }

  /// The surface on the sphere, built once. Throws Error (kUnsupported) where it is not a closed genus-0 surface.
  const SphereParameterizedSurface& sphere() {
    if (!sphere_) {
      clock_.start("parameterize");
      SphereOptions sphere_options;
      sphere_options.relative_decrease = 1e-5;
      sphere_options.progress = options_.progress;
      sphere_ = std::make_unique<SphereParameterizedSurface>(std::make_shared<TriangleMesh>(surface_),
                                                             parameterize_sphere(surface_, sphere_options).positions);
    }
    return *sphere_;
  }

  Outcome evaluate_on_sphere(SphereBaseKind kind, int adaptive_size) {
    Outcome outcome;
    outcome.domain = DomainChoice::kSphere;
    const SphereParameterizedSurface& surface = sphere();
    SphereBaseOptions base_options;
    base_options.kind = kind;
    base_options.adaptive_vertex_count = static_cast<std::uint32_t>(adaptive_size);
    const ParameterizedBase base = sphere_base(surface, base_options);
    clock_.start("normal mesh and fit");
    CandidateOptions candidate;
    candidate.coded_level_count = level_count_for(static_cast<int>(base.positions.size()));
    outcome.candidate = std::make_unique<Candidate>(surface, base, reference_, candidate, options_.progress);
    search(candidate.coded_level_count, outcome);
    return outcome;
  }

  /// The input as levels over a base mesh of its own. Throws Error (kInvalidInput) where it is none.
  SemiRegularInput input_hierarchy() const {
    // Positions in files are rounded; two vertices of a base mesh are never so near.
    constexpr double kRounding = 1e-5;
    if (options_.base_mesh) {
      TriangleMesh base = *options_.base_mesh;
      for (Vec3& p : base.positions) p -= reference_.center;
      // Whatever its size: it was asked for.
      return recognize_subdivision_of(base, surface_, kRounding * result_.diagonal, options_.level_count);
    }
    auto own = recognize_subdivision_connectivity(surface_, options_.level_count.value_or(kMostSplits));
    const int found = own ? own->hierarchy.level_count() : 0, asked = options_.level_count.value_or(1);
    std::string reason;
    if (found < asked) {
      reason = "its triangles are not those of a coarser mesh, each split in four";
      if (asked > 1) reason += " " + std::to_string(asked) + " times; " + std::to_string(found) + " can be undone";
    } else if (own->base_vertex_count > kLargestBase) {
      reason = "the coarsest has " + std::to_string(own->base_vertex_count) + " vertices, more than " +
               std::to_string(kLargestBase);
    }
    if (reason.empty()) return std::move(*own);
    const std::string repairs = result_.condition.needed_repair() ? " (after repairs; -v lists them)" : "";
    throw Error(ExitCode::kInvalidInput, "the input has no base mesh of its own: " + reason + repairs);
  }

  /// Levels over the base mesh that `own` begins with, or over one of its finer levels, where that takes fewer bytes.
  void choose_on_input(SemiRegularInput own) {
    const int split_count = own.hierarchy.level_count();
    const double wanted = options_.base_vertex_count.value_or(0);
    int first = 0;  // the level that serves as base mesh
    std::vector<double> sizes;
    for (int level = 0; level < split_count; ++level)
      sizes.push_back(static_cast<double>(own.hierarchy.level(level).vertex_count));
    const auto size_of = [&](int level) { return sizes[static_cast<std::size_t>(level)]; };
    while (wanted > 0 && first + 1 < split_count &&
           std::abs(std::log(size_of(first + 1) / wanted)) < std::abs(std::log(size_of(first) / wanted)))
      ++first;
    std::vector<double> tensions = {1};
    if (sharp_edge_share(surface_) > 0.025) tensions.push_back(0);
    const bool is_chosen = options_.base_vertex_count || options_.level_count || options_.base_mesh;
    for (int level = first; level < split_count && (options_.base_mesh || size_of(level) <= kLargestBase); ++level) {
      bool is_best = false;
      if (level > 0) own = std::move(*recognize_subdivision_connectivity(surface_, split_count - level));
      for (const double tension : tensions) {
        tension_ = tension;
        is_best = evaluate_on_input(own) || is_best;
      }
      if (is_chosen || (best_.met && !is_best)) break;
    }
  }

  /// Levels over own's base mesh until they reach the target, its own ones at most. True where that became the best.
  bool evaluate_on_input(const SemiRegularInput& own) {
    clock_.start("parameterize");
    const auto parameterization = std::make_shared<const Parameterization>(identity_parameterization(own, surface_));
    const int most = own.hierarchy.level_count();
    CandidateOptions candidate;
    candidate.tension = tension_;
    finer_ = 1;
    step_guess_ = 0;
    candidate.coded_level_count = std::min(level_count_for(static_cast<int>(own.base_vertex_count)), most);
    bool is_best = false;
    for (;; ++candidate.coded_level_count) {
      Outcome outcome;
      outcome.domain = DomainChoice::kInput;
      outcome.parameterization = parameterization;
      clock_.start("normal mesh and fit");
      outcome.candidate = std::make_unique<Candidate>(parameterization, reference_, candidate, options_.progress);
      const bool is_last = options_.level_count || candidate.coded_level_count >= most;
      const bool too_coarse = options_.target.kind == TargetKind::kRmsError &&
                              outcome.candidate->statistics().fit.final_rms > kLargestFloor * options_.target.value;
      if (too_coarse && !is_last) continue;
      search(candidate.coded_level_count, outcome);
      const bool met = outcome.met;
      if (!best_.candidate || better(outcome, best_)) {
        best_ = std::move(outcome);
        is_best = true;
      }
      if (met || is_last) return is_best;
    }
  }

  /// Steps that reach the target on the outcome's candidate.
  void search(int level_count, Outcome& outcome) {
    clock_.start("quantize");
    report(options_.progress, "quantization", 0);
    TargetSearchOptions target_search;
    // With the surface itself as the base only the step stands between a trial and any error.
    constexpr int kTrialsOfLastResort = 12;
    const bool is_last_resort = outcome.candidate->statistics().base_vertex_count >= surface_.vertex_count();
    target_search.maximum_trials = is_last_resort ? kTrialsOfLastResort : plan_.trials_per_candidate;
    // A maximum is what no point exceeds: it takes all of them.
    target_search.trial.measure_sample_count = options_.target.kind == TargetKind::kMaximumError ? 0 : 60000;
    target_search.trial.quality_layer_count = options_.quality_layer_count;
    // Where no step can help, one trial for the record, unless another candidate has left one.
    if (options_.target.kind == TargetKind::kMaximumError && !is_last_resort &&
        outcome.candidate->is_out_of_reach(options_.target.value)) {
      if (best_.candidate) return;
      target_search.maximum_trials = 1;
    }
    // spend_slack() makes up for it, for one candidate instead of all.
    if (spends_slack()) target_search.good_enough = 0.975;
    const double aim = 0.5 * (1 + target_search.good_enough);
    if (best_.met) target_search.bytes_to_beat = best_.trial.byte_count;
    double first_step = step_guess_ > 0 ? step_guess_
                                        : result_.diagonal * 2e-3 * std::pow(relative_target() / 1.8e-4, 1.6);
    const bool is_rms = options_.target.kind == TargetKind::kRmsError;
    if (is_rms) first_step = step_for_rms(*outcome.candidate, aim * options_.target.value, noise_, true);
    TargetSearchResult found =
        search_target(*outcome.candidate, options_.target, description_, first_step, target_search);
    for (const Trial& t : found.trials) {
      result_.attempts.push_back({outcome.candidate->statistics().base_vertex_count, level_count,
                                  t.normal_step, t.byte_count, t.error});
    }
    outcome.foretold_bytes = std::numeric_limits<double>::infinity();
    for (const Trial& t : found.trials) {
      const double excess = std::clamp(target_ratio(options_.target, t), 1.0, 4.0);
      outcome.foretold_bytes =
          std::min(outcome.foretold_bytes, static_cast<double>(t.byte_count) * std::pow(excess, -kBytesOverError));
    }
    outcome.was_tried = true;
    outcome.met = found.best.has_value();
    outcome.trial = std::move(outcome.met ? *found.best : *found.nearest);
    step_guess_ = outcome.trial.normal_step;
    if (is_rms) noise_ = noise_of(*outcome.candidate, outcome.trial, found.trials.size() == 1);
  }

  /// Regular polyhedra first: their connectivity costs nothing. A surface with limbs wants vertices at their tips.
  void choose_on_sphere() {
    const int size = options_.base_vertex_count.value_or(base_sizes_[first_base_index()]);
    if (options_.base_vertex_count && size != 6 && size != 12) {
      best_ = evaluate_on_sphere(SphereBaseKind::kAdaptive, size);
      return;
    }
    best_ = evaluate_on_sphere(size == 6 ? SphereBaseKind::kOctahedron : SphereBaseKind::kIcosahedron, 0);
    for (int trial = 0; trial < 6 && !options_.base_vertex_count; ++trial) {
      // Two sizes at least are compared; after that only a missed target goes on, each time with a finer base.
      if (trial > 0 && best_.met) break;
      if (trial > 1) finer_ *= 1.6;
      step_guess_ = best_.met ? step_guess_ : 0;
      Outcome next = evaluate_on_sphere(SphereBaseKind::kAdaptive, size << trial);
      if (better(next, best_)) best_ = std::move(next);
    }
  }

  /// True where the sphere can take the place of the general domain.
  bool has_sphere() {
    try {
      sphere();
      return true;
    } catch (const Error& error) {
      if (error.code() != ExitCode::kUnsupported && error.code() != ExitCode::kInternal) throw;
      return false;
    }
  }

  /// Bytes of a trial, the largest error counted a little: half of it is worth 2 %.
  double priced_bytes(const Trial& trial) const {
    constexpr double kMaximumCounts = 0.03;
    const double bytes = static_cast<double>(trial.byte_count);
    return spends_slack() ? bytes * std::pow(trial.error.maximum / result_.diagonal, kMaximumCounts) : bytes;
  }
  /// The same once the trial's slack is spent.
  double cost_of(const Trial& trial) const {
    if (!spends_slack()) return priced_bytes(trial);
    return priced_bytes(trial) * std::pow(target_ratio(options_.target, trial), -kBytesOverError);
  }

  bool better(const Outcome& a, const Outcome& b) const {
    if (!a.was_tried) return false;
    if (a.met != b.met) return a.met;
    if (!a.met) return target_ratio(options_.target, a.trial) < target_ratio(options_.target, b.trial);
    return options_.target.kind == TargetKind::kSize ? a.trial.error.rms < b.trial.error.rms
                                                     : cost_of(a.trial) < cost_of(b.trial);
  }

  /// Puts `outcome` in the place of the best where it is better.
  bool take_if_better(Outcome outcome) {
    if (!better(outcome, best_)) return false;
    best_ = std::move(outcome);
    return true;
  }

  bool is_whole_surface(std::size_t base_index) const {
    return base_sizes_[base_index] == static_cast<int>(surface_.vertex_count());
  }

  void choose() {
    std::size_t index = first_base_index();
    best_ = evaluate(index);
    // Butterflies swing beyond creases: where there are many, midpoints may predict better.
    if (sharp_edge_share(surface_) > 0.025) {
      tension_ = 0;
      if (!take_if_better(evaluate(index))) tension_ = 1;
    }
    if (prefers_simplified_bases()) return;
    // A target out of reach: more base vertices see more features, another level resolves them. That a simplified base
    // has met it says nothing about these, but there is a file then, and the time is better spent elsewhere.
    constexpr int kMissesBesideMet = 2;
    bool met = best_.met && !best_.is_simplified;
    double ratio = target_ratio(options_.target, best_.trial);
    for (int missed = 0; !met && !(options_.base_vertex_count && options_.level_count); ++missed) {
      if (index + 1 == base_sizes_.size() && finer_ > 16) break;
      step_guess_ = 0;
      const bool far = missed >= 2 || ratio > 1.5;
      index = std::min(index + (far ? 3 : 1), base_sizes_.size() - 1);
      finer_ *= missed < 2 ? 2.5 : 1.5;
      if (is_whole_surface(index)) {
        tension_ = 0;  // nothing is left to predict
        finer_ = 32;   // and nothing is left to try
      }
      Outcome next = evaluate(index);
      met = next.met;
      if (next.was_tried) ratio = target_ratio(options_.target, next.trial);
      const bool is_beaten = best_.met && next.was_tried && next.trial.byte_count >= best_.trial.byte_count;
      take_if_better(std::move(next));
      if (is_beaten || (best_.met && missed + 1 == kMissesBesideMet)) break;
    }
    if (!best_.met) return;
    if (!prefers_large_bases() && !best_.is_simplified) climb(plan_.extra_candidates);
  }

  /// Hill climbing over the base sizes, from the best so far: around it bytes at equal error have one minimum, but for
  /// ripples where another size brings another number of levels. So a small gain on one side does not spare the other.
  void climb(int candidate_count) {
    constexpr double kClearGain = 0.975;
    const std::size_t start = best_.base_index;
    const double start_cost = cost_of(best_.trial);
    for (const std::ptrdiff_t direction : {1, -1}) {
      std::ptrdiff_t position = static_cast<std::ptrdiff_t>(start);
      for (; candidate_count > 0; --candidate_count) {
        position += direction;
        if (position < 0 || position >= static_cast<std::ptrdiff_t>(base_sizes_.size())) break;
        if (!take_if_better(evaluate(static_cast<std::size_t>(position)))) break;
      }
      if (candidate_count > 0) --candidate_count;  // the one that ended this side
      if (cost_of(best_.trial) < kClearGain * start_cost) break;
    }
  }

  /// There is a second minimum near the surface itself, where a base mesh is what a simplifier would leave and levels
  /// have little to say. It counts where the input is so coarse that its vertices are seen one by one.
  /// True where that minimum is the lower one; it has been searched then.
  bool prefers_large_bases() {
    constexpr double kBitsPerBaseVertex = 20, kLeastBits = 5;
    if (options_.effort < 3 || options_.base_vertex_count || options_.target.kind == TargetKind::kSize) return false;
    const double vertices = static_cast<double>(surface_.vertex_count());
    const double bits = 8 * static_cast<double>(best_.trial.byte_count) / vertices;
    const double share = std::min(1.0, bits / kBitsPerBaseVertex);
    const std::size_t index = nearest_base_index(share * vertices);
    if (bits < kLeastBits || index <= best_.base_index + 1) return false;
    const double tension = std::exchange(tension_, 0.0);  // the surface is flat between the vertices that are left
    if (take_if_better(evaluate(index))) {
      climb(plan_.extra_candidates);
      return true;
    }
    tension_ = tension;
    return false;
  }

  /// Planes of a machine part need a few large triangles and no levels: there a base mesh that simplification alone has
  /// made is the better one, and a level holds what little is curved. Where the first candidate takes fewer bytes than a
  /// simplified mesh of the asked error could, this ends after one measurement.
  /// True where such a base is best, and so clearly that others need not be tried; the best of them has been taken then.
  bool prefers_simplified_bases() {
    constexpr double kBitsPerVertex = 28;
    constexpr double kRatio = 0.8;  // of the vertex counts of the run
    constexpr std::size_t kCounts = 14;
    // The fit lowers the error of what simplification leaves by a third or so.
    constexpr double kHopeless = 1.6, kGoodStart = 1.15;
    constexpr double kFine = 30;  // times the vertices: from there half-edge collapses have done no harm
    const bool is_chosen = options_.base_vertex_count || options_.level_count || options_.crease_angle_degrees > 0;
    if (options_.effort < 2 || is_chosen || options_.target.kind == TargetKind::kSize || !best_.was_tried) return false;
    const double general_bytes = best_.foretold_bytes;
    const double most = std::min(0.8 * static_cast<double>(surface_.vertex_count()), 8 * general_bytes / kBitsPerVertex);
    if (most < 4) return false;
    clock_.start("simplify");
    report(options_.progress, "simplification", 0);
    std::size_t from = 0;
    while (from < base_sizes_.size() && base_sizes_[from] < kFine * most) ++from;
    std::vector<int> counts;
    for (double count = most; counts.size() < kCounts && count >= 4; count *= kRatio)
      counts.push_back(static_cast<int>(count));
    const std::vector<TriangleMesh> bases =
        simplify(from < base_sizes_.size() ? mesh_of_base(*history_, from) : surface_, counts, options_.progress);
    if (simplified_ratio(bases[0]) > kHopeless) return false;
    std::size_t index = 0;
    while (index + 1 < bases.size() && simplified_ratio(bases[index + 1]) < kGoodStart) ++index;
    const double tension = std::exchange(tension_, 0.0), step_guess = step_guess_;
    const QuantizationNoise noise = noise_;
    bool is_best = take_if_better(evaluate_simplified(bases[index]));
    const std::size_t start = index;
    for (const std::ptrdiff_t direction : {1, -1}) {
      for (int tries = plan_.extra_candidates; tries > 0; --tries) {
        const std::ptrdiff_t next = static_cast<std::ptrdiff_t>(index) + direction;
        if (next < 0 || next >= static_cast<std::ptrdiff_t>(bases.size())) break;
        if (!take_if_better(evaluate_simplified(bases[static_cast<std::size_t>(next)]))) break;
        index = static_cast<std::size_t>(next);
        is_best = true;
      }
      if (index != start) break;
    }
    if (!is_best) {
      tension_ = tension;
      step_guess_ = step_guess;
      noise_ = noise;
    }
    return is_best && best_.met && static_cast<double>(best_.trial.byte_count) < 0.9 * general_bytes;
  }

  /// What the target asks of a simplified mesh as it is; for a maximum error, what the fit and the repairs can mend of it.
  double simplified_ratio(const TriangleMesh& base) const {
    constexpr double kMendable = 3;
    CompareOptions compare;
    compare.normals = compare.colors = false;
    compare.sample_count = 40000;
    compare.original_index = reference_.index.get();
    const CompareResult compared = compare_meshes(reference_.mesh, base, compare);
    const bool is_maximum = options_.target.kind == TargetKind::kMaximumError;
    return (is_maximum ? compared.maximum / kMendable : compared.rms) / options_.target.value;
  }

  Outcome evaluate_simplified(const TriangleMesh& base) {
    Outcome outcome;
    outcome.is_simplified = true;
    outcome.base_index = nearest_base_index(static_cast<double>(base.vertex_count()));
    clock_.start("normal mesh and fit");
    CandidateOptions candidate;
    candidate.coded_level_count = 1;
    candidate.tension = 0;
    candidate.reprojection_count = 2;
    outcome.candidate = std::make_unique<Candidate>(base, surface_, reference_, candidate, options_.progress);
    search(candidate.coded_level_count, outcome);
    return outcome;
  }

  bool has_colors() const { return options_.color_psnr_db && !input_.colors.empty(); }

  /// Colours for the finest state of `outcome`; of a size the geometry has taken its share already.
  std::optional<ColorResult> colors_of(const Outcome& outcome) {
    if (!has_colors()) return std::nullopt;
    clock_.start("colours");
    report(options_.progress, "colours", 0);
    ColorOptions colors;
    colors.psnr_db = *options_.color_psnr_db;
    if (asked_target_.kind == TargetKind::kSize) {
      constexpr double kFraming = 100;  // the attribute's part of the header, and its chunks' heads
      colors.maximum_bytes =
          std::max(0.0, asked_target_.value - static_cast<double>(outcome.trial.byte_count) - kFraming);
    }
    const SubdivisionHierarchy& hierarchy = outcome.candidate->hierarchy();
    ColorResult result =
        code_colors(hierarchy, reconstruct(outcome.trial.mesh, hierarchy, hierarchy.level_count()),
                    *reference_.index, input_.colors, colors);
    result_.colors = result.report;
    clock_.start("final measurement");
    return result;
  }

  void finish() {
    clock_.start("final measurement");
    report(options_.progress, "final measurement", 0);
    // The search measures with fewer samples; the verdict is that of the full measurement.
    best_.trial.error = best_.candidate->measured_error(best_.trial);
    TrialOptions trial;
    trial.quality_layer_count = options_.quality_layer_count;
    trial.keep_correspondences = true;
    trial.is_final = true;
    if (best_.met && options_.target.kind == TargetKind::kMaximumError &&
        target_ratio(options_.target, best_.trial) > 1)
      repair_maximum_error(*best_.candidate, options_.target, description_, trial, best_.trial);
    for (int tries = 0; best_.met && target_ratio(options_.target, best_.trial) > 1 && tries < 6; ++tries) {
      const double excess = target_ratio(options_.target, best_.trial);
      const double step = best_.trial.normal_step * std::clamp(std::pow(0.995 / excess, 1.6), 0.5, 0.985);
      best_.trial = try_step(*best_.candidate, options_.target, description_, step, trial);
    }
    spend_slack();
    const std::optional<ColorResult> colors = colors_of(best_);
    result_.stream = best_.candidate->finish(best_.trial, description_, colors ? &colors->stream : nullptr);
    result_.error = result_.stream.rows.back().error;
    result_.candidate = best_.candidate->statistics();
    result_.domain = best_.domain;
    result_.level_count = best_.candidate->coded_level_count();
    Trial final_trial = best_.trial;
    final_trial.error = result_.error;
    final_trial.byte_count = result_.stream.bytes.size();
    result_.target_met = target_ratio(asked_target_, final_trial) <= 1;
    if (best_.parameterization) {  // the sphere's map was proven when it was made
      const Certificate certificate = certify(*best_.parameterization);
      result_.folded_triangle_count = certificate.flipped + certificate.degenerate;
    }
  }

  bool spends_slack() const { return options_.target.kind == TargetKind::kRmsError && options_.effort >= 4; }

  /// The search stops a little inside the target; what is left of it is worth a percent of the bytes.
  void spend_slack() {
    constexpr double kNoSlack = 0.993;
    constexpr int kTries = 3;
    if (!best_.met || !spends_slack()) return;
    TrialOptions options;
    options.quality_layer_count = options_.quality_layer_count;
    options.keep_correspondences = true;
    double too_long = std::numeric_limits<double>::infinity();
    for (int tries = 0; tries < kTries && target_ratio(options_.target, best_.trial) < kNoSlack; ++tries) {
      const double aim = 0.5 * (1 + kNoSlack) * options_.target.value, step = best_.trial.normal_step;
      const double wanted = step_for_rms(*best_.candidate, aim, noise_of(*best_.candidate, best_.trial, false), false);
      const double longer = std::min(std::clamp(wanted, 1.002 * step, 1.1 * step), std::sqrt(step * too_long));
      Trial next = try_step(*best_.candidate, options_.target, description_, longer, options);
      if (target_ratio(options_.target, next) > 1 || priced_bytes(next) >= priced_bytes(best_.trial)) {
        too_long = longer;
      } else {
        best_.trial = std::move(next);
      }
    }
    options.is_final = true;
    Trial repaired = repair_spikes(*best_.candidate, options_.target, description_, options, best_.trial);
    if (target_ratio(options_.target, repaired) <= 1) best_.trial = std::move(repaired);
  }

  const TriangleMesh& input_;
  EncodeOptions options_;
  const Target asked_target_ = options_.target;
  SearchPlan plan_;
  EncodeResult result_;
  StageClock clock_;
  TriangleMesh surface_;
  ReferenceSurface reference_;
  StreamDescription description_;
  std::vector<int> base_sizes_;
  std::optional<CollapseHistory> history_;
  std::unique_ptr<SphereParameterizedSurface> sphere_;
  double finer_ = 1;
  double tension_ = 1;
  double step_guess_ = 0;
  QuantizationNoise noise_;  // of the last candidate
  std::shared_ptr<const Parameterization> parameterization_;  // the last one, of parameterized_index_
  std::size_t parameterized_index_ = 0;
  Outcome best_;
};

}  // namespace

TriangleMesh measurable_part(const TriangleMesh& input) {
  TriangleMesh mesh;
  mesh.positions = input.positions;
  for (const Triangle& t : input.triangles) {
    const bool usable = std::all_of(t.begin(), t.end(), [&](std::uint32_t v) {
      return v < input.vertex_count() && is_finite(input.positions[v]);
    });
    if (usable) mesh.triangles.push_back(t);
  }
  for (Vec3& p : mesh.positions) {
    if (!is_finite(p)) p = {};  // not named by any triangle that is left
  }
  return mesh;
}

BoundingBox measurable_box(const TriangleMesh& input) { return bounding_box(measurable_part(input)); }

EncodeResult encode_mesh(const TriangleMesh& input, const EncodeOptions& options) {
  return MeshEncoder(input, options).run();
}

}  // namespace nmc
