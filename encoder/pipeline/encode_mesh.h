// SPDX-License-Identifier: Apache-2.0
// The whole encoder: mesh in, bytes out.
#ifndef NMC_ENCODER_PIPELINE_ENCODE_MESH_H_
#define NMC_ENCODER_PIPELINE_ENCODE_MESH_H_

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "encoder/condition/condition_report.h"
#include "encoder/core/triangle_mesh.h"
#include "encoder/pipeline/candidate.h"
#include "encoder/pipeline/encode_options.h"
#include "encoder/pipeline/serialize.h"

namespace nmc {

/// Seconds of one stage.
struct StageTime {
  std::string stage;
  double seconds = 0;
};

struct EncodeResult {
  StreamBytes stream;
  MeasuredError error;             // of the finest state, measured on the decoded positions
  bool target_met = false;
  double diagonal = 0;
  ConditionReport condition;
  DomainChoice domain = DomainChoice::kGeneral;  // of the stream; never kAuto
  CandidateStatistics candidate;
  std::size_t folded_triangle_count = 0;  // of the map
  int level_count = 0;             // coded levels
  std::optional<ColorReport> colors;  // where the stream has them
  std::vector<StageTime> times;
  /// Every (base size, bytes, error) that was tried, in order.
  struct Attempt {
    std::uint32_t base_vertex_count = 0;
    int level_count = 0;
    double normal_step = 0;
    std::size_t byte_count = 0;
    MeasuredError error;
  };
  std::vector<Attempt> attempts;
};

/// The part of the input that can be measured against: every finite triangle, as it was read; positions only.
TriangleMesh measurable_part(const TriangleMesh& input);

/// The box that errors are relative to: of the triangles whose corners are all finite. All zero without any.
BoundingBox measurable_box(const TriangleMesh& input);

/// Encodes `input`. Throws nmc::Error where the input cannot be used; a target that cannot be reached is not an
/// exception: the nearest stream comes back with target_met false. Deterministic for any number of threads.
EncodeResult encode_mesh(const TriangleMesh& input, const EncodeOptions& options);

}  // namespace nmc

#endif  // NMC_ENCODER_PIPELINE_ENCODE_MESH_H_
