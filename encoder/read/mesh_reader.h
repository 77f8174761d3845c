// SPDX-License-Identifier: Apache-2.0
// Mesh files in: PLY, OBJ, STL, OFF and glTF 2.0, all into one plain indexed triangle mesh.
//
// What every format has in common:
//  - Vertices come as they are stored: unreferenced, duplicate and non-finite ones included. Welding and
//  repair
//    are the business of encoder/condition. STL therefore gives three vertices per triangle.
//  - Polygons are triangulated (encoder/read/polygon_triangulation.h); triangle order is the order of the
//  file.
//  - What the file holds and TriangleMesh cannot (texture coordinates, materials, face colours, ...) is
//  listed in
//    TriangleMesh::dropped_properties, never skipped silently.
//  - A malformed file ends in nmc::Error with kInvalidInput and a message "file: line N: reason" for text or
//    "file: byte offset N: reason" for binary data; a file that cannot be opened or read gives kInputOutput;
//    a valid file that needs a feature nmc has not gives kUnsupported; one above the limits gives kLimit.
//  - Any bytes are safe input. No count of a file is trusted: memory grows with the bytes really there.
#ifndef NMC_ENCODER_READ_MESH_READER_H_
#define NMC_ENCODER_READ_MESH_READER_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "encoder/core/triangle_mesh.h"

namespace nmc {

enum class MeshFormat { kPly, kObj, kStl, kOff, kGltf };

struct ReadOptions {
  /// The format; without it the file's extension decides and, where that says nothing, its first bytes.
  std::optional<MeshFormat> format;

  /// Scalar properties such as "quality" or "nx" become TriangleMesh::attributes; false lists them as
  /// dropped.
  bool attributes = true;

  /// Above these the reader stops with kLimit. They bound formats whose output is not bounded by the size of
  /// the file (a glTF scene may show one mesh a million times). Values above 2^32 - 2 count as that.
  std::uint64_t maximum_vertices = 1'500'000'000;
  std::uint64_t maximum_triangles = 500'000'000;
};

/// Reads the mesh file at `path`. "-" reads standard input to its end.
TriangleMesh read_mesh(const std::string& path, const ReadOptions& options = {});

/// Reads a mesh from memory. `display_name` stands for the file in messages. glTF buffers in files of their
/// own are sought in `folder`; without a folder they are refused.
TriangleMesh read_mesh(std::span<const std::byte> data, MeshFormat format, const std::string& display_name,
                       const ReadOptions& options = {}, const std::string& folder = {});

/// "ply", "obj", "stl", "off", "gltf" or "glb" in any case, with or without a leading dot.
std::optional<MeshFormat> mesh_format_from_name(std::string_view name);

/// The format that the first bytes prove: PLY, glTF or OFF. Nothing for OBJ and STL, which have no signature.
std::optional<MeshFormat> mesh_format_from_content(std::span<const std::byte> data);

}  // namespace nmc

#endif  // NMC_ENCODER_READ_MESH_READER_H_
