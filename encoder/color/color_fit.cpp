// SPDX-License-Identifier: Apache-2.0
#include "encoder/color/color_fit.h"

#include <algorithm>
#include <cmath>

#include "encoder/core/parallel.h"

namespace nmc {

namespace {

using Weights = std::array<double, 3>;

/// Centres of the four parts of a triangle, as weights of its corners.
constexpr std::array<Weights, ColorSamples::kPerTriangle> kCenters = {{{2.0 / 3, 1.0 / 6, 1.0 / 6},
                                                                       {1.0 / 6, 2.0 / 3, 1.0 / 6},
                                                                       {1.0 / 6, 1.0 / 6, 2.0 / 3},
                                                                       {1.0 / 3, 1.0 / 3, 1.0 / 3}}};

/// Weights of the corners of child `part` of a face to those of the face itself
/// (libnmc/common/subdivision.h).
Weights in_parent(const Weights& w, std::uint32_t part) {
  if (part == 3) return {0.5 * (w[1] + w[2]), 0.5 * (w[0] + w[2]), 0.5 * (w[0] + w[1])};
  Weights result = {0.5 * w[0], 0.5 * w[1], 0.5 * w[2]};
  result[part] += 0.5;
  return result;
}

}  // namespace

ColorSamples::ColorSamples(const LevelTopology& topology, const std::vector<Vec3>& positions,
                           const SurfaceIndex& input, const std::vector<RgbByte>& input_colors)
    : colors(topology.face_count), weights(topology.face_count) {
  double area_sum = 0;
  for (std::uint32_t f = 0; f < topology.face_count; ++f) {
    const std::uint32_t* v = topology.face_vertices.data() + std::size_t{3} * f;
    const Vec3 n = cross(positions[v[1]] - positions[v[0]], positions[v[2]] - positions[v[0]]);
    weights[f] = static_cast<float>(std::sqrt(dot(n, n)));
    area_sum += weights[f];
  }
  const double mean = area_sum > 0 ? area_sum / topology.face_count : 1;
  // No triangle is quite without weight, so that every vertex has an equation.
  for (float& w : weights) w = static_cast<float>(w / mean + 1e-3);

  parallel_for(topology.face_count, [&](std::size_t f) {
    const std::uint32_t* v = topology.face_vertices.data() + 3 * f;
    for (std::size_t s = 0; s < kPerTriangle; ++s) {
      const Weights& w = kCenters[s];
      const Vec3 point = w[0] * positions[v[0]] + w[1] * positions[v[1]] + w[2] * positions[v[2]];
      const SurfacePoint nearest = input.closest_point(point);
      if (!nearest.found()) continue;
      const Triangle& corners = input.triangles()[nearest.triangle];
      for (std::size_t k = 0; k < 3; ++k) {
        double value = 0;
        for (std::size_t i = 0; i < 3; ++i) value += nearest.barycentric[i] * input_colors[corners[i]][k];
        colors[f][s][k] = static_cast<float>(value);
      }
    }
  });
}

ColorFit::ColorFit(const ColorSamples& samples, const LevelTopology& topology, int levels_between)
    : topology_(topology),
      masses_(topology.face_count),
      right_side_(topology.vertex_count),
      diagonal_(topology.vertex_count) {
  // The descendants of a face are numbered one after the other.
  const std::size_t descendants = std::size_t{1} << (2 * levels_between);
  for (std::uint32_t face = 0; face < topology.face_count; ++face) {
    const std::uint32_t* v = topology.face_vertices.data() + std::size_t{3} * face;
    std::array<double, 6> mass{};
    for (std::size_t part = 0; part < descendants; ++part) {
      const std::size_t sampled = face * descendants + part;
      const double weight = samples.weights[sampled];
      for (std::size_t s = 0; s < ColorSamples::kPerTriangle; ++s) {
        Weights w = kCenters[s];
        for (int level = 0; level < levels_between; ++level)
          w = in_parent(w, static_cast<std::uint32_t>((part >> (2 * level)) & 3));
        const RgbValue& color = samples.colors[sampled][s];
        for (std::size_t i = 0; i < 3; ++i) {
          mass[i] += weight * w[i] * w[i];
          for (std::size_t k = 0; k < 3; ++k) right_side_[v[i]][k] += weight * w[i] * color[k];
        }
        mass[3] += weight * w[0] * w[1];
        mass[4] += weight * w[0] * w[2];
        mass[5] += weight * w[1] * w[2];
        weight_sum_ += weight;
        for (const float value : color) square_sum_ += weight * value * value;
      }
    }
    for (std::size_t i = 0; i < 6; ++i) masses_[face][i] = static_cast<float>(mass[i]);
    for (std::size_t i = 0; i < 3; ++i) diagonal_[v[i]] += mass[i];
  }
}

void ColorFit::multiply(const std::vector<Sum>& x, std::vector<Sum>& y) const {
  y.assign(x.size(), {});
  for (std::uint32_t f = 0; f < topology_.face_count; ++f) {
    const std::uint32_t* v = topology_.face_vertices.data() + std::size_t{3} * f;
    const std::array<float, 6>& m = masses_[f];
    for (std::size_t k = 0; k < 3; ++k) {
      const double a = x[v[0]][k], b = x[v[1]][k], c = x[v[2]][k];
      y[v[0]][k] += m[0] * a + m[3] * b + m[4] * c;
      y[v[1]][k] += m[3] * a + m[1] * b + m[5] * c;
      y[v[2]][k] += m[4] * a + m[5] * b + m[2] * c;
    }
  }
}

std::vector<RgbValue> ColorFit::solve() const {
  constexpr int kSteps =
      12;  // scaled by its diagonal, a mass matrix of triangles has a condition number of about 4
  const std::size_t count = right_side_.size();
  std::vector<Sum> x(count), r = right_side_, z(count), p, product;
  for (std::size_t v = 0; v < count; ++v)
    for (std::size_t k = 0; k < 3; ++k) x[v][k] = 0.5 * scaled(v, right_side_[v][k]);
  multiply(x, product);
  Sum rz{};
  for (std::size_t v = 0; v < count; ++v)
    for (std::size_t k = 0; k < 3; ++k) {
      r[v][k] -= product[v][k];
      z[v][k] = scaled(v, r[v][k]);
      rz[k] += r[v][k] * z[v][k];
    }
  p = z;
  for (int step = 0; step < kSteps; ++step) {
    multiply(p, product);
    Sum curvature{}, next{};
    for (std::size_t v = 0; v < count; ++v)
      for (std::size_t k = 0; k < 3; ++k) curvature[k] += p[v][k] * product[v][k];
    for (std::size_t k = 0; k < 3; ++k) {
      const double alpha = curvature[k] > 0 ? rz[k] / curvature[k] : 0;
      for (std::size_t v = 0; v < count; ++v) {
        x[v][k] += alpha * p[v][k];
        r[v][k] -= alpha * product[v][k];
        z[v][k] = scaled(v, r[v][k]);
        next[k] += r[v][k] * z[v][k];
      }
      const double beta = rz[k] > 0 ? next[k] / rz[k] : 0;
      for (std::size_t v = 0; v < count; ++v) p[v][k] = z[v][k] + beta * p[v][k];
    }
    rz = next;
  }
  std::vector<RgbValue> colors(count);
  for (std::size_t v = 0; v < count; ++v)
    for (std::size_t k = 0; k < 3; ++k) colors[v][k] = static_cast<float>(std::clamp(x[v][k], 0.0, 255.0));
  return colors;
}

double ColorFit::mean_squared_error(const std::vector<RgbValue>& colors) const {
  std::vector<Sum> x(colors.size()), product;
  for (std::size_t v = 0; v < colors.size(); ++v)
    for (std::size_t k = 0; k < 3; ++k) x[v][k] = colors[v][k];
  multiply(x, product);
  double sum = square_sum_;
  for (std::size_t v = 0; v < colors.size(); ++v)
    for (std::size_t k = 0; k < 3; ++k) sum += x[v][k] * (product[v][k] - 2 * right_side_[v][k]);
  return weight_sum_ > 0 ? std::max(sum, 0.0) / (3 * weight_sum_) : 0;
}

}  // namespace nmc
