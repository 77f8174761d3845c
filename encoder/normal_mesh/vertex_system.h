// SPDX-License-Identifier: Apache-2.0
// Symmetric positive linear systems with one unknown per vertex and the sparsity of a triangle mesh, such as
// mass matrices of hat functions.
//
// Based on: Hestenes, Stiefel, "Methods of conjugate gradients for solving linear systems" (1952), with the
// diagonal as preconditioner. A mass matrix so scaled has a condition number that does not depend on the mesh
// (Wathen, 1987), so 10 to 25 iterations suffice at any size.
#ifndef NMC_ENCODER_NORMAL_MESH_VERTEX_SYSTEM_H_
#define NMC_ENCODER_NORMAL_MESH_VERTEX_SYSTEM_H_

#include <array>
#include <cstdint>
#include <vector>

#include "libnmc/common/subdivision.h"

namespace nmc {

struct ConjugateGradientOptions {
  double tolerance =
      1e-8;  // of the residual's norm relative to that of the right-hand side, diagonally scaled
  int iteration_limit = 500;
};

class VertexSystem {
 public:
  /// Entries of one face's corners: (0,0) (1,1) (2,2) (1,2) (2,0) (0,1); the last three belong to edges 0,
  /// 1, 2.
  using FaceMatrix = std::array<double, 6>;

  /// The sum of `matrices`, one per face. O(faces).
  VertexSystem(const LevelTopology& topology, const std::vector<FaceMatrix>& matrices);

  /// Adds `share` of the largest diagonal entry to all of them, which makes rows without any weight solvable.
  void regularize(double share);

  /// Solves for one right-hand side, from zero. Parallel; the result does not depend on the number of
  /// threads. Returns the number of iterations.
  int solve(const std::vector<double>& right_hand_side, const ConjugateGradientOptions& options,
            std::vector<double>& solution) const;

  double diagonal(std::uint32_t vertex) const { return diagonal_[vertex]; }
  /// result = matrix * x.
  void multiply(const std::vector<double>& x, std::vector<double>& result) const;

 private:
  std::vector<double> diagonal_;
  std::vector<std::uint32_t> first_;  // per vertex, into the next two
  std::vector<std::uint32_t> neighbors_;
  std::vector<double> entries_;
};

}  // namespace nmc

#endif  // NMC_ENCODER_NORMAL_MESH_VERTEX_SYSTEM_H_
