// SPDX-License-Identifier: Apache-2.0
// Correspondences of a mesh that lies near the input, without a map between them: closest points.
//
// Based on: Hoppe, DeRose, Duchamp, McDonald, Stuetzle, "Mesh optimization" (1993).
#ifndef NMC_ENCODER_NORMAL_MESH_CLOSEST_SAMPLES_H_
#define NMC_ENCODER_NORMAL_MESH_CLOSEST_SAMPLES_H_

#include <cstddef>
#include <vector>

#include "encoder/normal_mesh/surface_samples.h"
#include "encoder/spatial/surface_index.h"
#include "libnmc/common/subdivision.h"

namespace nmc {

/// As many samples on each face of `level`, about `sample_count` in all and nine per face at least, each with the
/// closest point of the input and the normal of the triangle there. Where that normal points elsewhere than the face's
/// own, the correspondence is doubtful and hardly counts. Weights are areas. O(samples log triangles), parallel.
std::vector<SurfaceSample> closest_samples(const SurfaceIndex& input, const LevelTopology& level,
                                           const std::vector<Vec3>& positions, std::size_t sample_count);

}  // namespace nmc

#endif  // NMC_ENCODER_NORMAL_MESH_CLOSEST_SAMPLES_H_
