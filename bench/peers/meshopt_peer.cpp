// SPDX-License-Identifier: Apache-2.0
#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "bench/peers/peer.h"
#include "bench/peers/zstd_peer.h"
#include "encoder/core/error.h"

namespace nmc::bench {
namespace {

struct GridVertex {
  std::uint16_t x, y, z, padding;  // the codec wants a multiple of four bytes
};

}  // namespace

CodecResult code_with_meshopt(const TriangleMesh& mesh, int position_bits) {
  const BoundingBox box = bounding_box(mesh);
  const Vec3 size = box.maximum - box.minimum;
  const double step = std::max({size.x, size.y, size.z}) / ((1 << position_bits) - 1);
  CodecResult result;

  const Stopwatch encode_watch;
  const auto to_grid = [&](double value, double low) {
    return static_cast<std::uint16_t>(step > 0 ? std::lround((value - low) / step) : 0);
  };
  std::vector<GridVertex> vertices;
  for (const Vec3& p : mesh.positions) {
    vertices.push_back(
        {to_grid(p.x, box.minimum.x), to_grid(p.y, box.minimum.y), to_grid(p.z, box.minimum.z), 0});
  }
  std::vector<std::uint32_t> indices;
  for (const Triangle& triangle : mesh.triangles)
    indices.insert(indices.end(), triangle.begin(), triangle.end());
  meshopt_optimizeVertexCacheStrip(indices.data(), indices.data(), indices.size(), vertices.size());
  const std::size_t vertex_count = meshopt_optimizeVertexFetch(
      vertices.data(), indices.data(), indices.size(), vertices.data(), vertices.size(), sizeof(GridVertex));
  std::vector<unsigned char> packed_indices(meshopt_encodeIndexBufferBound(indices.size(), vertex_count));
  packed_indices.resize(meshopt_encodeIndexBuffer(packed_indices.data(), packed_indices.size(),
                                                  indices.data(), indices.size()));
  std::vector<unsigned char> packed_vertices(
      meshopt_encodeVertexBufferBound(vertex_count, sizeof(GridVertex)));
  packed_vertices.resize(meshopt_encodeVertexBuffer(packed_vertices.data(), packed_vertices.size(),
                                                    vertices.data(), vertex_count, sizeof(GridVertex)));
  const std::vector<unsigned char> index_bytes = zstd_compress(packed_indices);
  const std::vector<unsigned char> vertex_bytes = zstd_compress(packed_vertices);
  result.encode_seconds = encode_watch.seconds();
  constexpr std::size_t kHeader = 4 * sizeof(float) + 2 * sizeof(std::uint32_t);  // origin, step, two counts
  result.bytes = index_bytes.size() + vertex_bytes.size() + kHeader;

  const Stopwatch decode_watch;
  packed_indices = zstd_decompress(index_bytes);
  packed_vertices = zstd_decompress(vertex_bytes);
  std::vector<GridVertex> decoded_vertices(vertex_count);
  if (meshopt_decodeIndexBuffer(indices.data(), indices.size(), sizeof(std::uint32_t), packed_indices.data(),
                                packed_indices.size()) != 0 ||
      meshopt_decodeVertexBuffer(decoded_vertices.data(), vertex_count, sizeof(GridVertex),
                                 packed_vertices.data(), packed_vertices.size()) != 0) {
    throw Error(ExitCode::kInternal, "meshoptimizer cannot decode its own buffers");
  }
  result.decode_seconds = decode_watch.seconds();
  for (const GridVertex& v : decoded_vertices) {
    result.decoded.positions.push_back(box.minimum + step * Vec3{double(v.x), double(v.y), double(v.z)});
  }
  for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
    result.decoded.triangles.push_back({indices[i], indices[i + 1], indices[i + 2]});
  }
  return result;
}

}  // namespace nmc::bench
