// SPDX-License-Identifier: Apache-2.0
// Sparse Cholesky factorization of a BlockMatrix over a nested dissection.
//
// Based on: I. S. Duff, J. K. Reid, "The Multifrontal Solution of Indefinite Sparse Symmetric Linear
// Equations", ACM TOMS 9, 1983. One dense front per dissection node; all arithmetic is dense matrix algebra,
// which is several times faster than a scalar sparse factorization, and independent subtrees run in parallel.
#ifndef NMC_ENCODER_SPHERE_BLOCK_CHOLESKY_H_
#define NMC_ENCODER_SPHERE_BLOCK_CHOLESKY_H_

#include <Eigen/Dense>
#include <cstdint>
#include <vector>

#include "encoder/sphere/nested_dissection.h"

namespace nmc {

/// Symbolic once, numeric often. n = 134,000 vertices: about 400 MB.
class BlockCholesky {
 public:
  /// The pattern and a good elimination order for it. Keeps a reference to `graph`.
  BlockCholesky(const VertexGraph& graph, const std::vector<Vec3>& positions);

  /// Factors matrix + shift * identity. False when it is not positive definite; the factor is then unusable.
  bool factorize(const BlockMatrix& matrix, double shift);

  /// Solves with the last successful factorization.
  std::vector<Tangent2> solve(const std::vector<Tangent2>& right_hand_side) const;

 private:
  // An entry of the original matrix and where it goes in the front, in vertices.
  struct Entry {
    std::uint32_t row, column;  // of the front; row > column
    std::uint32_t edge_slot;
    bool transposed;
  };
  struct Front {
    std::vector<std::uint32_t> vertices;  // own ones first, then the border, ascending by elimination
    std::uint32_t own_count = 0;
    std::vector<Entry> entries;
    std::vector<std::uint32_t> child_border[2];  // position in this front of each child's border vertex
    Eigen::MatrixXd factor;                      // 2 own_count columns, all rows
    Eigen::MatrixXd update;                      // what the parent still has to add
  };

  void eliminate(std::size_t node, const BlockMatrix& matrix, double shift);
  void eliminate_subtree(std::size_t node, const BlockMatrix& matrix, double shift);

  const VertexGraph& graph_;
  std::vector<DissectionNode> nodes_;
  std::vector<Front> fronts_;
  std::vector<std::uint32_t> subtree_size_;  // vertices below and in each node
  std::vector<char> failed_;
};

}  // namespace nmc

#endif  // NMC_ENCODER_SPHERE_BLOCK_CHOLESKY_H_
