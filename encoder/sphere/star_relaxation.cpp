// SPDX-License-Identifier: Apache-2.0
#include "encoder/sphere/star_relaxation.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace nmc {

namespace {

double star_energy(const SphereEnergyWeights& weights, const std::vector<StarTriangle>& star, const Vec3& x) {
  double energy = 0;
  for (const StarTriangle& t : star) {
    if (!is_safely_oriented(x, t.second, t.third)) return std::numeric_limits<double>::infinity();
    energy += triangle_energy(weights, t.reference, x, t.second, t.third);
  }
  return energy;
}

// The minimizer of the quadratic model with the eigenvalues of [[xx, xy], [xy, yy]] replaced by absolute
// values.
Tangent2 newton_direction(double xx, double xy, double yy, const Tangent2& g) {
  const double mean = (xx + yy) / 2, half = (xx - yy) / 2;
  const double radius = std::hypot(half, xy);
  const double floor_value = 1e-9 * (std::abs(mean) + radius) + std::numeric_limits<double>::min();
  const double large = std::max(std::abs(mean + radius), floor_value);
  const double small = std::max(std::abs(mean - radius), floor_value);
  // Unit eigenvector of the larger eigenvalue.
  double cx = 1, cy = 0;
  if (radius > 0) {
    const double angle = 0.5 * std::atan2(xy, half);
    cx = std::cos(angle);
    cy = std::sin(angle);
  }
  const double along = -(cx * g[0] + cy * g[1]) / large, across = -(-cy * g[0] + cx * g[1]) / small;
  return {cx * along - cy * across, cy * along + cx * across};
}

}  // namespace

Vec3 relax_star(const SphereEnergyWeights& weights, const std::vector<StarTriangle>& star, const Vec3& center,
                int iterations) {
  Vec3 x = center;
  double energy = star_energy(weights, star, x);
  if (!std::isfinite(energy)) return center;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    const TangentFrame frame = tangent_frame(x);
    Tangent2 gradient{};
    double xx = 0, xy = 0, yy = 0;
    for (const StarTriangle& t : star) {
      const TriangleEnergy e = triangle_energy_hessian(weights, t.reference, x, t.second, t.third);
      // Edge 1 joins the third corner with the centre, edge 2 the centre with the second.
      const Vec3 d1 = x - t.third, d2 = x - t.second;
      const double b[2] = {2 * dot(frame.u, d1), 2 * dot(frame.v, d1)};
      const double c[2] = {2 * dot(frame.u, d2), 2 * dot(frame.v, d2)};
      for (int k = 0; k < 2; ++k) gradient[k] += e.gradient[1] * b[k] + e.gradient[2] * c[k];
      const double diagonal = 2 * (e.gradient[1] * dot(x, t.third) + e.gradient[2] * dot(x, t.second));
      const double bb = e.hessian[1][1], bc = e.hessian[1][2], cc = e.hessian[2][2];
      xx += bb * b[0] * b[0] + 2 * bc * b[0] * c[0] + cc * c[0] * c[0] + diagonal;
      xy += bb * b[0] * b[1] + bc * (b[0] * c[1] + b[1] * c[0]) + cc * c[0] * c[1];
      yy += bb * b[1] * b[1] + 2 * bc * b[1] * c[1] + cc * c[1] * c[1] + diagonal;
    }
    Tangent2 step = newton_direction(xx, xy, yy, gradient);
    constexpr double kLongestStep = 0.5;
    const double length = std::hypot(step[0], step[1]);
    if (length > kLongestStep)
      for (double& s : step) s *= kLongestStep / length;

    bool improved = false;
    double scale = 1;
    for (int halving = 0; halving < 8; ++halving, scale /= 2) {
      const Vec3 candidate = retract(x, scale * (step[0] * frame.u + step[1] * frame.v));
      const double candidate_energy = star_energy(weights, star, candidate);
      if (!(candidate_energy < energy)) continue;
      constexpr double kWorthAnotherStep = 1e-3;
      improved = energy - candidate_energy > kWorthAnotherStep * energy;
      energy = candidate_energy;
      x = candidate;
      break;
    }
    if (!improved) break;
  }
  return x;
}

void gauss_seidel_sweep(const SphereProblem& problem, std::vector<Vec3>& positions) {
  std::vector<StarTriangle> star;
  for (std::uint32_t v = 0; v < problem.vertex_count(); ++v) {
    star.clear();
    for (std::uint32_t i = problem.corner_offsets()[v]; i < problem.corner_offsets()[v + 1]; ++i) {
      const std::uint32_t f = problem.corners()[i] / 3, k = problem.corners()[i] % 3;
      const Triangle& t = problem.triangles()[f];
      const ReferenceTriangle& r = problem.references()[f];
      StarTriangle triangle;
      triangle.second = positions[t[(k + 1) % 3]];
      triangle.third = positions[t[(k + 2) % 3]];
      triangle.reference.area = r.area;
      for (std::uint32_t c = 0; c < 3; ++c)
        triangle.reference.quarter_cotangent[c] = r.quarter_cotangent[(k + c) % 3];
      star.push_back(triangle);
    }
    positions[v] = relax_star(problem.weights(), star, positions[v], 1);
  }
}

}  // namespace nmc
