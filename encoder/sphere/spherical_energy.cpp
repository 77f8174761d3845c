// SPDX-License-Identifier: Apache-2.0
#include "encoder/sphere/spherical_energy.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace nmc {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// d_min^2 below this counts as a hemisphere: its square root, 3e-5, is far below any optimised triangle's.
constexpr double kMinimumDistanceSquared = 1e-9;

// The secant triangle in the quantities that the energies are made of.
struct SecantTriangle {
  std::array<double, 3> edge;     // squared lengths a, b, c
  std::array<double, 3> area_by;  // d(area^2)/d(a, b, c)
  double area_squared = 0;
  double radius_squared = 0;  // of the smallest enclosing circle: d_min^2 = 1 - radius_squared
  int longest = -1;           // the edge whose midpoint is nearest to the centre; -1: acute
};

SecantTriangle secant_triangle(const Vec3& x0, const Vec3& x1, const Vec3& x2) {
  SecantTriangle t;
  const Vec3 e0 = x2 - x1, e1 = x0 - x2, e2 = x1 - x0;
  t.edge = {squared_norm(e0), squared_norm(e1), squared_norm(e2)};
  // By cross product, never by Heron's formula: that one cancels on slivers.
  t.area_squared = squared_norm(cross(e1, e2)) / 4;
  // (b + c - a) / 8 is a quarter of the scalar product of the two other edges.
  t.area_by = {-dot(e1, e2) / 4, -dot(e2, e0) / 4, -dot(e0, e1) / 4};
  for (int k = 0; k < 3; ++k)
    if (t.area_by[k] <= 0) t.longest = k;
  if (t.longest >= 0) {
    t.radius_squared = t.edge[t.longest] / 4;
  } else {
    t.radius_squared = t.edge[0] * t.edge[1] * t.edge[2] / (16 * t.area_squared);
  }
  return t;
}

struct FlatEnergy {
  double value = 0;
  double dirichlet = 0;  // of the Dirichlet part alone, for the stretch terms
  double by_area_squared = 0;
};

FlatEnergy flat_energy(const SphereEnergyWeights& w, const ReferenceTriangle& r, const SecantTriangle& t) {
  FlatEnergy e;
  for (int k = 0; k < 3; ++k) e.dirichlet += r.quarter_cotangent[k] * t.edge[k];
  e.value = w.tutte * (t.edge[0] + t.edge[1] + t.edge[2]) + w.dirichlet * e.dirichlet +
            w.area * t.area_squared / r.area;
  e.by_area_squared = w.area / r.area;
  if (w.stretch > 0) {
    const double factor = w.stretch * r.area * r.area / t.area_squared;
    e.value += factor * e.dirichlet;
    e.by_area_squared -= factor * e.dirichlet / t.area_squared;
  }
  if (w.barrier > 0) {
    const double term = w.barrier * r.area * r.area / std::sqrt(t.area_squared);
    e.value += term;
    e.by_area_squared -= term / (2 * t.area_squared);
  }
  return e;
}

bool is_infinite(const SphereEnergyWeights& w, const SecantTriangle& t) {
  if (w.upper_bound && !(1 - t.radius_squared > kMinimumDistanceSquared)) return true;
  return (w.stretch > 0 || w.barrier > 0) && !(t.area_squared > 0);
}

// d(d_min^-2)/d(a, b, c) from d(radius^2).
struct BoundFactor {
  double value = 1;
  std::array<double, 3> radius_by{};
};

BoundFactor bound_factor(const SphereEnergyWeights& w, const SecantTriangle& t) {
  BoundFactor s;
  if (!w.upper_bound) return s;
  s.value = 1 / (1 - t.radius_squared);
  if (t.longest >= 0) {
    s.radius_by[t.longest] = 0.25;
  } else {
    for (int k = 0; k < 3; ++k)
      s.radius_by[k] = t.radius_squared * (1 / t.edge[k] - t.area_by[k] / t.area_squared);
  }
  return s;
}

std::array<double, 3> flat_gradient(const SphereEnergyWeights& w, const ReferenceTriangle& r,
                                    const SecantTriangle& t, const FlatEnergy& e) {
  std::array<double, 3> gradient;
  const double cotangent_weight =
      w.dirichlet + (w.stretch > 0 ? w.stretch * r.area * r.area / t.area_squared : 0);
  for (int k = 0; k < 3; ++k)
    gradient[k] = w.tutte + cotangent_weight * r.quarter_cotangent[k] + e.by_area_squared * t.area_by[k];
  return gradient;
}

}  // namespace

ReferenceTriangle reference_triangle(const Vec3& p0, const Vec3& p1, const Vec3& p2, double area_scale,
                                     double minimum_area) {
  static const double kCotangentOf5Degrees = 1 / std::tan(5 * std::numbers::pi / 180);
  static const double kCotangentOf85Degrees = 1 / std::tan(85 * std::numbers::pi / 180);
  ReferenceTriangle reference;
  const std::array<Vec3, 3> e{p2 - p1, p0 - p2, p1 - p0};
  const double doubled_area = norm(cross(e[1], e[2]));
  for (int k = 0; k < 3; ++k) {
    const double adjacent = -dot(e[(k + 1) % 3], e[(k + 2) % 3]);
    // Zero area gives angles of 0 or 180 degrees: both clip.
    const double cotangent = doubled_area > 0 ? adjacent / doubled_area
                             : adjacent > 0   ? kInfinity
                                              : -kInfinity;
    reference.quarter_cotangent[k] = std::clamp(cotangent, kCotangentOf85Degrees, kCotangentOf5Degrees) / 4;
  }
  reference.area = std::max(0.5 * doubled_area * area_scale, minimum_area);
  return reference;
}

double triangle_energy(const SphereEnergyWeights& weights, const ReferenceTriangle& reference, const Vec3& x0,
                       const Vec3& x1, const Vec3& x2) {
  const SecantTriangle t = secant_triangle(x0, x1, x2);
  if (is_infinite(weights, t)) return kInfinity;
  const double flat = flat_energy(weights, reference, t).value;
  return weights.upper_bound ? flat / (1 - t.radius_squared) : flat;
}

TriangleEnergy triangle_energy_gradient(const SphereEnergyWeights& weights,
                                        const ReferenceTriangle& reference, const Vec3& x0, const Vec3& x1,
                                        const Vec3& x2) {
  TriangleEnergy energy;
  const SecantTriangle t = secant_triangle(x0, x1, x2);
  if (is_infinite(weights, t)) {
    energy.value = kInfinity;
    return energy;
  }
  const FlatEnergy flat = flat_energy(weights, reference, t);
  const std::array<double, 3> flat_by = flat_gradient(weights, reference, t, flat);
  const BoundFactor s = bound_factor(weights, t);
  energy.value = flat.value * s.value;
  for (int k = 0; k < 3; ++k) energy.gradient[k] = s.value * (flat_by[k] + energy.value * s.radius_by[k]);
  return energy;
}

TriangleEnergy triangle_energy_hessian(const SphereEnergyWeights& weights, const ReferenceTriangle& reference,
                                       const Vec3& x0, const Vec3& x1, const Vec3& x2) {
  TriangleEnergy energy;
  const SecantTriangle t = secant_triangle(x0, x1, x2);
  if (is_infinite(weights, t)) {
    energy.value = kInfinity;
    return energy;
  }
  const FlatEnergy flat = flat_energy(weights, reference, t);
  const std::array<double, 3> flat_by = flat_gradient(weights, reference, t, flat);
  const BoundFactor s = bound_factor(weights, t);
  energy.value = flat.value * s.value;

  // Second derivatives of the flat energy: through area^2 twice, and mixed with the cotangent sum (stretch).
  double by_area_squared_twice = 0, mixed = 0;
  if (weights.stretch > 0) {
    mixed = -weights.stretch * reference.area * reference.area / (t.area_squared * t.area_squared);
    by_area_squared_twice -= 2 * mixed * flat.dirichlet / t.area_squared;
  }
  if (weights.barrier > 0)
    by_area_squared_twice += 0.75 * weights.barrier * reference.area * reference.area /
                             (std::sqrt(t.area_squared) * t.area_squared * t.area_squared);

  std::array<double, 3> factor_by;
  for (int k = 0; k < 3; ++k) {
    factor_by[k] = s.value * s.value * s.radius_by[k];
    energy.gradient[k] = s.value * flat_by[k] + flat.value * factor_by[k];
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      const double area_ij = i == j ? -0.125 : 0.125;
      const double flat_ij =
          flat.by_area_squared * area_ij + by_area_squared_twice * t.area_by[i] * t.area_by[j] +
          mixed *
              (reference.quarter_cotangent[i] * t.area_by[j] + reference.quarter_cotangent[j] * t.area_by[i]);
      double factor_ij = 2 * s.value * factor_by[i] * s.radius_by[j];
      if (weights.upper_bound && t.longest < 0) {
        // From the logarithm of radius^2 = a b c / (16 area^2).
        const double log_ij = -(i == j ? 1 / (t.edge[i] * t.edge[i]) : 0) - area_ij / t.area_squared +
                              t.area_by[i] * t.area_by[j] / (t.area_squared * t.area_squared);
        const double radius_ij =
            s.radius_by[i] * s.radius_by[j] / t.radius_squared + t.radius_squared * log_ij;
        factor_ij += s.value * s.value * radius_ij;
      }
      energy.hessian[i][j] = energy.hessian[j][i] =
          s.value * flat_ij + flat_by[i] * factor_by[j] + flat_by[j] * factor_by[i] + flat.value * factor_ij;
    }
  }
  return energy;
}

TriangleEnergy solid_angle_hessian(const Vec3& x0, const Vec3& x1, const Vec3& x2) {
  const SecantTriangle t = secant_triangle(x0, x1, x2);
  const double a = t.edge[0], b = t.edge[1], c = t.edge[2];
  // tan(angle / 2) = volume / base: the corners' triple product, whose square is Gram's determinant, and 1 plus their
  // three scalar products (van Oosterom, Strackee, 1983).
  const double volume = std::sqrt(std::max(4 * t.area_squared - a * b * c / 4, std::numeric_limits<double>::min()));
  const double base = 4 - (a + b + c) / 2;
  constexpr double kBaseBy = -0.5;
  const double norm_squared = volume * volume + base * base;
  const std::array<double, 3> product_by{b * c, c * a, a * b};
  std::array<double, 3> volume_by, numerator_by;
  for (int k = 0; k < 3; ++k) {
    volume_by[k] = (4 * t.area_by[k] - product_by[k] / 4) / (2 * volume);
    numerator_by[k] = base * volume_by[k] - volume * kBaseBy;
  }
  TriangleEnergy angle;
  angle.value = 2 * std::atan2(volume, base);
  for (int i = 0; i < 3; ++i) {
    angle.gradient[i] = 2 * numerator_by[i] / norm_squared;
    for (int j = i; j < 3; ++j) {
      // The third edge multiplies the two others in a b c.
      const double squared_ij = i == j ? -0.5 : 0.5 - t.edge[3 - i - j] / 4;
      const double volume_ij = (squared_ij / 2 - volume_by[i] * volume_by[j]) / volume;
      const double norm_j = 2 * (volume * volume_by[j] + base * kBaseBy);
      // The derivative of the numerator by j: kBaseBy volume_i + base volume_ij - volume_j kBaseBy.
      const double numerator_ij = kBaseBy * (volume_by[i] - volume_by[j]) + base * volume_ij;
      angle.hessian[i][j] = angle.hessian[j][i] =
          2 * numerator_ij / norm_squared - 2 * numerator_by[i] * norm_j / (norm_squared * norm_squared);
    }
  }
  return angle;
}

}  // namespace nmc
