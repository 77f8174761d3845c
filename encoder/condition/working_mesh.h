// SPDX-License-Identifier: Apache-2.0
// The mesh as the steps of conditioning hand it to each other.
#ifndef NMC_ENCODER_CONDITION_WORKING_MESH_H_
#define NMC_ENCODER_CONDITION_WORKING_MESH_H_

#include <cstdint>
#include <string>
#include <vector>

#include "encoder/condition/condition.h"
#include "encoder/condition/half_edges.h"

namespace nmc::conditioning {

/// Kinds of defects of which a report names the first case.
enum class Defect {
  kNonFinite,
  kOutOfRange,
  kDegenerate,
  kDuplicate,
  kOppositeDuplicate,
  kNearbyVertices,
  kTJunction,
  kCrowdedEdge,
  kMisoriented,
  kNotOrientable,
  kManySheets,
  kSliver,
  kSmallHole,
  kInsideOut,
};

struct WorkingMesh {
  WorkingMesh(std::vector<TriangleFate>& input_fate, ConditionReport& input_report)
      : fate(input_fate), report(input_report) {}

  /// One per input vertex, then one per copy made by split_vertices(). Relative to the centre of the bounding
  /// box, so that a millimetre at 1e7 units from the origin keeps its bits in products and differences.
  std::vector<Vec3> positions;
  /// Vertices as currently welded.
  std::vector<Triangle> triangles;
  /// The same corners as the file had them. Two triangles that share both vertices of an edge here were
  /// joined by whoever wrote the file; that is believed before geometry is asked, and it is what makes a
  /// second conditioning change nothing.
  std::vector<Triangle> stored;
  std::vector<std::uint32_t> source;    // input triangle of each triangle, or kFilledHole
  std::vector<std::uint8_t> is_turned;  // whether it runs the other way than that one
  std::vector<TriangleFate>& fate;      // of the input triangles
  ConditionReport& report;

  /// Removes the triangles for which fate_of(t) is a dropping fate, keeping the order.
  template <class FateOf>
  std::size_t drop(const FateOf& fate_of) {
    std::size_t kept = 0;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      const TriangleFate what = fate_of(t);
      if (is_dropped(what)) {
        if (source[t] != kFilledHole) fate[source[t]] = what;
        continue;
      }
      triangles[kept] = triangles[t];
      stored[kept] = stored[t];
      source[kept] = source[t];
      is_turned[kept] = is_turned[t];
      ++kept;
    }
    const std::size_t dropped = triangles.size() - kept;
    triangles.resize(kept);
    stored.resize(kept);
    source.resize(kept);
    is_turned.resize(kept);
    return dropped;
  }

  Vec3 area_normal(std::size_t t) const {
    const Vec3& a = positions[triangles[t][0]];
    return cross(positions[triangles[t][1]] - a, positions[triangles[t][2]] - a);
  }

  /// Remembers the sentence for the first defect of its kind; `sentence` is a function, called only for that
  /// one.
  template <class Sentence>
  void note(Defect defect, const Sentence& sentence) {
    const std::uint32_t bit = 1u << static_cast<int>(defect);
    if (noted_defects & bit) return;
    noted_defects |= bit;
    report.first_cases.push_back(sentence());
  }
  std::uint32_t noted_defects = 0;
};

}  // namespace nmc::conditioning

#endif  // NMC_ENCODER_CONDITION_WORKING_MESH_H_
