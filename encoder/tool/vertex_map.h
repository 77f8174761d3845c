// SPDX-License-Identifier: Apache-2.0
// Where each vertex of the input lies on the coded surface, for carrying data over: an address that means the
// same point at every level.
#ifndef NMC_ENCODER_TOOL_VERTEX_MAP_H_
#define NMC_ENCODER_TOOL_VERTEX_MAP_H_

#include <cstdint>
#include <string>
#include <vector>

#include "encoder/core/triangle_mesh.h"

namespace nmc {

inline constexpr std::uint32_t kNoBaseFace = 0xffffffffu;

/// A point of the base mesh's face, (1 - u - v, u, v) being the weights of its corners in the stream's order,
/// and a signed height over the decoded surface there, in units of the input, positive outwards.
struct SurfaceAddress {
  std::uint32_t base_face = kNoBaseFace;  // kNoBaseFace: the vertex is not finite
  double u = 0, v = 0, height = 0;
};

/// The weights of the base face's corners at a point of face `face` of level `level` (faces as numbered by
/// libnmc/common/subdivision.h), given the weights of that face's own corners.
SurfaceAddress address_on_base(std::uint32_t face, int level, const double (&barycentric)[3]);

/// The closest point of `decoded`, which is level `level` of a stream, to every vertex of `input`.
/// O(vertices log triangles).
std::vector<SurfaceAddress> map_vertices(const TriangleMesh& input, const TriangleMesh& decoded, int level);

/// CSV: "vertex,base_face,u,v,height", a line per vertex; "-1,0,0,0" stands for a vertex that is not finite.
std::string to_csv(const std::vector<SurfaceAddress>& map);

}  // namespace nmc

#endif  // NMC_ENCODER_TOOL_VERTEX_MAP_H_
