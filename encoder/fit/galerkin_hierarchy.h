// SPDX-License-Identifier: Apache-2.0
// The Hessian of the fit on every level of the hierarchy: A_l = P^T A_{l+1} P, with P the butterfly
// synthesis.
//
// The basis function of the coefficient of edge e of level l is a scalar function times the normal n_e, so
// the Hessian between two coefficients of one level is n_e^T B n_f, where B is the 3x3 block of A_{l+1}
// between their odd vertices: with these matrices the interaction of any two coefficients of a level is one
// look-up. That is what exact diagonals and coordinate descent on integers need.
//
// Based on: Briggs, Henson, McCormick, A Multigrid Tutorial, 2000, ch. 8 (Galerkin operators); Gustavson, Two
// fast algorithms for sparse matrices, ACM TOMS 4, 1978 (row-wise triple product).
#ifndef NMC_ENCODER_FIT_GALERKIN_HIERARCHY_H_
#define NMC_ENCODER_FIT_GALERKIN_HIERARCHY_H_

#include <cstdint>
#include <vector>

#include "encoder/fit/quadratic_energy.h"
#include "encoder/fit/synthesis_operator.h"

namespace nmc {

/// Symmetric block-sparse matrix over the vertices of one level; every row holds both halves and its
/// diagonal.
struct GalerkinMatrix {
  std::vector<std::size_t> row_begin;
  std::vector<std::uint32_t> column;  // unordered within a row, the diagonal first
  std::vector<SymmetricMatrix3> block;
};

class GalerkinHierarchy {
 public:
  /// Matrices of levels 0 ... finest. The finest is a copy of the energy's. About 1.5 us and 2.2 kB per
  /// vertex.
  void build(const SynthesisOperator& synthesis, const QuadraticEnergy& energy);
  bool empty() const { return matrices_.empty(); }
  const GalerkinMatrix& matrix(int level) const { return matrices_[static_cast<std::size_t>(level)]; }
  /// Diagonal block of a vertex of `level`.
  const SymmetricMatrix3& diagonal(int level, std::size_t vertex) const {
    const GalerkinMatrix& m = matrix(level);
    return m.block[m.row_begin[vertex]];
  }

 private:
  std::vector<GalerkinMatrix> matrices_;
};

}  // namespace nmc

#endif  // NMC_ENCODER_FIT_GALERKIN_HIERARCHY_H_
