// SPDX-License-Identifier: Apache-2.0
#include "bench/ablation/rows.h"

#include <cmath>
#include <utility>

#include "encoder/core/error.h"
#include "encoder/fit/closed_loop.h"
#include "encoder/fit/round_mesh.h"
#include "encoder/pipeline/encode_mesh.h"
#include "encoder/pipeline/renumber.h"
#include "libnmc/common/format.h"

namespace nmc_bench {

namespace {

NormalMesh in_stream_order(const NormalMesh& mesh, const StreamOrder& order) {
  std::vector<SurfaceSample> no_samples;
  return renumber(mesh, order, no_samples);
}

/// A hierarchy that outlives what is coded on it.
std::shared_ptr<const SubdivisionHierarchy> borrowed(const SubdivisionHierarchy& hierarchy) {
  return {std::shared_ptr<const void>(), &hierarchy};
}

/// Where the searches begin: steps of the finest level over the error.
constexpr double kFirstStep = 8, kFirstStepOneGo = 6;

class Ablation {
 public:
  Ablation(const Scan& scan, const AblationOptions& options)
      : scan_(scan),
        options_(options),
        parameterization_(parameterization_of(scan, options.base_vertex_count)),
        surface_(*parameterization_),
        index_(surface_.surface()),
        base_(base_of(*parameterization_)),
        order_(stream_order(SubdivisionHierarchy(
            base_.faces, static_cast<std::uint32_t>(base_.positions.size()), 0, base_.creases))),
        rows_(options.errors.size()) {}

  std::vector<std::vector<Row>> run() {
    const int level_count = options_.level_count;
    with_more_levels("open loop", [&](int levels) { return open_loop(levels); });
    with_more_levels("closed loop", [&](int levels) { return closed_loop(levels); });
    CandidateOptions candidate;
    candidate.coded_level_count = level_count;
    {
      Candidate fitted(parameterization_, scan_.reference, candidate);
      const Quantize quantize = rounded(fitted.fitted_mesh(), fitted.base_creases(), level_count);
      for (std::size_t i = 0; i < rows_.size(); ++i)
        add("fit, rounded", i, level_count, quantize, kFirstStepOneGo);
      add_quantized("fit, quantized", fitted);
    }
    add_smoothed();
    return std::move(rows_);
  }

 private:
  /// One go, no feedback.
  Quantize rounded(const NormalMesh& mesh, const std::vector<std::uint8_t>& base_creases,
                   int level_count) const {
    return [this, &mesh, &base_creases, level_count](double step) {
      const Steps steps = steps_of(scan_, step, level_count, {});
      return Coded{steps.stream,
                   round_mesh(mesh, level_count, steps.quantize),
                   borrowed(mesh.hierarchy),
                   base_creases,
                   0,
                   {}};
    };
  }

  Quantize open_loop(int level_count) {
    InterpolatingOptions interpolating;
    interpolating.level_count = level_count;
    interpolated_ = in_stream_order(interpolate(surface_, index_, base_, interpolating).mesh, order_);
    return rounded(interpolated_, order_.base_creases, level_count);
  }

  Quantize closed_loop(int level_count) const {
    return [this, level_count](double step) {
      const Steps steps = steps_of(scan_, step, level_count, {});
      ClosedLoopOptions closed;
      closed.interpolating.level_count = level_count;
      closed.quantize = steps.quantize;
      const auto mesh = std::make_shared<const NormalMesh>(
          in_stream_order(quantize_closed_loop(surface_, index_, base_, closed), order_));
      QuantizeOptions whole_steps = steps.quantize;
      whole_steps.dead_zone = 0.5;
      return Coded{steps.stream,
                   round_mesh(*mesh, level_count, whole_steps),
                   std::shared_ptr<const SubdivisionHierarchy>(mesh, &mesh->hierarchy),
                   order_.base_creases,
                   0,
                   {}};
    };
  }

  /// An interpolating mesh may lie outside an error whatever the step.
  template <class Make>
  void with_more_levels(const std::string& name, const Make& make) {
    constexpr int kMoreLevels = 2;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      for (int levels = options_.level_count;; ++levels) {
        if (add(name, i, levels, make(levels), kFirstStepOneGo, levels == options_.level_count + kMoreLevels))
          break;
      }
    }
  }

  /// Not met where no step reaches the error.
  Row made(const std::string& name, std::size_t error, int level_count, const Quantize& quantize,
           double first_step) const {
    Row row{name, base_size(), level_count, 0, 0, {}, {}};
    try {
      const Coded coded =
          closest_below(scan_, quantize, options_.errors[error], first_step * options_.errors[error]);
      row.step = coded.steps.normal_step(level_count - 1);
      row.byte_count = coded.byte_count;
      row.bits = coefficient_bits(coded.mesh, *coded.hierarchy);
      row.error = coded.error;
    } catch (const Error& failure) {
      if (failure.code() != ExitCode::kTargetNotMet) throw;
    }
    return row;
  }

  /// False, and no row, where no step reaches the error and `stores_failure` is not set.
  bool add(const std::string& name, std::size_t error, int level_count, const Quantize& quantize,
           double first_step, bool stores_failure = true) {
    Row row = made(name, error, level_count, quantize, first_step);
    if (!row.is_met() && !stores_failure) return false;
    store(error, std::move(row));
    return true;
  }

  static Quantize quantized(const Scan& scan, Candidate& candidate) {
    return [&scan, &candidate, is_first = true](double step) mutable {
      TrialOptions trial_options;
      trial_options.measure_sample_count = static_cast<int>(kFewSamples);
      trial_options.keep_correspondences = !std::exchange(is_first, false);
      Trial trial = candidate.quantize(step, scan.description, trial_options);
      return Coded{
          trial.steps, std::move(trial.mesh), borrowed(candidate.hierarchy()), candidate.base_creases(), 0,
          trial.error};
    };
  }

  void add_quantized(const std::string& name, Candidate& candidate) {
    const Quantize quantize = quantized(scan_, candidate);
    for (std::size_t i = 0; i < rows_.size(); ++i) add(name, i, options_.level_count, quantize, kFirstStep);
  }

  /// One more level, predicted only: above all coded levels or in the place of the last, whichever takes
  /// fewer bytes.
  void add_smoothed() {
    std::vector<Row> best(rows_.size());
    for (Row& row : best) row.name = "+ smoothing level";
    for (const int coded : {options_.level_count - 1, options_.level_count}) {
      CandidateOptions options;
      options.coded_level_count = coded;
      options.smoothing_level_count = 1;
      std::unique_ptr<Candidate> candidate;
      for (std::size_t i = 0; i < rows_.size(); ++i) {
        if (best[i].is_met() && least_byte_count(coded + 1) >= best[i].byte_count) continue;
        if (!candidate) candidate = std::make_unique<Candidate>(parameterization_, scan_.reference, options);
        Row row = made(best[i].name, i, coded, quantized(scan_, *candidate), kFirstStep);
        if (row.is_met() && (!best[i].is_met() || row.byte_count < best[i].byte_count))
          best[i] = std::move(row);
      }
    }
    for (std::size_t i = 0; i < rows_.size(); ++i) store(i, std::move(best[i]));
  }

  /// Streams of so many levels are filled up to this: no decoder takes more vertices from fewer bytes
  /// (spec 8.2).
  std::size_t least_byte_count(int level) const {
    const std::size_t vertex_count = (base_.faces.size() << (2 * level)) / 2;
    return vertex_count > kFreeVertices ? (vertex_count - kFreeVertices) / kVerticesPerByte : 0;
  }

  std::uint32_t base_size() const { return static_cast<std::uint32_t>(base_.positions.size()); }

  void store(std::size_t error, Row row) {
    if (options_.done) options_.done(error, row);
    rows_[error].push_back(std::move(row));
  }

  const Scan& scan_;
  const AblationOptions& options_;
  std::shared_ptr<const Parameterization> parameterization_;
  DomainParameterizedSurface surface_;
  SurfaceIndex index_;
  ParameterizedBase base_;
  StreamOrder order_;
  NormalMesh interpolated_;
  std::vector<std::vector<Row>> rows_;
};

}  // namespace

std::vector<std::vector<Row>> ablate(const Scan& scan, const AblationOptions& options) {
  return Ablation(scan, options).run();
}

Row whole_encoder(const Scan& scan, double rms, int effort) {
  EncodeOptions encode;
  encode.effort = effort;
  encode.target = {TargetKind::kRmsError, rms};
  encode.color_psnr_db.reset();
  const EncodeResult result = encode_mesh(scan.input, encode);
  Row row{kWholeEncoder, result.candidate.base_vertex_count, result.level_count, 0, 0, {}, result.error};
  if (result.target_met) row.byte_count = result.stream.bytes.size();
  return row;
}

}  // namespace nmc_bench
