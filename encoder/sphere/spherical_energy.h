// SPDX-License-Identifier: Apache-2.0
// The distortion energies of one spherical triangle, as functions of its three squared edge lengths.
//
// Based on: I. Friedel, thesis, section 4.3 and Fig. 4.6 (upper bounds of the Tutte, Dirichlet, squared area
// and stretch energies by the factor d_min^-2). Written over the squared edge lengths a, b, c of the secant
// triangle the energy has a 3 x 3 Hessian in closed form, without the poles of longitude and latitude.
#ifndef NMC_ENCODER_SPHERE_SPHERICAL_ENERGY_H_
#define NMC_ENCODER_SPHERE_SPHERICAL_ENERGY_H_

#include <array>

#include "libnmc/common/vec3.h"

namespace nmc {

/// Weights of the classical energies; each is scaled so that an isometry costs the triangle's own area (all
/// but Tutte's, which ignores the reference). At least one of them must be positive.
struct SphereEnergyWeights {
  double tutte = 0;      // squared edge lengths, unit springs (4.5)
  double dirichlet = 1;  // angles, cotangents clipped to [5, 85] degrees (4.4)
  double area = 1;       // A_N^2 / A_M
  double stretch = 0;    // (A_M / A_N)^2 times the Dirichlet energy; infinite where a triangle degenerates
  double barrier = 0;    // A_M^2 / A_N: keeps first-order methods away from degenerate triangles
  /// The d_min^-2 factor. Without it the energies underestimate and the sphere may collapse (Fig. 4.4): only
  /// for that experiment.
  bool upper_bound = true;

  /// Only areas count: the hardest of all energies (nearly every area-preserving map is nearly optimal).
  bool is_area_alone() const { return tutte == 0 && dirichlet == 0 && stretch == 0 && barrier == 0; }
};

/// What the energy needs to know of the triangle of the input surface.
struct ReferenceTriangle {
  std::array<double, 3> quarter_cotangent{};  // cot(angle k) / 4, of the angle opposite to edge k
  double area = 0;                            // scaled so that all areas add up to 4 pi
};

/// Value and derivatives by the squared lengths of the edges opposite to corners 0, 1, 2.
struct TriangleEnergy {
  double value =
      0;  // infinite where the triangle reaches a hemisphere, or degenerates under stretch or barrier
  std::array<double, 3> gradient{};
  std::array<std::array<double, 3>, 3> hessian{};
};

/// `area_scale` is 4 pi over the surface's total area; areas below `minimum_area` are raised to it, which
/// keeps degenerate input triangles from dominating.
ReferenceTriangle reference_triangle(const Vec3& p0, const Vec3& p1, const Vec3& p2, double area_scale,
                                     double minimum_area);

/// Corners are unit vectors. About 30 ns.
double triangle_energy(const SphereEnergyWeights& weights, const ReferenceTriangle& reference, const Vec3& x0,
                       const Vec3& x1, const Vec3& x2);

/// The same with first derivatives (the Hessian stays zero).
TriangleEnergy triangle_energy_gradient(const SphereEnergyWeights& weights,
                                        const ReferenceTriangle& reference, const Vec3& x0, const Vec3& x1,
                                        const Vec3& x2);

/// The same with first and second derivatives. Continuous across the right-angled triangles in value and
/// gradient; the Hessian jumps there.
TriangleEnergy triangle_energy_hessian(const SphereEnergyWeights& weights, const ReferenceTriangle& reference,
                                       const Vec3& x0, const Vec3& x1, const Vec3& x2);

/// The solid angle of the triangle, with derivatives like an energy's: over a closed surface it adds up to a constant,
/// so any multiple of its Hessian may be taken from every triangle without changing the sum.
TriangleEnergy solid_angle_hessian(const Vec3& x0, const Vec3& x1, const Vec3& x2);

}  // namespace nmc

#endif  // NMC_ENCODER_SPHERE_SPHERICAL_ENERGY_H_
