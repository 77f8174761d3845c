// SPDX-License-Identifier: Apache-2.0
// What conditioning found and changed, as numbers, as JSON and as text for a person.
#ifndef NMC_ENCODER_CONDITION_CONDITION_REPORT_H_
#define NMC_ENCODER_CONDITION_CONDITION_REPORT_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "encoder/condition/topology.h"

namespace nmc {

/// What became of one triangle of the input. Exactly one holds, so the counts of a report add up to the
/// input.
enum class TriangleFate : std::uint8_t {
  kKept,               // the same three points in the same order
  kReoriented,         // turned around to agree with its neighbours
  kSplit,              // cut at vertices that lay on its edges (T-junctions)
  kReshaped,           // a corner moved along a collapsed needle, or a diagonal was flipped
  kNonFinite,          // dropped: a corner is not a number or infinite
  kOutOfRange,         // dropped: an index without a vertex
  kDegenerate,         // dropped: two corners are the same vertex or were welded
  kDuplicate,          // dropped: an earlier triangle has the same corners
  kOppositeDuplicate,  // dropped: an earlier triangle has the same corners in opposite orientation (thin
                       // sheet)
  kSliver,             // dropped: had no area; vanished when its needle was collapsed
  kDust,               // dropped with its whole component, because dropping dust was asked for
};
inline constexpr int kTriangleFateCount = 11;
bool is_dropped(TriangleFate fate);

/// One component of the conditioned mesh.
struct ConditionedComponent : ComponentTopology {
  bool turned_inside_out = false;  // all its triangles were turned around
};

struct ConditionReport {
  // What came in.
  std::size_t input_vertices = 0, input_triangles = 0;
  std::size_t triangles_by_fate[kTriangleFateCount] = {};  // of the input; sum is input_triangles

  // Vertices.
  std::size_t non_finite_vertices = 0;    // not a number or infinite
  std::size_t unreferenced_vertices = 0;  // finite, and no usable triangle names them
  std::size_t welded_exactly = 0;         // merged into another vertex at the very same position
  std::size_t welded_nearby = 0;          // merged into another one within weld_distance
  double weld_distance = 0;               // in units of the positions
  std::size_t split_vertices = 0;         // copies added where one vertex joins several sheets of the surface

  // Shape.
  std::size_t needles_collapsed = 0, caps_flipped = 0, caps_removed = 0, slivers_left = 0;
  std::size_t t_junctions_closed = 0;  // vertices inserted into open edges
  std::size_t non_manifold_edges = 0;  // edges with more than two triangles (after duplicates were dropped)
  std::size_t non_manifold_edges_open = 0;  // of these, edges where a triangle was left without a partner
  std::size_t non_manifold_vertices = 0;    // vertices of which there is such a copy
  std::size_t cut_edges = 0;                // edges opened because the surface cannot be oriented across them
  std::size_t non_orientable_components = 0;
  std::size_t turned_components = 0;  // whole closed components that were inside out
  std::size_t filled_holes = 0, filled_hole_triangles = 0;
  double filled_hole_area = 0;
  std::size_t dust_components = 0;  // dropped

  // What goes out.
  std::size_t output_vertices = 0, output_triangles = 0;
  double diagonal = 0;
  std::vector<ConditionedComponent> components;  // ordered by their first triangle
  std::vector<BoundaryLoop> boundary_loops;      // ordered by their first half-edge

  /// One sentence per kind of defect that says where its first case is, in numbers of the input file from 0.
  std::vector<std::string> first_cases;

  std::size_t count(TriangleFate fate) const { return triangles_by_fate[static_cast<int>(fate)]; }
  std::size_t dropped_triangles() const;
  /// Sum of the components' genus.
  long total_genus() const;
  /// True when something other than welding equal positions and leaving out unreferenced vertices was needed,
  /// that is: when Repair::kStrict refuses the mesh. Filling small holes counts only where it was asked for.
  bool needed_repair() const;
};

/// A JSON object with stable camelCase keys; at most `component_limit` of the largest components and
/// `component_limit` of the longest boundary loops are listed (the totals cover all).
std::string to_json(const ConditionReport& report, std::size_t component_limit = 100);

/// At most one screen: what was repaired, dropped and found. Lines end with a newline; a mesh that needed
/// nothing gives two lines.
std::string to_text(const ConditionReport& report);

}  // namespace nmc

#endif  // NMC_ENCODER_CONDITION_CONDITION_REPORT_H_
