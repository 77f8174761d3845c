// SPDX-License-Identifier: Apache-2.0
// Quadrature of a normal mesh against the input, and the check that every correspondence needs before it is
// trusted.
//
// Based on: Friedel, section 3.5 (midpoint quadrature of R o p over the triangles of S^l). The check is ours:
// a fit magnifies the fraction of a percent of samples that lie on a wrong sheet.
#ifndef NMC_ENCODER_NORMAL_MESH_SAMPLE_CORRESPONDENCES_H_
#define NMC_ENCODER_NORMAL_MESH_SAMPLE_CORRESPONDENCES_H_

#include <cstdint>
#include <span>
#include <vector>

#include "encoder/normal_mesh/parameterized_surface.h"
#include "encoder/normal_mesh/surface_samples.h"
#include "encoder/spatial/surface_index.h"

namespace nmc {

/// Whose area a sample stands for.
enum class SampleWeighting {
  kMesh,   // of the normal mesh's triangle
  kInput,  // of the input, by the stretch of the map at the target: right where the mesh is still coarse
  kBoth,   // the mean of the two
};

struct SamplingOptions {
  int subdivisions = 3;  // k: k * k samples per face, 1 ... 16
  SampleWeighting weighting = SampleWeighting::kBoth;
  /// A target farther from the mesh's own point than this many times the face's longest edge is replaced.
  double farthest_in_edges = 3;
  /// So is one whose normal has a smaller cosine with the face's.
  double least_normal_agreement = 0.2;
  /// Factor on the weight where even the closest point's normal disagrees.
  double doubtful_weight = 0.05;
};

struct SampleStatistics {
  std::size_t count = 0;
  std::size_t replaced = 0;  // by the closest point of the input
  std::size_t doubtful = 0;  // weighted down
};

/// Samples of all faces of `topology`, the level `level` of a normal mesh whose vertices have the given
/// positions and parameters: face by face, `subdivisions` squared each. The weights sum to 1 before doubtful
/// ones are reduced. `index` must hold map.surface(). Parallel; deterministic. About 1 microsecond per
/// sample, plus a closest-point query for each replaced one.
std::vector<SurfaceSample> sample_correspondences(const ParameterizedSurface& map, const SurfaceIndex& index,
                                                  const LevelTopology& topology, int level,
                                                  std::span<const Vec3> positions,
                                                  std::span<const SurfaceParameter> parameters,
                                                  const SamplingOptions& options = {},
                                                  SampleStatistics* statistics = nullptr);

/// The same for positions alone, without a parameterization: targets are closest points of the input on the
/// side of the face (with the same normal check). For meshes whose parameters are not known.
std::vector<SurfaceSample> sample_closest_points(const ParameterizedSurface& map, const SurfaceIndex& index,
                                                 const LevelTopology& topology,
                                                 std::span<const Vec3> positions,
                                                 const SamplingOptions& options = {},
                                                 SampleStatistics* statistics = nullptr);

}  // namespace nmc

#endif  // NMC_ENCODER_NORMAL_MESH_SAMPLE_CORRESPONDENCES_H_
