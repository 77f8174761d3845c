// SPDX-License-Identifier: Apache-2.0
// The base mesh alone: two bytes of counts and one of flags, then the payload. What is accepted is an
// oriented manifold, and the encoder's half finds a stream for it that gives the same mesh.
#include "libnmc/common/coded_mesh.h"
#include "libnmc/decode/range_decoder.h"
#include "tests/fuzz/stream_fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace nmc;
  if (size < 3) return 0;
  Header header, plain;
  header.base_vertex_count = 3u + data[0];
  header.base_face_count = 1u + data[1];
  header.has_creases = (data[2] & 1) != 0;
  CodedMesh mesh(nullptr, &header);
  RangeDecoder coder(data + 3, size - 3);
  if (!mesh.code_base(coder, nullptr, nullptr, nullptr, nullptr, nullptr).ok()) return 0;
  const BaseMesh& base = mesh.base();
  LevelTopology topology;
  fuzz::require(
      build_base_topology(base.face_vertices.data(), base.face_count, base.vertex_count, nullptr, topology)
          .ok());
  const Array<std::int32_t>& coordinates = base.coordinates;
  for (const std::int32_t x : coordinates)
    fuzz::require(x >= -kMaximumBaseCoordinate && x <= kMaximumBaseCoordinate);

  // Creases are numbered as the writer numbers edges, so they are left out.
  plain.base_vertex_count = header.base_vertex_count;
  plain.base_face_count = header.base_face_count;
  StreamWriter writer(plain);
  Array<std::uint32_t> order;
  fuzz::require(writer.add_base(base.face_vertices.data(), base.coordinates.data(), nullptr, order).ok());
  fuzz::require(writer.mesh().base().face_vertices.size() == base.face_vertices.size());
  for (std::uint32_t v = 0; v < base.vertex_count; ++v) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      fuzz::require(writer.mesh().base().coordinates[3 * v + k] == base.coordinates[3 * order[v] + k]);
    }
  }
  return 0;
}
