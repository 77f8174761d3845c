// SPDX-License-Identifier: Apache-2.0
// Midpoint quadrature of the reparameterized input R o p over the triangles of a normal mesh.
//
// Based on: Friedel, section 3.5: "the midpoint quadrature rule with between 30 and 150 samples per
// triangle".
#ifndef NMC_ENCODER_NORMAL_MESH_QUADRATURE_H_
#define NMC_ENCODER_NORMAL_MESH_QUADRATURE_H_

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "encoder/normal_mesh/parameterized_surface.h"
#include "encoder/normal_mesh/vertex_system.h"

namespace nmc {

/// Barycentric coordinates of the centroids of the k * k congruent sub-triangles of a triangle.
std::vector<std::array<double, 3>> sub_triangle_centroids(int k);

/// The surface element of the integrals over a face.
enum class AreaWeighting {
  kUniform,  // every face counts the same
  kMesh,     // the area of the mesh's face
  kInput,    // the area of its image on the input
};

struct QuadratureOptions {
  /// k for levels 0-1, 2-3 and finer: k * k samples per face.
  std::array<int, 3> subdivisions = {10, 8, 6};
  AreaWeighting weighting = AreaWeighting::kMesh;

  int subdivisions_at(int level) const {
    return subdivisions[static_cast<std::size_t>(level < 2 ? 0 : level < 4 ? 1 : 2)];
  }
};

/// Area of the input per area of the chart in which `triangle` is seen; 0 where the map folds it.
double map_stretch(const ParameterizedSurface& map, const LocalChart& chart, std::uint32_t triangle);

/// The sums that one face contributes to a least-squares problem in hat functions.
struct FaceIntegrals {
  VertexSystem::FaceMatrix mass = {};  // integrals of products of hats, in the order of VertexSystem
  std::array<Vec3, 3> load;            // integrals of hat times R o p
};

/// For all faces of `topology`, level `level` of a mesh with these positions and parameters. Parallel;
/// about half a microsecond per sample.
std::vector<FaceIntegrals> integrate_faces(const ParameterizedSurface& map, const LevelTopology& topology,
                                           int level, std::span<const Vec3> positions,
                                           std::span<const SurfaceParameter> parameters,
                                           const QuadratureOptions& options);

}  // namespace nmc

#endif  // NMC_ENCODER_NORMAL_MESH_QUADRATURE_H_
