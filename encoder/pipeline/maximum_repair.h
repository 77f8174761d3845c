// SPDX-License-Identifier: Apache-2.0
// Brings single places of a quantized mesh within a tolerance.
//
// Least squares and rate-distortion decisions care for the mean; what they leave beyond a tolerance is a handful of
// spikes and tips. Each of them is repaired where it is. Integers of the finest level are changed one by one, each
// change measured (place_settling.h). What has to do with vertices of coarser levels is told to these: they go as far
// as they must, and finer ones that would be carried along by half a step or more are held where they are.
#ifndef NMC_ENCODER_PIPELINE_MAXIMUM_REPAIR_H_
#define NMC_ENCODER_PIPELINE_MAXIMUM_REPAIR_H_

#include <cstddef>

#include "encoder/fit/quantized_mesh.h"
#include "encoder/spatial/surface_index.h"

namespace nmc {

struct MaximumRepairOptions {
  double tolerance = 0;      // in units of the mesh
  /// Places farther off than this share of the tolerance are looked after.
  double margin = 0.98;
  int maximum_rounds = 8;
  /// Rounds without progress after which the rest are left out.
  int patience = 5;
  /// Once, instead of giving up: back to the best round, and from there with wishes of the farthest places only.
  bool starts_again = false;
  /// More places than this share of the vertices and points are no spikes: nothing is done.
  double largest_share = 0.01;
  /// Area-uniform points of each surface that count beside the vertices: with those of the measurement
  /// (usual_sample_count()) what is within the tolerance here is so there. 0: vertices alone.
  std::size_t input_sample_count = 0, mesh_sample_count = 0;
};

/// Vertices of `input` (those its triangles use) and of the mesh that are farther than `tolerance` from the other
/// surface. One query per vertex, most of them ended by the first triangle.
std::size_t count_beyond(const SurfaceIndex& input, const std::vector<Vec3>& positions,
                         const std::vector<Triangle>& faces, double tolerance);

struct MaximumRepairResult {
  std::size_t initial_beyond = 0, final_beyond = 0;  // vertices and points of both beyond the tolerance
  int rounds = 0;
};

/// Changes the integers of `mesh`, whose finest level is the last of `hierarchy`, until no vertex of `input`
/// (those its triangles use), no vertex of the mesh and none of the points of either is farther
/// than the tolerance from the other surface, or the rounds are over. The best round is kept. One query per
/// vertex, point and round; parallel, deterministic.
MaximumRepairResult repair_maximum(const SurfaceIndex& input, const SubdivisionHierarchy& hierarchy,
                                   const MaximumRepairOptions& options, QuantizedMesh& mesh);

}  // namespace nmc

#endif  // NMC_ENCODER_PIPELINE_MAXIMUM_REPAIR_H_
