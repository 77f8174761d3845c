// SPDX-License-Identifier: Apache-2.0
// Brings places of a quantized mesh within a tolerance by changing integers of its finest level one at a time.
//
// A vertex of the finest level moves nothing but its own faces, so what a change does to the largest distances around
// it can be measured instead of foreseen: points of the input from the faces around the vertex, and points of these
// faces from the input. Only changes that lower the excess there are made. No two of them can undo each other.
#ifndef NMC_ENCODER_PIPELINE_PLACE_SETTLING_H_
#define NMC_ENCODER_PIPELINE_PLACE_SETTLING_H_

#include <cstdint>
#include <vector>

#include "encoder/core/triangle_mesh.h"
#include "encoder/fit/quantized_mesh.h"
#include "encoder/spatial/surface_index.h"

namespace nmc {

/// A point of the mesh and where it should go.
struct Place {
  SurfacePoint at;
  Vec3 move;
};

/// What stays the same while a mesh is repaired. All references must outlive the object.
class PlaceSettling {
 public:
  /// `input_points` lie on `input` and are held within `tolerance` of the mesh; the mesh's own faces are sampled about
  /// `spacing` apart. `faces` are those of the hierarchy's last level. O(faces).
  PlaceSettling(const SurfaceIndex& input, const std::vector<Vec3>& input_points,
                const SubdivisionHierarchy& hierarchy, const std::vector<Triangle>& faces, double tolerance,
                double spacing);

  /// Changes integers of the last level of `mesh` and the `positions` they stand for. `surface` is the mesh at the
  /// beginning. Places that are still beyond the tolerance come back, in their order: those of vertices of coarser
  /// levels, for one. Nothing can be done where the last level has no integers. Deterministic.
  std::vector<Place> settle(const std::vector<Place>& places, const SurfaceIndex& surface,
                            std::vector<Vec3>& positions, QuantizedMesh& mesh) const;

 private:
  class Neighbourhood;

  const SurfaceIndex& input_;
  const std::vector<Vec3>& input_points_;
  const SubdivisionHierarchy& hierarchy_;
  const std::vector<Triangle>& faces_;
  double tolerance_, spacing_;
  std::vector<std::uint32_t> first_face_;    // [vertex], into faces_of_vertex_
  std::vector<std::uint32_t> faces_of_vertex_;
};

}  // namespace nmc

#endif  // NMC_ENCODER_PIPELINE_PLACE_SETTLING_H_
