// SPDX-License-Identifier: Apache-2.0
// Point-to-plane distance to the samples as an exact quadratic function of the finest vertices.
//
//   E(x) = 1/2 sum_q w_q [ (1 - tau) (N_q . r_q)^2 + tau |r_q|^2 ],   r_q = sum_i b_qi x_i - target_q
//
// With the correspondences fixed every residual is linear in the vertices, so E is given by its value and
// gradient at one reference state and one symmetric 3x3 block per vertex and per edge: the samples are
// streamed once per set of correspondences, and everything after that (energies, gradients, Hessian products)
// costs seven blocks per vertex.
//
// Based on: Chen, Medioni, Object modelling by registration of multiple range images, 1992 (point-to-plane);
// Huber, Robust estimation of a location parameter, 1964 (weights).
#ifndef NMC_ENCODER_FIT_QUADRATIC_ENERGY_H_
#define NMC_ENCODER_FIT_QUADRATIC_ENERGY_H_

#include <cstdint>
#include <vector>

#include "encoder/normal_mesh/surface_samples.h"
#include "libnmc/common/subdivision.h"
#include "libnmc/common/vec3.h"

namespace nmc {

struct SymmetricMatrix3 {
  float xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;

  Vec3 operator*(const Vec3& v) const {
    return {xx * v.x + xy * v.y + xz * v.z, xy * v.x + yy * v.y + yz * v.z, xz * v.x + yz * v.y + zz * v.z};
  }
  SymmetricMatrix3& operator+=(const SymmetricMatrix3& b) {
    xx += b.xx;
    xy += b.xy;
    xz += b.xz;
    yy += b.yy;
    yz += b.yz;
    zz += b.zz;
    return *this;
  }
  /// this += s * b.
  void add(float s, const SymmetricMatrix3& b) {
    xx += s * b.xx;
    xy += s * b.xy;
    xz += s * b.xz;
    yy += s * b.yy;
    yz += s * b.yz;
    zz += s * b.zz;
  }
};

struct QuadraticEnergyOptions {
  /// Share tau of the full distance: keeps vertices from sliding along the surface.
  double tangential_share = 0.02;
  /// Residuals beyond this many RMS residuals count linearly (Huber); 0: all count squared.
  double huber_multiple = 0;
  /// Samples farther than this from their targets weigh more, by the square of the ratio: a few places far off are
  /// worse than the mean tells. 0: none do.
  double spike_distance = 0;
};

/// Memory: about 270 bytes per vertex.
class QuadraticEnergy {
 public:
  /// `finest` must outlive the object.
  explicit QuadraticEnergy(const LevelTopology& finest);

  /// Streams the samples once; `reference` are the positions at which robust weights are taken and around
  /// which the energy is expanded (exact everywhere, most accurate near it). O(samples), deterministic.
  void assemble(const std::vector<SurfaceSample>& samples, const std::vector<Vec3>& reference,
                const QuadraticEnergyOptions& options);

  double value(const std::vector<Vec3>& positions) const;
  /// Returns the energy and fills its gradient per vertex.
  double gradient(const std::vector<Vec3>& positions, std::vector<Vec3>& gradient) const;
  /// product = A v.
  void multiply(const std::vector<Vec3>& v, std::vector<Vec3>& product) const;

  /// Sum of the sample weights: sqrt(2 E / total_weight) is an RMS distance.
  double total_weight() const { return total_weight_; }
  double root_mean_square(double energy) const;

  // The Hessian, for those who build on it. Neighbours of vertex v: [neighbor_begin[v], neighbor_begin[v +
  // 1]).
  struct Neighbor {
    std::uint32_t vertex, edge;
  };
  const std::vector<SymmetricMatrix3>& diagonal_blocks() const { return diagonal_; }
  /// Of neighbors()[k] with its vertex: each edge's block stands here twice.
  const std::vector<SymmetricMatrix3>& neighbor_blocks() const { return neighbor_blocks_; }
  const std::vector<std::uint32_t>& neighbor_begin() const { return neighbor_begin_; }
  const std::vector<Neighbor>& neighbors() const { return neighbors_; }

 private:
  const LevelTopology& finest_;
  std::vector<std::uint32_t> neighbor_begin_;
  std::vector<Neighbor> neighbors_;
  std::vector<SymmetricMatrix3> diagonal_, neighbor_blocks_;
  std::vector<Vec3> reference_, reference_gradient_;
  double reference_energy_ = 0, total_weight_ = 0;
};

}  // namespace nmc

#endif  // NMC_ENCODER_FIT_QUADRATIC_ENERGY_H_
