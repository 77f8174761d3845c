// SPDX-License-Identifier: Apache-2.0
// What all fuzz targets of mesh readers do: any bytes end in a consistent mesh or in nmc::Error.
#ifndef NMC_TESTS_FUZZ_READ_FUZZ_H_
#define NMC_TESTS_FUZZ_READ_FUZZ_H_

#include <cstdint>
#include <cstdlib>
#include <span>

#include "encoder/core/error.h"
#include "encoder/read/mesh_reader.h"

namespace nmc {

inline int fuzz_read(MeshFormat format, const std::uint8_t* data, std::size_t size) {
  ReadOptions options;
  options.maximum_vertices = 1'000'000;
  options.maximum_triangles = 1'000'000;
  try {
    const TriangleMesh mesh =
        read_mesh(std::span(reinterpret_cast<const std::byte*>(data), size), format, "mesh", options);
    if (mesh.triangle_count() > options.maximum_triangles) std::abort();
    for (const Triangle& triangle : mesh.triangles)
      for (const std::uint32_t corner : triangle)
        if (corner >= mesh.vertex_count()) std::abort();
    if (!mesh.colors.empty() && mesh.colors.size() != mesh.vertex_count()) std::abort();
    for (const VertexAttribute& attribute : mesh.attributes)
      if (attribute.values.size() != mesh.vertex_count()) std::abort();
  } catch (const Error& error) {
    if (error.code() == ExitCode::kInternal || error.code() == ExitCode::kOk) std::abort();
  }
  return 0;
}

}  // namespace nmc

#endif  // NMC_TESTS_FUZZ_READ_FUZZ_H_
