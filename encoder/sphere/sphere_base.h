// SPDX-License-Identifier: Apache-2.0
// Base meshes on the sphere: regular polyhedra, turned to fit, and meshes adapted to the surface.
#ifndef NMC_ENCODER_SPHERE_SPHERE_BASE_H_
#define NMC_ENCODER_SPHERE_SPHERE_BASE_H_

#include <cstdint>

#include "encoder/sphere/sphere_surface.h"

namespace nmc {

enum class SphereBaseKind {
  kTetrahedron,
  kOctahedron,
  kIcosahedron,
  kAdaptive,  // half-edge collapses of the input whose triangles stay well shaped on the sphere too
};

struct SphereBaseOptions {
  SphereBaseKind kind = SphereBaseKind::kIcosahedron;
  /// Orientations tried for a regular polyhedron before the local search; 0: as it is.
  int rotation_count = 24;
  std::uint32_t adaptive_vertex_count = 100;  // at least 4; may not be reached on twisted maps
};

/// Base faces, parameters and positions on the surface. Regular polyhedra are turned so that two levels of
/// midpoint subdivision deviate least from the surface; deterministic. A few thousand point locations.
ParameterizedBase sphere_base(const SphereParameterizedSurface& surface,
                              const SphereBaseOptions& options = {});

/// The polyhedron with unit vertices, counter-clockwise; not for kAdaptive.
TriangleMesh regular_polyhedron(SphereBaseKind kind);

}  // namespace nmc

#endif  // NMC_ENCODER_SPHERE_SPHERE_BASE_H_
