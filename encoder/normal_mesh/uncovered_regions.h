// SPDX-License-Identifier: Apache-2.0
// Parts of the input that a mesh leaves out: the tips of limbs, ears and horns that no base vertex stands on.
//
// A normal mesh samples the input from its own side; an extremity between its samples does not show in any of
// its own errors. Here the input asks: how far is it from me to the mesh?
#ifndef NMC_ENCODER_NORMAL_MESH_UNCOVERED_REGIONS_H_
#define NMC_ENCODER_NORMAL_MESH_UNCOVERED_REGIONS_H_

#include <cstdint>
#include <vector>

#include "encoder/core/triangle_mesh.h"
#include "encoder/spatial/surface_index.h"

namespace nmc {

/// A connected set of input vertices farther from the mesh than the tolerance.
struct UncoveredRegion {
  std::uint32_t farthest_vertex = 0;    // of the input
  double farthest_distance = 0;         // units of the mesh
  double area = 0;                      // of the input, a third of each adjacent triangle per vertex
  double squared_error = 0;             // sum of area times squared distance
  std::vector<std::uint32_t> vertices;  // ascending
};

/// All of them, largest squared error first (ties: lowest farthest vertex). `mesh_index` holds the mesh. A
/// base vertex at `farthest_vertex` is what the region lacks. One closest-point query per input vertex;
/// parallel, deterministic.
std::vector<UncoveredRegion> uncovered_regions(const TriangleMesh& input, const SurfaceIndex& mesh_index,
                                               double tolerance);

}  // namespace nmc

#endif  // NMC_ENCODER_NORMAL_MESH_UNCOVERED_REGIONS_H_
