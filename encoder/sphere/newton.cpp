// SPDX-License-Identifier: Apache-2.0
#include "encoder/sphere/newton.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "encoder/core/parallel.h"
#include "encoder/sphere/block_cholesky.h"

namespace nmc {

namespace {

// Positions after a step in which every vertex has its own length.
class DampedStep {
 public:
  DampedStep(const SphereProblem& problem, const std::vector<Vec3>& start, const std::vector<Vec3>& direction)
      : problem_(problem),
        start_(start),
        direction_(direction),
        lengths_(start.size()),
        result_(start.size()) {}

  // False when even the shortest steps flip triangles. `damped` counts halvings.
  bool take(double length, bool forbid_flips, long& damped) {
    std::fill(lengths_.begin(), lengths_.end(), length);
    parallel_for(start_.size(), [&](std::size_t v) { move(v); });
    if (!forbid_flips) return true;
    constexpr int kRounds = 12;
    std::vector<char> marked;
    for (int round = 0; round < kRounds; ++round) {
      std::vector<std::uint32_t> shortened;
      marked.assign(start_.size(), 0);
      for (const Triangle& t : problem_.triangles()) {
        if (is_safely_oriented(result_[t[0]], result_[t[1]], result_[t[2]])) continue;
        for (const std::uint32_t v : t)
          if (!marked[v]) {
            marked[v] = 1;
            shortened.push_back(v);
          }
      }
      // No triangle flipped, but a part of the mesh may have wrapped around: only a shorter step for all
      // helps.
      if (shortened.empty()) return problem_.covering_degree(result_) == 1;
      damped += static_cast<long>(shortened.size());
      for (const std::uint32_t v : shortened) {
        lengths_[v] = round >= kRounds - 4 ? 0 : lengths_[v] / 2;
        move(v);
      }
    }
    return false;
  }

  std::vector<Vec3>& result() { return result_; }

 private:
  void move(std::size_t v) {
    result_[v] = lengths_[v] == 0 ? start_[v] : retract(start_[v], lengths_[v] * direction_[v]);
  }

  const SphereProblem& problem_;
  const std::vector<Vec3>& start_;
  const std::vector<Vec3>& direction_;
  std::vector<double> lengths_;
  std::vector<Vec3> result_;
};

void blend(const BlockMatrix& a, const BlockMatrix& b, double share, BlockMatrix& result) {
  result.diagonal.resize(a.diagonal.size());
  result.off_diagonal.resize(a.off_diagonal.size());
  parallel_for(a.diagonal.size(), [&](std::size_t i) {
    for (std::size_t k = 0; k < 3; ++k)
      result.diagonal[i][k] = a.diagonal[i][k] + share * (b.diagonal[i][k] - a.diagonal[i][k]);
  });
  parallel_for(a.off_diagonal.size(), [&](std::size_t i) {
    for (std::size_t k = 0; k < 4; ++k)
      result.off_diagonal[i][k] =
          a.off_diagonal[i][k] + share * (b.off_diagonal[i][k] - a.off_diagonal[i][k]);
  });
}

}  // namespace

OptimizationResult minimize_newton(const SphereProblem& problem, std::vector<Vec3>& positions,
                                   const OptimizationOptions& options) {
  const auto start_time = std::chrono::steady_clock::now();
  const auto seconds = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_time).count();
  };
  const std::size_t count = positions.size();
  BlockCholesky cholesky(problem.graph(), positions);
  BlockMatrix hessian, projected, blended;
  std::vector<TangentFrame> frames(count);
  std::vector<Tangent2> gradient, unused_gradient;
  std::vector<Vec3> direction(count);
  OptimizationResult result;
  result.energy = problem.energy(positions);

  // The matrix is exact + share * (projected - exact). With share 1 it is positive semi-definite and
  // converges linearly; the smallest share that still is positive definite converges at about that rate. The
  // share follows the outcome of the factorizations and ends at zero.
  double share = 0.016;
  constexpr double kSmallestShare = 1e-6;
  // A factor of 3: coarser ones alternate between too little, which costs a factorization, and too short steps.
  constexpr double kFactor = 3;
  const auto raised = [&](double s) { return s == 0 ? 4 * kSmallestShare : std::min(1.0, kFactor * s); };
  constexpr double kSmallestShift = 1e-9;  // of the mean diagonal: lifts the three rotations off zero
  double shift = kSmallestShift;
  int small_steps = 0;
  long evaluations = 1;
  while (true) {
    parallel_for(count, [&](std::size_t v) { frames[v] = tangent_frame(positions[v]); });
    problem.hessian(positions, frames, HessianKind::kExact, gradient, hessian);
    ++evaluations;
    result.gradient_norm = std::sqrt(dot(gradient, gradient));
    if (options.observer) {
      const IterationRecord record{result.iterations, seconds(), result.energy, result.gradient_norm,
                                   evaluations};
      if (!options.observer(record, positions)) break;
    }
    if (result.gradient_norm <= options.gradient_tolerance) {
      result.converged = true;
      break;
    }
    if (small_steps >= 2 || result.iterations >= options.maximum_iterations) break;

    bool has_projected = false;
    bool accepted = false;
    double decrease = 0, length = 1, agreement = 1;  // of the energy with its quadratic model
    constexpr int kAttempts = 16;
    for (int attempt = 0; attempt < kAttempts && !accepted; ++attempt) {
      if (share > 0 && !has_projected) {
        problem.hessian(positions, frames, HessianKind::kProjected, unused_gradient, projected);
        has_projected = true;
      }
      if (share > 0) {
        blend(hessian, projected, share, blended);
      }
      const BlockMatrix& matrix = share > 0 ? blended : hessian;
      ++result.factorizations;
      if (!cholesky.factorize(matrix, shift * matrix.mean_diagonal())) {
        if (share >= 1) shift = std::max(100 * shift, 1e-7);
        share = raised(share);
        continue;
      }
      const std::vector<Tangent2> solution = cholesky.solve(gradient);
      const double slope = -dot(gradient, solution);
      // Beyond this the quadratic model says nothing, and triangles could pass through each other.
      constexpr double kLongestStep = 0.3;
      parallel_for(count, [&](std::size_t v) {
        direction[v] = -(solution[v][0] * frames[v].u + solution[v][1] * frames[v].v);
        const double step_length = norm(direction[v]);
        if (step_length > kLongestStep) direction[v] *= kLongestStep / step_length;
      });

      DampedStep step(problem, positions, direction);
      // Below this the energy is all rounding, and the direction is right as it is.
      const bool is_final = -slope < 1e-12 * std::abs(result.energy);
      length = 1;
      for (int halving = 0; halving < 4 && !accepted; ++halving, length /= 2) {
        if (!step.take(length, options.forbid_flips, result.damped_vertices)) continue;
        const double energy = problem.energy(step.result());
        ++evaluations;
        constexpr double kSufficientDecrease = 1e-4;
        accepted = is_final ? energy <= result.energy * (1 + 1e-13)
                            : energy <= result.energy + kSufficientDecrease * length * slope;
        if (accepted) {
          decrease = (result.energy - energy) / std::abs(result.energy);
          agreement = (result.energy - energy) / (-slope * length * (1 - length / 2));
          result.energy = energy;
          positions.swap(step.result());
        }
      }
      if (!accepted) {
        if (share >= 1) shift = std::max(100 * shift, 1e-6);
        share = raised(share);
      }
    }
    if (!accepted) break;
    ++result.iterations;
    shift = std::max(shift / 10, kSmallestShift);
    // `length` has been halved once more than the step.
    if (agreement > 0.6 && length >= 0.5) {
      share /= kFactor;
    } else if (agreement < 0.25) {
      share = raised(share);
    }
    if (share < kSmallestShare) share = 0;
    small_steps = decrease < options.relative_decrease ? small_steps + 1 : 0;
  }
  return result;
}

}  // namespace nmc
