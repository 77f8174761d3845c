// SPDX-License-Identifier: Apache-2.0
#include "encoder/normal_mesh/flip_test.h"

#include <algorithm>

#include "encoder/core/parallel.h"

namespace nmc {

namespace {

// Each round demotes at least one vertex of every failing face and a vertex can be demoted twice, so six
// rounds settle a face alone; neighbours that disturb each other take a few more.
constexpr int kRoundLimit = 16;

struct FaceVerdict {
  std::uint32_t edge = kNone;  // to be demoted
  bool folded_parent = false;
};

FaceVerdict judge_face(const ParameterizedSurface& map, const LevelTopology& topology, int level,
                       std::span<const SurfaceParameter> parameters, double least_child_area,
                       const std::vector<OddVertexChoice>& choices, std::uint32_t face) {
  FaceVerdict verdict;
  const std::uint32_t* v = topology.face_vertices.data() + std::size_t{3} * face;
  const std::uint32_t* e = topology.face_edges.data() + std::size_t{3} * face;
  const SurfaceParameter corners[3] = {parameters[v[0]], parameters[v[1]], parameters[v[2]]};
  LocalChart chart;
  ChartPoint q[3], m[3];
  bool laid_out = map.make_chart(face >> (2 * level), corners, chart, q);
  const double parent = laid_out ? face_ratio(q[0], q[1], q[2]) : 0;
  if (!(parent > 0)) {
    verdict.folded_parent = true;
    return verdict;
  }
  for (int k = 0; k < 3 && laid_out; ++k) laid_out = map.to_chart(chart, choices[e[k]].parameter, m[k]);
  const double least = least_child_area * parent;
  if (laid_out && face_ratio(q[0], m[2], m[1]) >= least && face_ratio(m[2], q[1], m[0]) >= least &&
      face_ratio(m[1], m[0], q[2]) >= least && face_ratio(m[0], m[1], m[2]) >= least) {
    return verdict;
  }
  double worst = -1;
  for (int k = 0; k < 3; ++k) {
    if (choices[e[k]].source == OddVertexSource::kMidpoint) continue;
    const ChartPoint side = q[(k + 2) % 3] - q[(k + 1) % 3];
    const ChartPoint middle = 0.5 * (q[(k + 1) % 3] + q[(k + 2) % 3]);
    const double deviation = laid_out ? squared_length(m[k] - middle) / squared_length(side) : 1;
    if (deviation > worst) {
      worst = deviation;
      verdict.edge = e[k];
    }
  }
  return verdict;
}

}  // namespace

FlipTestResult resolve_flips(const ParameterizedSurface& map, const LevelTopology& topology, int level,
                             std::span<const SurfaceParameter> parameters, double least_child_area,
                             std::vector<OddVertexChoice>& choices) {
  FlipTestResult result;
  std::vector<std::uint32_t> suspects(topology.face_count);
  for (std::uint32_t f = 0; f < topology.face_count; ++f) suspects[f] = f;
  for (int round = 0; round < kRoundLimit && !suspects.empty(); ++round) {
    std::vector<FaceVerdict> verdicts(suspects.size());
    parallel_for(suspects.size(), [&](std::size_t i) {
      verdicts[i] = judge_face(map, topology, level, parameters, least_child_area, choices, suspects[i]);
    });
    std::vector<std::uint32_t> demoted;
    for (const FaceVerdict& verdict : verdicts) {
      if (round == 0 && verdict.folded_parent) ++result.folded_face_count;
      if (verdict.edge != kNone) demoted.push_back(verdict.edge);
    }
    std::sort(demoted.begin(), demoted.end());
    demoted.erase(std::unique(demoted.begin(), demoted.end()), demoted.end());
    suspects.clear();
    for (const std::uint32_t edge : demoted) {
      OddVertexChoice& choice = choices[edge];
      if (choice.source == OddVertexSource::kPierced) ++result.demoted_count;
      const bool to_midpoint = choice.source == OddVertexSource::kPredicted || round + 3 > kRoundLimit;
      choice.source = to_midpoint ? OddVertexSource::kMidpoint : OddVertexSource::kPredicted;
      choice.parameter = to_midpoint ? choice.midpoint : choice.predicted;
      for (int side = 0; side < 2; ++side) {
        const std::uint32_t face = topology.edge_faces[2 * edge + side];
        if (face != kNone) suspects.push_back(face);
      }
    }
    std::sort(suspects.begin(), suspects.end());
    suspects.erase(std::unique(suspects.begin(), suspects.end()), suspects.end());
  }
  return result;
}

}  // namespace nmc
