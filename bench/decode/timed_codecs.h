// SPDX-License-Identifier: Apache-2.0
// Decoders of triangle meshes and the time they take: in process, one thread, best of several runs with
// memory warm, processor time, from compressed bytes to float positions and 32-bit indices.
#ifndef NMC_BENCH_DECODE_TIMED_CODECS_H_
#define NMC_BENCH_DECODE_TIMED_CODECS_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "libnmc/include/nmc/nmc.h"

namespace nmc::bench {

/// What a renderer takes: three values per vertex, three indices per triangle.
struct FloatMesh {
  std::vector<float> positions;
  std::vector<std::uint32_t> indices;
  std::size_t triangle_count() const { return indices.size() / 3; }
};

struct DecodeTime {
  std::size_t bytes = 0;
  double seconds = 0;
  double memory_per_triangle = 0;  // bytes at the peak, output included; 0: not known
};

/// The whole stream at its last layer's level, which is given back with the mesh.
DecodeTime time_nmc(const std::vector<std::uint8_t>& stream, int runs, FloatMesh& mesh, nmc_layer& layer,
                    nmc_info& info);

/// Edgebreaker; `speed` is 10 minus the -cl of draco_encoder.
DecodeTime time_draco(const FloatMesh& mesh, int position_bits, int speed, int runs);

/// Index and vertex codec on 16-bit integers that use `position_bits` of them, after ordering for the vertex
/// cache.
DecodeTime time_meshopt(const FloatMesh& mesh, int position_bits, int runs);

}  // namespace nmc::bench

#endif  // NMC_BENCH_DECODE_TIMED_CODECS_H_
