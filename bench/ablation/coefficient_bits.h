// SPDX-License-Identifier: Apache-2.0
// What the same integers cost under three coders of coefficients.
#ifndef NMC_BENCH_ABLATION_COEFFICIENT_BITS_H_
#define NMC_BENCH_ABLATION_COEFFICIENT_BITS_H_

#include "encoder/core/subdivision_hierarchy.h"
#include "encoder/fit/quantized_mesh.h"

namespace nmc_bench {

/// Bits of all normal coefficients; tangential parts and the base mesh are left out.
struct CoefficientBits {
  /// One adaptive context per decision and nothing mixed: zero or not, by level and the coder's main context
  /// (spec 5.3.1: the mean magnitude around); the sign alone; larger or not, by that mean. Starts without
  /// knowledge.
  double one_context = 0;
  double mixing_untrained = 0;  // the coder's own contexts and mixing, starting without knowledge
  double coded = 0;             // as in the file: starting with the trained states
};
CoefficientBits coefficient_bits(const nmc::QuantizedMesh& mesh, const nmc::SubdivisionHierarchy& hierarchy);

}  // namespace nmc_bench

#endif  // NMC_BENCH_ABLATION_COEFFICIENT_BITS_H_
