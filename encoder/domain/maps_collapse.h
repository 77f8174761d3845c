// SPDX-License-Identifier: Apache-2.0
// From a surface to base meshes: half-edge collapses by quadrics, recorded so that they can be undone.
//
// Based on: Lee et al., "MAPS" (1998), with half-edge collapses by quadric error (Garland, Heckbert 1997;
// line quadrics on boundaries and creases) instead of independent sets, so that base vertices are input
// vertices and every step touches one star. The points of the surface are not carried down as in MAPS but
// placed on the way back up (relaxation.h), where every one of them can be put into the kernel of its link.
#ifndef NMC_ENCODER_DOMAIN_MAPS_COLLAPSE_H_
#define NMC_ENCODER_DOMAIN_MAPS_COLLAPSE_H_

#include <cstdint>
#include <memory>
#include <vector>

#include "encoder/core/progress.h"
#include "encoder/core/triangle_mesh.h"
#include "encoder/domain/corner_table.h"

namespace nmc {

struct CollapseOptions {
  /// Edges whose dihedral angle exceeds this (degrees) start creases, which are kept as base edge paths; 0:
  /// none.
  double crease_angle_degrees = 0;
  /// Weight of the fourth power of the edge length against the quadric error, which has the same unit: keeps
  /// base triangles round where the surface is flat.
  double length_weight = 2e-3;
  /// Tips of limbs (extremities.h) stay while they are at most this share of the vertices; least prominence
  /// of a tip relative to the square root of the surface area.
  double extremity_share = 0.25;
  double extremity_prominence = 0.04;
};

/// What a vertex may do: kSmooth moves in two dimensions, kChain along a boundary loop or crease, kLocked
/// (crease corner, or a boundary corner when creases are kept) is in every base.
enum class VertexKind : std::uint8_t { kSmooth, kChain, kLocked };

/// A run of collapses, from the surface to its smallest base.
struct CollapseHistory {
  std::shared_ptr<const TriangleMesh> surface;  // the input with chords split (see Parameterization::surface)
  std::size_t input_vertex_count = 0;
  CornerTable coarsest;                    // after all steps
  std::vector<CornerTable::Corner> steps;  // arguments of CornerTable::collapse, in order
  std::vector<std::size_t>
      base_step_counts;                   // how many steps lead to each requested base, in the order asked
  std::vector<VertexKind> kinds;          // per surface vertex
  std::vector<std::uint8_t> extremities;  // per surface vertex: 1 where it is the tip of a limb; may be empty
  std::vector<std::uint8_t> crease_corners;  // per corner: 1 where the edge opposite it is a crease

  /// True where the edge opposite c is on the boundary or on a crease of the table's present state.
  bool is_chain_edge(const CornerTable& table, CornerTable::Corner c) const {
    const CornerTable::Corner d = table.opposite(c);
    if (table.is_ghost_face(CornerTable::face_of(c)) != table.is_ghost_face(CornerTable::face_of(d)))
      return true;
    return !crease_corners.empty() && (crease_corners[c] != 0 || crease_corners[d] != 0);
  }
};

/// Collapses `mesh` through all of `base_sizes` (numbers of vertices). A size that cannot be reached gets the
/// smallest base that can. O(n log n).
CollapseHistory maps_collapse(const TriangleMesh& mesh, const std::vector<int>& base_sizes,
                              const CollapseOptions& options = {}, const Progress& progress = {});

}  // namespace nmc

#endif  // NMC_ENCODER_DOMAIN_MAPS_COLLAPSE_H_
