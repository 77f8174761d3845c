// SPDX-License-Identifier: Apache-2.0
// Which triangles have to be turned around so that all neighbours agree.
#ifndef NMC_ENCODER_CONDITION_SIDES_H_
#define NMC_ENCODER_CONDITION_SIDES_H_

#include <cstdint>
#include <vector>

#include "encoder/condition/parity_sets.h"
#include "encoder/condition/working_mesh.h"

namespace nmc::conditioning {

/// Connected pieces of a mesh and how each of their triangles is turned relative to the file. Of a piece, the
/// side that the larger area has in the file is right.
class Sides {
 public:
  /// `pairs` must be free of contradictions, as open_contradictory_pairs() leaves it.
  Sides(const WorkingMesh& mesh, const std::vector<std::uint32_t>& pairs);

  bool is_turned(std::uint32_t triangle) {
    const ParitySets::Place place = sets_.find(triangle);
    return (place.side ^ turned_root_[place.root]) != 0;
  }
  bool in_one_piece(std::uint32_t a, std::uint32_t b) { return sets_.find(a).root == sets_.find(b).root; }

  /// Joins the pieces of two triangles. With `turn_one` one of the two pieces, the one of smaller area, is
  /// turned as a whole. In one piece nothing happens, and `turn_one` must be false.
  void join(std::uint32_t a, std::uint32_t b, bool turn_one);

 private:
  ParitySets sets_;
  std::vector<std::uint8_t> turned_root_;  // at the root of each piece: whether the root itself is turned
  std::vector<double> area_;               // at the root of each piece
};

struct CutEdges {
  std::size_t edges = 0, pieces = 0;  // pieces that cannot be oriented
};

/// Opens pairs until the rest can be oriented. Per piece that is the seam which the file's own orientations
/// leave (pairs that agree as stored are never opened); only where a breadth-first walk from the lowest
/// triangle meets itself on the wrong side at less than half as many edges, as in files of random
/// orientation, those. Opening what an earlier run opened leaves exactly that seam, so a second run opens the
/// same edges. O(n).
CutEdges open_contradictory_pairs(WorkingMesh& mesh, std::vector<std::uint32_t>& pairs);

/// Reverses the triangles with turn[t] != 0 in place: corners, stored corners and pairs. O(n).
void turn_triangles(WorkingMesh& mesh, std::vector<std::uint32_t>& pairs,
                    const std::vector<std::uint8_t>& turn);

}  // namespace nmc::conditioning

#endif  // NMC_ENCODER_CONDITION_SIDES_H_
