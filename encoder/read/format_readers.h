// SPDX-License-Identifier: Apache-2.0
// The readers of the single formats behind read_mesh(); mesh_reader.h says what they have in common.
#ifndef NMC_ENCODER_READ_FORMAT_READERS_H_
#define NMC_ENCODER_READ_FORMAT_READERS_H_

#include "encoder/core/triangle_mesh.h"
#include "encoder/read/mesh_reader.h"
#include "encoder/read/source.h"

namespace nmc {

/// Based on: Turk. The PLY Polygon File Format, 1994. ASCII, little- and big-endian; elements and properties
/// of any type in any order; "face" polygons and "tristrips".
TriangleMesh read_ply(const Source& source, const ReadOptions& options);

/// Based on: Wavefront. Advanced Visualizer Manual, appendix B1 (v, f, negative indices, line continuation),
/// and the two colour extensions in use: "v x y z r g b" and ZBrush's "#MRGB" blocks.
TriangleMesh read_obj(const Source& source, const ReadOptions& options);

/// Based on: 3D Systems. StereoLithography Interface Specification, 1989. Binary, and ASCII with any number
/// of solids; vertex colours of a binary file's attribute words are per facet and reported as dropped.
TriangleMesh read_stl(const Source& source, const ReadOptions& options);

/// Based on: The Geometry Center. Geomview Manual, "OFF Files" ([ST][C][N]OFF, ASCII and big-endian binary),
/// and the little-endian binary layout of pmp-library.
TriangleMesh read_off(const Source& source, const ReadOptions& options);

/// Based on: Khronos. glTF 2.0 Specification, 2021 (.gltf and .glb), KHR_mesh_quantization,
/// EXT_mesh_gpu_instancing. All triangle primitives of the default scene in world coordinates.
TriangleMesh read_gltf(const Source& source, const ReadOptions& options);

}  // namespace nmc

#endif  // NMC_ENCODER_READ_FORMAT_READERS_H_
