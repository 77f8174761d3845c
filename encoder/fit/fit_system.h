// SPDX-License-Identifier: Apache-2.0
// The least-squares problem over all levels at once, and its Gauss-Newton solver.
//
// One scalar per vertex, critically sampled: the values of all levels are chosen together so that the
// *finest* surface is nearest to the input. Gauss-Newton freezes the normals of the current mesh, which makes
// the mesh linear in its coefficients (SynthesisOperator), solves the linear least squares by preconditioned
// conjugate gradients, and decodes again with the new normals; a step is halved until the true energy falls,
// so the energy never rises.
//
// Any subset of the unknowns may be active. With (nearly) all normal coefficients active the problem is
// preconditioned in the coordinates of the finest vertices' normal displacements, where it is a mass matrix;
// with a sparse subset, by its exact block diagonal.
//
// Based on: Nocedal, Wright, Numerical Optimization, 2006, ch. 5 and 10.
#ifndef NMC_ENCODER_FIT_FIT_SYSTEM_H_
#define NMC_ENCODER_FIT_FIT_SYSTEM_H_

#include <cstdint>
#include <vector>

#include "encoder/fit/galerkin_hierarchy.h"
#include "encoder/fit/quadratic_energy.h"
#include "encoder/fit/synthesis_operator.h"

namespace nmc {

struct MinimizeOptions {
  int maximum_outer = 4;
  int maximum_inner = 30;
  /// Conjugate gradients stop when the preconditioned residual norm has fallen by this factor.
  double inner_tolerance = 0.1;
  /// Outer steps stop when the energy falls by less than this share.
  double outer_tolerance = 1e-3;
  /// Halvings of a step before it is given up.
  int maximum_halvings = 6;
};

struct MinimizeResult {
  double initial_energy = 0, final_energy = 0;
  int outer = 0, inner = 0;
};

class FitSystem {
 public:
  /// `hierarchy` must outlive the system; samples live on its last level, coefficients on the levels below
  /// `layout.coded_level_count`.
  FitSystem(const SubdivisionHierarchy& hierarchy, UnknownLayout layout, std::vector<double> tension = {});

  const UnknownLayout& layout() const { return synthesis_.layout(); }
  SynthesisOperator& synthesis() { return synthesis_; }
  const SynthesisOperator& synthesis() const { return synthesis_; }
  const QuadraticEnergy& energy() const { return energy_; }
  /// Built on first use after each set of samples.
  const GalerkinHierarchy& galerkin();

  /// Takes a new set of correspondences; `positions` are the current finest vertices.
  void set_samples(const std::vector<SurfaceSample>& samples, const std::vector<Vec3>& positions,
                   const QuadraticEnergyOptions& options);

  double energy_of(const std::vector<double>& values) const;

  /// Lowers the energy over the unknowns with active[i] != 0. Never raises it.
  MinimizeResult minimize(const std::vector<std::uint8_t>& active, const MinimizeOptions& options,
                          std::vector<double>& values);

 private:
  void prepare_preconditioner(const std::vector<std::uint8_t>& active);
  void precondition(const std::vector<std::uint8_t>& active, const std::vector<double>& residual,
                    std::vector<double>& result);

  SynthesisOperator synthesis_;
  QuadraticEnergy energy_;
  GalerkinHierarchy galerkin_;
  bool galerkin_is_current_ = false;
  bool dense_ = false;                    // which preconditioner
  std::vector<double> inverse_diagonal_;  // of odd unknowns
  std::vector<double> base_inverse_;      // 9 per base vertex
  std::vector<double> scratch_;
};

}  // namespace nmc

#endif  // NMC_ENCODER_FIT_FIT_SYSTEM_H_
