// SPDX-License-Identifier: Apache-2.0
// Normals of a mesh for shading. They are no part of the format, but the same on every machine all the same.
#ifndef NMC_DECODE_VERTEX_NORMALS_H_
#define NMC_DECODE_VERTEX_NORMALS_H_

#include <cstddef>
#include <cstdint>

#include "libnmc/common/subdivision.h"
#include "libnmc/common/vec3.h"

namespace nmc {

/// Unit normals of the vertices, means of the faces around weighted by area, to three floats at byte i *
/// stride; (0, 0, 1) where the mean vanishes. `faces` are those of the level that `positions` belong to when
/// `is_split` is false, and else those of the level below it. O(faces) time, no memory.
void write_vertex_normals(const LevelTopology& faces, bool is_split, const Vec3* positions,
                          std::uint32_t vertex_count, unsigned char* normals, std::size_t stride);

}  // namespace nmc

#endif  // NMC_DECODE_VERTEX_NORMALS_H_
