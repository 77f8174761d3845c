// SPDX-License-Identifier: Apache-2.0
#include "encoder/pipeline/target_search.h"

#include <catch2/catch.hpp>
#include <memory>

#include "tests/unit/fit/bumpy_sphere.h"

namespace nmc {
namespace {

Trial trial_of(double rms, double maximum, std::size_t byte_count) {
  Trial trial;
  trial.error = {rms, maximum};
  trial.byte_count = byte_count;
  return trial;
}

TEST_CASE("repaired spikes: kept where they cost little", "[target]") {
  const Trial trial = trial_of(1e-4, 1.66e-3, 5000);
  CHECK(repair_pays(trial, trial_of(1e-4, 1e-3, 5050)));
  CHECK_FALSE(repair_pays(trial, trial_of(1e-4, 1e-3, 5200)));
  CHECK(repair_pays(trial, trial_of(0.9e-4, 1e-3, 5400)));
}

TEST_CASE("repaired spikes: never kept where the largest error has grown", "[target]") {
  const Trial trial = trial_of(1e-4, 1.66e-3, 5000);
  CHECK_FALSE(repair_pays(trial, trial_of(1e-4, 1.72e-3, 5010)));
  CHECK_FALSE(repair_pays(trial, trial_of(0.999e-4, 1.66e-3, 4990)));
}

TriangleMesh bumpy_sphere(int level_count) {
  const NormalMesh mesh = interpolating_mesh(BumpySphere{}, level_count);
  TriangleMesh result;
  result.positions = reconstruct(mesh, level_count);
  result.triangles = level_triangles(mesh.hierarchy.level(level_count));
  return result;
}

TEST_CASE("repaired spikes: a file's largest error is at most eight RMS errors where integers reach", "[target]") {
  ReferenceSurface reference;
  reference.mesh = bumpy_sphere(6);
  reference.index = std::make_unique<SurfaceIndex>(reference.mesh);
  StreamDescription description;
  description.box = bounding_box(reference.mesh);
  reference.diagonal = description.box.diagonal();
  CandidateOptions options;
  options.coded_level_count = 2;
  Candidate candidate(bumpy_sphere(3), reference.mesh, reference, options);
  TrialOptions trial_options;
  trial_options.is_final = true;
  Trial trial = candidate.quantize(2e-3, description, trial_options);
  const Target target{TargetKind::kRmsError, 1.2 * trial.error.rms};
  // Beyond eight RMS errors by little, so that it shows between the vertices of a few faces only.
  const int spike = static_cast<int>(10 * target.value / trial.normal_step);
  for (const std::size_t edge : {17u, 140u, 141u, 700u}) trial.mesh.normal.back()[edge] += edge % 2 == 0 ? spike : -spike;
  trial.mesh.normal.front()[33] += static_cast<int>(9 * target.value / trial.mesh.quantizers.front().normal_step);
  trial.error = candidate.measured_error(trial);
  REQUIRE(trial.error.maximum > 8.5 * target.value);
  const Trial repaired = repair_spikes(candidate, target, description, trial_options, trial);
  CHECK(repaired.error.maximum <= 8 * target.value);
  CHECK(repaired.error.rms <= trial.error.rms);
}

}  // namespace
}  // namespace nmc
