// SPDX-License-Identifier: Apache-2.0
// The connected pieces of a paired mesh while it is still being worked on.
#ifndef NMC_ENCODER_CONDITION_PIECES_H_
#define NMC_ENCODER_CONDITION_PIECES_H_

#include <cstdint>
#include <vector>

#include "encoder/condition/working_mesh.h"

namespace nmc::conditioning {

struct Piece {
  std::uint32_t first_triangle = 0;
  std::size_t triangle_count = 0;
  double area = 0;
  double volume = 0;  // signed; meaningful when closed
  bool is_closed = true;
  BoundingBox box;
};

struct Pieces {
  std::vector<Piece> list;                 // ordered by first triangle
  std::vector<std::uint32_t> of_triangle;  // index into list
};

/// O(n).
Pieces find_pieces(const WorkingMesh& mesh, const std::vector<std::uint32_t>& opposite);

}  // namespace nmc::conditioning

#endif  // NMC_ENCODER_CONDITION_PIECES_H_
