// SPDX-License-Identifier: Apache-2.0
// Correspondences between the finest level of a normal mesh and the input surface.
#ifndef NMC_ENCODER_NORMAL_MESH_SURFACE_SAMPLES_H_
#define NMC_ENCODER_NORMAL_MESH_SURFACE_SAMPLES_H_

#include <cstdint>

#include "libnmc/common/vec3.h"

namespace nmc {

/// One quadrature point of a face of the finest level and the input's point that it should lie on.
struct SurfaceSample {
  std::uint32_t face;    // of the finest level
  float barycentric[3];  // of the face's corners in order
  Vec3 target;           // on the input
  Vec3 normal;           // smooth unit normal of the input at `target`
  float weight;          // area share; small where the correspondence is doubtful
};

}  // namespace nmc

#endif  // NMC_ENCODER_NORMAL_MESH_SURFACE_SAMPLES_H_
