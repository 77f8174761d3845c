// SPDX-License-Identifier: Apache-2.0
#include "bench/ablation/scan.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>

#include "encoder/condition/condition.h"
#include "encoder/core/error.h"
#include "encoder/domain/parameterize.h"
#include "encoder/measure/compare_meshes.h"
#include "encoder/pipeline/encode_mesh.h"
#include "encoder/read/mesh_reader.h"

namespace nmc_bench {

Scan read_scan(const std::string& path) {
  Scan scan;
  scan.name = std::filesystem::path(path).stem().string();
  scan.input = read_mesh(path);
  scan.surface = condition(scan.input).mesh;
  scan.reference.mesh = measurable_part(scan.input);
  scan.description.box = bounding_box(scan.reference.mesh);
  scan.reference.center = scan.description.box.center();
  for (Vec3& p : scan.reference.mesh.positions) p -= scan.reference.center;
  for (Vec3& p : scan.surface.positions) p -= scan.reference.center;
  scan.reference.index = std::make_unique<SurfaceIndex>(scan.reference.mesh);
  scan.reference.diagonal = scan.description.box.diagonal();
  scan.description.input_vertex_count = scan.input.vertex_count();
  scan.description.input_triangle_count = scan.input.triangle_count();
  return scan;
}

std::shared_ptr<const Parameterization> parameterization_of(const Scan& scan, int vertex_count) {
  return std::make_shared<const Parameterization>(
      std::move(parameterize(scan.surface, {vertex_count}).front()));
}

Steps steps_of(const Scan& scan, double finest_normal_step, int level_count, const TrialOptions& options) {
  Steps steps;
  steps.stream = stream_steps(finest_normal_step, level_count, options.eighths_per_level,
                              options.eighths_base_to_level_0, options.eighths_tangential);
  steps.quantize = quantize_options(steps.stream, level_count, scan.description, scan.reference.center, options);
  return steps;
}

MeasuredError error_of(const Scan& scan, const Coded& coded, std::size_t sample_count) {
  const int level = coded.mesh.level_count() + coded.mesh.smoothing_level_count;
  TriangleMesh decoded;
  decoded.positions = reconstruct(coded.mesh, *coded.hierarchy, level);
  decoded.triangles = level_triangles(coded.hierarchy->level(level));
  CompareOptions options;
  options.normals = false;
  options.colors = false;
  options.sample_count = sample_count;
  options.original_index = scan.reference.index.get();
  const CompareResult compared = compare_meshes(scan.reference.mesh, decoded, options);
  return {compared.rms, compared.maximum};
}

Coded closest_below(const Scan& scan, const Quantize& quantize, double rms, double first_step) {
  constexpr int kTrials = 10;
  constexpr double kCloseEnough = 0.99;
  constexpr double kNear = 0.03;
  struct Point {
    double log_step, log_ratio;
  };
  std::optional<Point> meets, fails;
  std::optional<Coded> best;
  double log_step = std::log(first_step);
  for (int i = 0; i < kTrials; ++i) {
    Coded coded = quantize(std::exp(log_step));
    if (coded.error.rms == 0) coded.error = error_of(scan, coded, kFewSamples);
    if (std::abs(std::log(coded.error.rms / rms)) < kNear) coded.error = error_of(scan, coded, 0);
    const Point point{log_step, std::log(coded.error.rms / rms)};
    const bool met = point.log_ratio <= 0;
    if (met && (!best || coded.error.rms > best->error.rms)) best = std::move(coded);
    if (met && point.log_ratio >= std::log(kCloseEnough)) break;
    if (!met && fails && point.log_ratio > 0.95 * fails->log_ratio && point.log_step < fails->log_step - 0.5)
      break;
    const std::optional<Point> last = met ? meets : fails;
    (met ? meets : fails) = point;
    const double aim = 0.5 * std::log(kCloseEnough);
    if (meets && fails) {
      const double part = (aim - meets->log_ratio) / (fails->log_ratio - meets->log_ratio);
      log_step = meets->log_step +
                 std::clamp(std::isfinite(part) ? part : 0.5, 0.1, 0.9) * (fails->log_step - meets->log_step);
    } else {
      constexpr double kUsualSlope = 0.8;
      double slope = kUsualSlope;
      if (last)
        slope = std::clamp((point.log_ratio - last->log_ratio) / (point.log_step - last->log_step), 0.3, 1.2);
      log_step += std::clamp((aim - point.log_ratio) / slope, -1.0, 1.0);
    }
  }
  if (!best) throw Error(ExitCode::kTargetNotMet, "no step reaches the error: the mesh is too coarse for it");
  best->error = error_of(scan, *best, 0);
  best->byte_count =
      serialize({&best->mesh}, 1, *best->hierarchy, best->base_creases, best->steps, scan.description)
          .bytes.size();
  return std::move(*best);
}

}  // namespace nmc_bench
