// SPDX-License-Identifier: Apache-2.0
// Integers to positions: one level of the normal mesh (spec 6). Decoder and encoder link this same object
// file, so what the encoder measures is what a user gets.
#ifndef NMC_COMMON_RECONSTRUCT_H_
#define NMC_COMMON_RECONSTRUCT_H_

#include <cstdint>

#include "libnmc/common/butterfly.h"
#include "libnmc/common/memory.h"
#include "libnmc/common/subdivision.h"
#include "libnmc/common/vec3.h"

namespace nmc {

/// The quantized tangential (non-normal) part of one odd vertex. Present only where it is not zero.
struct TangentialCoefficient {
  std::uint32_t edge;
  std::int32_t along, across;
};

/// Quantized detail of all odd vertices of one level.
struct LevelCoefficients {
  explicit LevelCoefficients(Memory* memory = nullptr) : normal(memory), tangential(memory) {}
  Array<std::int32_t> normal;               // one per edge of the coarser level
  Array<TangentialCoefficient> tangential;  // in increasing order of edge
};

/// What turns the coefficients of one level into lengths (spec 3.3).
struct LevelQuantizer {
  double normal_step = 1;
  double tangential_step = 1;
  Tension tension;
};

/// Writes the positions of the odd vertices of `coarse` (one per edge) to positions[coarse.vertex_count ...],
/// reading those below. `coefficients` may be null: all zero. Edges in [first_edge, last_edge) only, so that
/// disjoint ranges may be computed concurrently. Bits are normative and do not depend on the ranges.
void reconstruct_odd_vertices(const LevelTopology& coarse, const RingWeights& ring_weights,
                              const LevelQuantizer& quantizer, const LevelCoefficients* coefficients,
                              std::uint32_t first_edge, std::uint32_t last_edge, Vec3* positions);

/// The same bits for a level that has a coarser one, `parent`: faster, since the stencils of an edge's two halves, and of
/// a face's three inner edges, are found together, from a quarter of the connectivity. Stencils that meet a curve are
/// left to the general rule.
void reconstruct_odd_vertices_of_split(const LevelTopology& parent, const LevelTopology& coarse,
                                       const RingWeights& ring_weights, const LevelQuantizer& quantizer,
                                       const LevelCoefficients* coefficients, std::uint32_t first_edge,
                                       std::uint32_t last_edge, Vec3* positions);

}  // namespace nmc

#endif  // NMC_COMMON_RECONSTRUCT_H_
