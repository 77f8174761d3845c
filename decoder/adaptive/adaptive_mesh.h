// SPDX-License-Identifier: Apache-2.0
// Large triangles where the surface is flat, small ones where it is not, and no cracks between them.
//
// A decoded level is a forest: each base triangle is split into four, again and again. The triangles kept
// here are those of the coarsest cut through the forest that stays within a tolerance. Whether the odd vertex
// of an edge is used is decided once per edge, so the two faces of the edge agree and cracks are impossible;
// a face with one or two split edges is cut into two or three triangles.
//
// Based on: Bank, Sherman, Weiser. Refinement algorithms and data structures for regular local mesh
// refinement. 1983 (red-green refinement); Von Herzen, Barr. Accurate triangulations of deformed,
// intersecting surfaces. SIGGRAPH 1987 (restricted trees).
#ifndef NMC_DECODER_ADAPTIVE_ADAPTIVE_MESH_H_
#define NMC_DECODER_ADAPTIVE_ADAPTIVE_MESH_H_

#include <cstdint>
#include <span>
#include <vector>

namespace nmc {

struct AdaptiveMesh {
  std::vector<std::uint32_t> source_vertices;  // of each vertex, its number in the full mesh, increasing
  std::vector<std::uint32_t> triangles;  // three indices into source_vertices each, oriented as the full mesh
  /// Largest distance between the two meshes at the same parameter, hence a bound of their Hausdorff distance
  /// both ways: exact up to rounding, not sampled. At most the tolerance.
  double largest_deviation = 0;
};

/// `triangles` are those of level `level` as nmc_decoder_read_indices gives them, `positions` three
/// coordinates per vertex of that level. The result uses vertices of the full mesh only, is as closed as the
/// full mesh, and lies within `tolerance` >= 0 of it. With a tolerance of 0 only what is exactly flat is
/// merged. The same input gives the same output on every machine. O(level * vertices) time at most; 5 bytes
/// per vertex and triangle besides the result.
AdaptiveMesh extract_adaptive(std::span<const std::uint32_t> triangles, std::span<const double> positions,
                              int level, double tolerance);

}  // namespace nmc

#endif  // NMC_DECODER_ADAPTIVE_ADAPTIVE_MESH_H_
