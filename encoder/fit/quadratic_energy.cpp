// SPDX-License-Identifier: Apache-2.0
#include "encoder/fit/quadratic_energy.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "encoder/core/error.h"
#include "encoder/core/parallel.h"

namespace nmc {

namespace {

/// Places that nothing can mend must not outweigh all the rest.
constexpr double kLargestSpikeWeight = 9;

struct FaceContribution {
  std::array<SymmetricMatrix3, 3> diagonal;  // of corner k
  std::array<SymmetricMatrix3, 3> opposite;  // of the edge opposite to corner k
  std::array<Vec3, 3> gradient;
  double energy = 0, weight = 0;
};

Vec3 residual_of(const SurfaceSample& sample, const LevelTopology& finest, const std::vector<Vec3>& x) {
  const std::uint32_t* corners = finest.face_vertices.data() + std::size_t{3} * sample.face;
  return static_cast<double>(sample.barycentric[0]) * x[corners[0]] +
         static_cast<double>(sample.barycentric[1]) * x[corners[1]] +
         static_cast<double>(sample.barycentric[2]) * x[corners[2]] - sample.target;
}

}  // namespace

QuadraticEnergy::QuadraticEnergy(const LevelTopology& finest) : finest_(finest) {
  neighbor_begin_.assign(std::size_t{finest.vertex_count} + 1, 0);
  for (const std::uint32_t v : finest.edge_vertices) ++neighbor_begin_[v + 1];
  for (std::uint32_t v = 0; v < finest.vertex_count; ++v) neighbor_begin_[v + 1] += neighbor_begin_[v];
  neighbors_.resize(2 * std::size_t{finest.edge_count});
  std::vector<std::uint32_t> next(neighbor_begin_.begin(), neighbor_begin_.end() - 1);
  for (std::uint32_t e = 0; e < finest.edge_count; ++e) {
    const std::uint32_t a = finest.edge_vertices[2 * e], b = finest.edge_vertices[2 * e + 1];
    neighbors_[next[a]++] = {b, e};
    neighbors_[next[b]++] = {a, e};
  }
}

void QuadraticEnergy::assemble(const std::vector<SurfaceSample>& samples, const std::vector<Vec3>& reference,
                               const QuadraticEnergyOptions& options) {
  const std::size_t face_count = finest_.face_count;
  // Samples by face: a counting sort that keeps their order, so that sums do not depend on threads.
  std::vector<std::uint32_t> begin(face_count + 1, 0);
  bool sorted = true;
  std::uint32_t previous = 0;
  for (const SurfaceSample& sample : samples) {
    if (sample.face >= face_count)
      throw Error(ExitCode::kInternal, "a surface sample names a face that does not exist");
    sorted = sorted && sample.face >= previous;
    previous = sample.face;
    ++begin[sample.face + 1];
  }
  for (std::size_t f = 0; f < face_count; ++f) begin[f + 1] += begin[f];
  std::vector<std::uint32_t> order;
  if (!sorted) {
    order.resize(samples.size());
    std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
    for (std::size_t i = 0; i < samples.size(); ++i)
      order[next[samples[i].face]++] = static_cast<std::uint32_t>(i);
  }

  double huber_threshold = 0;
  if (options.huber_multiple > 0) {
    struct Moments {
      double square = 0, weight = 0;
      Moments& operator+=(const Moments& m) {
        square += m.square;
        weight += m.weight;
        return *this;
      }
    };
    const Moments moments = parallel_sum<Moments>(samples.size(), [&](std::size_t i) {
      const double d = dot(samples[i].normal, residual_of(samples[i], finest_, reference));
      return Moments{samples[i].weight * d * d, samples[i].weight};
    });
    if (moments.weight > 0)
      huber_threshold = options.huber_multiple * std::sqrt(moments.square / moments.weight);
  }

  const double tau = options.tangential_share;
  const auto contribution_of = [&](std::size_t face) {
    FaceContribution c;
    for (std::uint32_t s = begin[face]; s < begin[face + 1]; ++s) {
      const SurfaceSample& sample = samples[sorted ? s : order[s]];
      const Vec3 r = residual_of(sample, finest_, reference);
      const Vec3& n = sample.normal;
      const double d = dot(n, r);
      double w = sample.weight;
      if (huber_threshold > 0 && std::abs(d) > huber_threshold) w *= huber_threshold / std::abs(d);
      const Vec3 force = w * ((1 - tau) * d * n + tau * r);
      if (options.spike_distance > 0) {
        const double ratio = squared_norm(r) / (options.spike_distance * options.spike_distance);
        if (ratio > 1) w *= std::min(ratio, kLargestSpikeWeight);
      }
      c.energy += 0.5 * w * ((1 - tau) * d * d + tau * squared_norm(r));
      c.weight += w;
      const auto f = [&](double value) { return static_cast<float>(w * value); };
      const double m = 1 - tau;
      const SymmetricMatrix3 block = {f(m * n.x * n.x + tau), f(m * n.x * n.y), f(m * n.x * n.z),
                                      f(m * n.y * n.y + tau), f(m * n.y * n.z), f(m * n.z * n.z + tau)};
      for (std::size_t k = 0; k < 3; ++k) {
        const float b = sample.barycentric[k];
        c.diagonal[k].add(b * b, block);
        c.opposite[k].add(sample.barycentric[(k + 1) % 3] * sample.barycentric[(k + 2) % 3], block);
        c.gradient[k] += static_cast<double>(b) * force;
      }
    }
    return c;
  };

  diagonal_.assign(finest_.vertex_count, {});
  std::vector<SymmetricMatrix3> edges(finest_.edge_count);
  reference_ = reference;
  reference_gradient_.assign(finest_.vertex_count, {});
  reference_energy_ = 0;
  total_weight_ = 0;
  // Blocks of faces: contributions in parallel, their sums in the order of the faces.
  constexpr std::size_t kBlock = std::size_t{1} << 14;
  std::vector<FaceContribution> contributions(std::min(kBlock, face_count));
  for (std::size_t first = 0; first < face_count; first += kBlock) {
    const std::size_t count = std::min(kBlock, face_count - first);
    parallel_for(count, [&](std::size_t i) { contributions[i] = contribution_of(first + i); });
    for (std::size_t i = 0; i < count; ++i) {
      const FaceContribution& c = contributions[i];
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t corner = 3 * (first + i) + k;
        diagonal_[finest_.face_vertices[corner]] += c.diagonal[k];
        edges[finest_.face_edges[corner]] += c.opposite[k];
        reference_gradient_[finest_.face_vertices[corner]] += c.gradient[k];
      }
      reference_energy_ += c.energy;
      total_weight_ += c.weight;
    }
  }
  // Each block twice, but in the order in which products take them: they wait for memory, not for arithmetic.
  neighbor_blocks_.resize(neighbors_.size());
  parallel_for(neighbors_.size(), [&](std::size_t k) { neighbor_blocks_[k] = edges[neighbors_[k].edge]; });
}

void QuadraticEnergy::multiply(const std::vector<Vec3>& v, std::vector<Vec3>& product) const {
  product.resize(v.size());
  parallel_for(finest_.vertex_count, [&](std::size_t i) {
    Vec3 sum = diagonal_[i] * v[i];
    for (std::uint32_t k = neighbor_begin_[i]; k < neighbor_begin_[i + 1]; ++k)
      sum += neighbor_blocks_[k] * v[neighbors_[k].vertex];
    product[i] = sum;
  });
}

double QuadraticEnergy::gradient(const std::vector<Vec3>& positions, std::vector<Vec3>& result) const {
  std::vector<Vec3> difference(positions.size());
  parallel_for(positions.size(), [&](std::size_t i) { difference[i] = positions[i] - reference_[i]; });
  multiply(difference, result);
  const double energy = parallel_sum<double>(positions.size(), [&](std::size_t i) {
    return dot(difference[i], reference_gradient_[i]) + 0.5 * dot(difference[i], result[i]);
  });
  parallel_for(positions.size(), [&](std::size_t i) { result[i] += reference_gradient_[i]; });
  return reference_energy_ + energy;
}

double QuadraticEnergy::value(const std::vector<Vec3>& positions) const {
  std::vector<Vec3> unused;
  return gradient(positions, unused);
}

double QuadraticEnergy::root_mean_square(double energy) const {
  return total_weight_ > 0 && energy > 0 ? std::sqrt(2 * energy / total_weight_) : 0;
}

}  // namespace nmc
