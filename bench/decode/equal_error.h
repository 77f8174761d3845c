// SPDX-License-Identifier: Apache-2.0
// The mesh that a user of another codec would send for the same error: simplified, and rounded as that codec
// rounds.
#ifndef NMC_BENCH_DECODE_EQUAL_ERROR_H_
#define NMC_BENCH_DECODE_EQUAL_ERROR_H_

#include <string>

#include "bench/decode/timed_codecs.h"
#include "bench/peers/peer_sweep.h"

namespace nmc::bench {

struct EqualErrorMesh {
  std::string simplifier;
  FloatMesh mesh;         // simplified, not yet rounded
  int position_bits = 0;  // for the codec
  double rms = 0;         // of the mesh as Draco gives it back, relative to the diagonal of the original
};

/// Symmetric RMS distance of a mesh to the original, relative to its diagonal.
double relative_rms(const BenchMesh& original, const FloatMesh& mesh);

/// Takes the fewest triangles, in steps of 12 %, that keep Draco's result within `target_rms`, relative to
/// the diagonal: with Lindstrom and Turk's simplifier where it was built in (NMC_BENCH_GPL), else
/// meshoptimizer's. The grid takes a fifth of the squared error.
EqualErrorMesh mesh_of_equal_error(const BenchMesh& original, double target_rms);

}  // namespace nmc::bench

#endif  // NMC_BENCH_DECODE_EQUAL_ERROR_H_
