// SPDX-License-Identifier: Apache-2.0
// The curves of a surface that must become base edge paths: boundary loops and, when asked, creases.
#ifndef NMC_ENCODER_DOMAIN_SURFACE_CHAINS_H_
#define NMC_ENCODER_DOMAIN_SURFACE_CHAINS_H_

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "encoder/core/triangle_mesh.h"
#include "encoder/domain/maps_collapse.h"

namespace nmc {

struct SurfaceChains {
  std::shared_ptr<const TriangleMesh> surface;
  std::vector<VertexKind> kinds;                           // per vertex of `surface`
  std::vector<std::array<std::uint32_t, 2>> crease_edges;  // vertex pairs, low first, sorted
};

/// Finds the chains and splits every *chord* (an edge that joins two chain vertices without being part of a
/// chain) at its middle: a triangle whose three corners lie on one straight base edge would have no area in
/// the domain. New vertices come after the mesh's own; attributes and colours are averaged. O(n log n).
///
/// Creases by hysteresis: edges above `crease_angle_degrees` seed chains that grow along edges above 5/8 of
/// it; chains shorter than four edges and 2 % of the diagonal are dropped unless they close or join others at
/// both ends.
SurfaceChains find_chains(const TriangleMesh& mesh, double crease_angle_degrees);

}  // namespace nmc

#endif  // NMC_ENCODER_DOMAIN_SURFACE_CHAINS_H_
