// SPDX-License-Identifier: Apache-2.0
// Turns any triangle mesh into oriented manifold components, and says what it changed.
//
//   const ConditionedMesh surface = condition(read_mesh("scan.ply"), {});
//   std::cerr << to_text(surface.report);
//
// What comes out can be handed to any half-edge structure: every edge has one or two triangles that run along
// it in opposite directions, every vertex has exactly one umbrella, no triangle repeats a vertex, no two
// triangles share all three, no vertex is unused, every coordinate is finite. No new points are invented:
// each output vertex is an input vertex with the same 192 bits, its colour and its attributes. A mesh that is
// already so comes back unchanged, triangle by triangle and vertex by vertex.
#ifndef NMC_ENCODER_CONDITION_CONDITION_H_
#define NMC_ENCODER_CONDITION_CONDITION_H_

#include <cstdint>
#include <vector>

#include "encoder/condition/condition_report.h"
#include "encoder/core/progress.h"
#include "encoder/core/triangle_mesh.h"

namespace nmc {

enum class Repair {
  kAuto,     // repair what needs it and report it
  kNothing,  // leave out only what cannot be stored (non-finite and out-of-range triangles, triangles that
             // repeat a vertex, unused vertices); a mesh that is not an oriented manifold after that is
             // refused
  kStrict,   // as kAuto, but a mesh for which ConditionReport::needed_repair() holds is refused
};

struct ConditionOptions {
  Repair repair = Repair::kAuto;

  /// Vertices on open edges closer than this fraction of the diagonal are welded, but never farther apart
  /// than a tenth of all but the shortest 0.1 % of the edges. Files that store 32-bit floats far from the
  /// origin get two units in the last place of their largest coordinate if that is more. 0 welds equal
  /// positions only.
  double weld_fraction = 1e-7;
  /// Split open edges at vertices of other open edges that lie on them.
  bool close_t_junctions = true;
  /// Turn closed components whose volume is negative. Shells inside other closed components keep their side,
  /// and are turned with the outermost component around them, so the inner wall of a cavity stays an inner
  /// wall.
  bool turn_outward = true;

  /// A boundary loop is filled when it is small in all three senses; 0 edges turns filling off. Never filled
  /// under Repair::kStrict and kNothing: a hole is not a defect.
  std::size_t small_hole_edges = 30;
  double small_hole_length_fraction = 0.01;  // loop length relative to the diagonal
  double small_hole_area_fraction = 0.005;   // area of the fill relative to its component

  /// Dust: components whose box has a diagonal below `dust_diagonal_fraction` of the whole one and whose area
  /// is below `dust_area_fraction` of the whole area. Dropped only where asked, and never all there is. With
  /// the defaults dust is invisible: 1/1000 of the diagonal is one pixel of a full-screen view.
  bool drop_dust = false;
  double dust_diagonal_fraction = 1e-3;
  double dust_area_fraction = 1e-6;
};

/// Source of a triangle that fills a hole.
inline constexpr std::uint32_t kFilledHole = 0xffffffffu;

struct ConditionedMesh {
  TriangleMesh mesh;
  std::vector<std::uint32_t> source_vertex;  // output vertex -> input vertex with its position and attributes
  std::vector<std::uint32_t>
      source_triangle;  // output triangle -> input triangle it is (part of), or kFilledHole
  std::vector<std::uint32_t> component_of_triangle;  // output triangle -> index in report.components
  /// Output vertex -> lowest output vertex that was the same welded point of the input. Where two sheets were
  /// separated at a non-manifold or cut edge, their copies of it carry the same pair of numbers: the stitch
  /// table.
  std::vector<std::uint32_t> stitched_vertex;
  std::vector<TriangleFate> fate;  // one per input triangle
  ConditionReport report;
};

/// Throws nmc::Error(kInvalidInput) with the reason when nothing with an area is left (no triangle at all,
/// only non-finite vertices, all points on a line), when extents are beyond 1e-60..1e60, or as
/// `options.repair` says; kLimit from 2^30 triangles on. O(n log n); about 250 bytes per triangle beside
/// input and output. The result does not depend on the number of threads.
ConditionedMesh condition(const TriangleMesh& input, const ConditionOptions& options = {},
                          const Progress& progress = {});

}  // namespace nmc

#endif  // NMC_ENCODER_CONDITION_CONDITION_H_
