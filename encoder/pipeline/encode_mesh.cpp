// SPDX-License-Identifier: Apache-2.0
#include "encoder/pipeline/encode_mesh.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "encoder/core/error.h"
#include "encoder/domain/certificate.h"
#include "encoder/domain/maps_collapse.h"
#include "encoder/domain/relaxation.h"
#include "encoder/measure/compare_meshes.h"
#include "encoder/pipeline/target_search.h"

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

/// The part of the input that can be measured against: every finite triangle, as it was read.
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

/// How hard to look for the best base size, by effort.
struct SearchPlan {
  int extra_candidates;
  int trials_per_candidate;
};
SearchPlan plan_of(int effort) {
  constexpr SearchPlan kPlans[9] = {{0, 3}, {0, 4}, {0, 5}, {1, 4}, {2, 4}, {3, 5}, {4, 6}, {6, 6}, {8, 8}};
  return kPlans[std::clamp(effort, 1, 9) - 1];
}

class MeshEncoder {
 public:
  MeshEncoder(const TriangleMesh& input, const EncodeOptions& options)
      : input_(input), options_(options), plan_(plan_of(options.effort)), clock_(result_.times) {}

  EncodeResult run() {
    prepare();
    choose();
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
    bool met = false;
  };

  void prepare() {
    clock_.start("condition");
    report(options_.progress, "conditioning", 0);
    ConditionedMesh conditioned = condition(input_, options_.condition);
    result_.condition = conditioned.report;
    surface_ = std::move(conditioned.mesh);

    reference_.mesh = measurable_part(input_);
    reference_.index = std::make_unique<SurfaceIndex>(reference_.mesh);
    description_.box = bounding_box(reference_.mesh);
    reference_.diagonal = result_.diagonal = description_.box.diagonal();
    description_.input_vertex_count = input_.vertex_count();
    description_.input_triangle_count = input_.triangle_count();
    description_.units = options_.units;
    description_.up_axis = options_.up_axis;

    clock_.start("collapse");
    report(options_.progress, "base mesh", 0);
    const int largest = static_cast<int>(std::min<std::size_t>(surface_.vertex_count(), 8000));
    if (options_.base_vertex_count) {
      base_sizes_ = {*options_.base_vertex_count};
    } else {
      for (double size = 32; size < largest; size *= 1.5) base_sizes_.push_back(static_cast<int>(size));
      if (base_sizes_.empty()) base_sizes_.push_back(largest);
    }
    CollapseOptions collapse;
    collapse.crease_angle_degrees = options_.crease_angle_degrees;
    history_ = maps_collapse(surface_, base_sizes_, collapse, options_.progress);
  }

  /// The error that the target stands for, relative to the diagonal; for a size, what a typical scan reaches.
  double relative_target() const {
    const double value = options_.target.value / result_.diagonal;
    switch (options_.target.kind) {
      case TargetKind::kMaximumError:
        return value / 8;  // RMS errors are about an eighth of the maximum
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
    std::size_t best = 0;
    for (std::size_t i = 1; i < base_sizes_.size(); ++i) {
      if (std::abs(std::log(base_sizes_[i] / wanted)) < std::abs(std::log(base_sizes_[best] / wanted))) best = i;
    }
    return best;
  }

  int level_count_for(std::size_t base_index) const {
    if (options_.level_count) return *options_.level_count;
    // As many vertices as the error asks of a smooth surface, but no more than the input can fill.
    const double vertices = static_cast<double>(surface_.vertex_count());
    const double error = relative_target();
    const double wanted =
        finer_ * std::min(vertices * std::min(1.5, 7e-5 / error), 10 / error);
    const double ratio = std::max(1.0, wanted / base_sizes_[base_index]);
    return std::clamp(static_cast<int>(std::ceil(std::log(ratio) / std::log(4.0) - 0.2)), 1, 8);
  }

  Outcome evaluate(std::size_t base_index) {
    Outcome outcome;
    outcome.base_index = base_index;
    clock_.start("parameterize");
    report(options_.progress, "parameterization", 0);
    outcome.parameterization = std::make_shared<const Parameterization>(relax(*history_, base_index));
    clock_.start("normal mesh and fit");
    CandidateOptions candidate;
    candidate.coded_level_count = level_count_for(base_index);
    outcome.candidate =
        std::make_unique<Candidate>(outcome.parameterization, reference_, candidate, options_.progress);
    clock_.start("quantize");
    report(options_.progress, "quantization", 0);
    TargetSearchOptions search;
    search.maximum_trials = plan_.trials_per_candidate;
    search.trial.measure_sample_count = 60000;
    const double first_step =
        step_guess_ > 0 ? step_guess_
                        : result_.diagonal * 2e-3 * std::pow(relative_target() / 1.8e-4, 1.6);
    TargetSearchResult found =
        search_target(*outcome.candidate, options_.target, description_, first_step, search);
    for (const Trial& t : found.trials) {
      result_.attempts.push_back({outcome.candidate->statistics().base_vertex_count, candidate.coded_level_count,
                                  t.normal_step, t.byte_count, t.error});
    }
    outcome.met = found.best.has_value();
    outcome.trial = std::move(outcome.met ? *found.best : *found.nearest);
    step_guess_ = outcome.trial.normal_step;
    return outcome;
  }

  bool better(const Outcome& a, const Outcome& b) const {
    if (a.met != b.met) return a.met;
    if (!a.met) return target_ratio(options_.target, a.trial) < target_ratio(options_.target, b.trial);
    return options_.target.kind == TargetKind::kSize ? a.trial.error.rms < b.trial.error.rms
                                                     : a.trial.byte_count < b.trial.byte_count;
  }

  /// Hill climbing over the base sizes: bytes at equal error have one minimum over them.
  void choose() {
    std::size_t index = first_base_index();
    best_ = evaluate(index);
    int left = plan_.extra_candidates;
    // A target out of reach: more base vertices see more features, another level resolves them.
    for (int tries = 0; !best_.met && tries < 3 + plan_.extra_candidates; ++tries) {
      step_guess_ = 0;
      if (best_.base_index + 1 < base_sizes_.size()) {
        index = std::min(best_.base_index + 2, base_sizes_.size() - 1);
      }
      finer_ *= options_.level_count ? 1 : 1.6;
      Outcome next = evaluate(index);
      const bool improved = better(next, best_);
      if (improved) best_ = std::move(next);
      if (!improved && tries > 0) break;
      if (options_.base_vertex_count && options_.level_count) break;
    }
    if (!best_.met) return;
    for (const int direction : {1, -1}) {
      bool moved = false;
      while (left > 0) {
        const auto next_index = static_cast<std::ptrdiff_t>(best_.base_index) + direction;
        if (next_index < 0 || next_index >= static_cast<std::ptrdiff_t>(base_sizes_.size())) break;
        --left;
        Outcome next = evaluate(static_cast<std::size_t>(next_index));
        if (!better(next, best_)) break;
        best_ = std::move(next);
        moved = true;
      }
      if (moved) break;  // the minimum lies on this side
    }
  }

  void finish() {
    clock_.start("final measurement");
    report(options_.progress, "final measurement", 0);
    result_.stream = best_.candidate->finish(best_.trial, description_);
    result_.error = result_.stream.rows.back().error;
    result_.candidate = best_.candidate->statistics();
    result_.level_count = best_.candidate->coded_level_count();
    // The search measures with fewer samples; the verdict is that of the full measurement.
    Trial final_trial = best_.trial;
    final_trial.error = result_.error;
    for (int tries = 0; best_.met && target_ratio(options_.target, final_trial) > 1 && tries < 3; ++tries) {
      TrialOptions trial;
      best_.trial = best_.candidate->quantize(best_.trial.normal_step * 0.985, description_, trial);
      result_.stream = best_.candidate->finish(best_.trial, description_);
      result_.error = result_.stream.rows.back().error;
      final_trial = best_.trial;
      final_trial.error = result_.error;
    }
    final_trial.byte_count = result_.stream.bytes.size();
    result_.target_met = target_ratio(options_.target, final_trial) <= 1;
    const Certificate certificate = certify(*best_.parameterization);
    result_.folded_triangle_count = certificate.flipped + certificate.degenerate;
  }

  const TriangleMesh& input_;
  const EncodeOptions& options_;
  SearchPlan plan_;
  EncodeResult result_;
  StageClock clock_;
  TriangleMesh surface_;
  ReferenceSurface reference_;
  StreamDescription description_;
  std::vector<int> base_sizes_;
  std::optional<CollapseHistory> history_;
  double finer_ = 1;
  double step_guess_ = 0;
  Outcome best_;
};

}  // namespace

EncodeResult encode_mesh(const TriangleMesh& input, const EncodeOptions& options) {
  return MeshEncoder(input, options).run();
}

}  // namespace nmc
