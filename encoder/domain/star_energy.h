// SPDX-License-Identifier: Apache-2.0
// The combined Dirichlet and area energy of the triangles around one vertex, as a function of that vertex
// alone.
//
// Based on: Friedel, Schroeder, Desbrun (2007) for the combination; in the plane, with A the signed area of
// the image and A_t its target, E = w_D/4 sum cot |e|^2 + w_A A^2/A_t is exactly quadratic in one vertex. The
// optional barrier w_B A_t^2/A keeps triangles from collapsing.
#ifndef NMC_ENCODER_DOMAIN_STAR_ENERGY_H_
#define NMC_ENCODER_DOMAIN_STAR_ENERGY_H_

#include <algorithm>
#include <array>
#include <cmath>

#include "libnmc/common/vec3.h"

namespace nmc {

struct EnergyWeights {
  double dirichlet = 1, area = 4, barrier = 0;
};

/// Shape of a surface triangle: cotangents of its angles, clipped to [5, 85] degrees so that all weights are
/// positive and bounded, and its area.
struct TriangleShape {
  std::array<double, 3> cotangents{};
  double area = 0;
};

inline TriangleShape triangle_shape(const Vec3& a, const Vec3& b, const Vec3& c) {
  constexpr double kSteepest = 11.430052302761343, kFlattest = 0.087488663525924005;  // cot 5, cot 85 degrees
  const Vec3* p[3] = {&a, &b, &c};
  TriangleShape shape;
  const double doubled = norm(cross(b - a, c - a));
  shape.area = 0.5 * doubled;
  for (int k = 0; k < 3; ++k) {
    const double cosine = dot(*p[(k + 1) % 3] - *p[k], *p[(k + 2) % 3] - *p[k]);
    shape.cotangents[k] = doubled > 0 ? std::clamp(cosine / doubled, kFlattest, kSteepest) : kFlattest;
  }
  return shape;
}

/// Gradient and Hessian of the star's energy in Cartesian coordinates (base edges have length 1).
struct StarModel {
  double gx = 0, gy = 0, hxx = 0, hxy = 0, hyy = 0, energy = 0;

  /// Adds the triangle (z, q, r), counter-clockwise, with the cotangents at q and r and the target area.
  void add(const EnergyWeights& w, double zx, double zy, double qx, double qy, double rx, double ry,
           double cot_q, double cot_r, double target) {
    const double area = 0.5 * ((qx - zx) * (ry - zy) - (qy - zy) * (rx - zx));
    const double ax = 0.5 * (qy - ry), ay = 0.5 * (rx - qx);
    const double d = 0.5 * w.dirichlet;
    gx += d * (cot_q * (zx - rx) + cot_r * (zx - qx));
    gy += d * (cot_q * (zy - ry) + cot_r * (zy - qy));
    double slope = 2 * w.area * area / target, curvature = 2 * w.area / target;
    if (w.barrier > 0 && area > 0) {
      const double ratio = target / area;
      slope -= w.barrier * ratio * ratio;
      curvature += 2 * w.barrier * ratio * ratio / area;
    }
    gx += slope * ax;
    gy += slope * ay;
    hxx += d * (cot_q + cot_r) + curvature * ax * ax;
    hyy += d * (cot_q + cot_r) + curvature * ay * ay;
    hxy += curvature * ax * ay;
  }

  /// The Newton step, free or along the unit direction (dx, dy).
  std::array<double, 2> step() const {
    const double determinant = hxx * hyy - hxy * hxy;
    if (!(determinant > 0)) return {0, 0};
    return {-(hyy * gx - hxy * gy) / determinant, -(hxx * gy - hxy * gx) / determinant};
  }
  std::array<double, 2> step_along(double dx, double dy) const {
    const double curvature = hxx * dx * dx + 2 * hxy * dx * dy + hyy * dy * dy;
    if (!(curvature > 0)) return {0, 0};
    const double length = -(gx * dx + gy * dy) / curvature;
    return {length * dx, length * dy};
  }
};

}  // namespace nmc

#endif  // NMC_ENCODER_DOMAIN_STAR_ENERGY_H_
