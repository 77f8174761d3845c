// SPDX-License-Identifier: Apache-2.0
#include "encoder/fit/fit_system.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "encoder/core/parallel.h"

namespace nmc {

namespace {

double quadratic_form(const SymmetricMatrix3& m, const Vec3& v) { return dot(v, m * v); }

/// Inverse of a symmetric positive semidefinite block, made definite by a share of its trace.
void invert(const SymmetricMatrix3& m, double* inverse) {
  const double shift = 1e-9 * (double{m.xx} + m.yy + m.zz) + 1e-300;
  const double a = m.xx + shift, b = m.xy, c = m.xz, d = m.yy + shift, e = m.yz, f = m.zz + shift;
  const double A = d * f - e * e, B = c * e - b * f, C = b * e - c * d;
  const double determinant = a * A + b * B + c * C;
  const double s = determinant > 0 ? 1 / determinant : 0;
  const double values[9] = {s * A,
                            s * B,
                            s * C,
                            s * B,
                            s * (a * f - c * c),
                            s * (b * c - a * e),
                            s * C,
                            s * (b * c - a * e),
                            s * (a * d - b * b)};
  std::copy(values, values + 9, inverse);
}

double inner_product(const std::vector<double>& a, const std::vector<double>& b) {
  return parallel_sum<double>(a.size(), [&](std::size_t i) { return a[i] * b[i]; });
}

}  // namespace

FitSystem::FitSystem(const SubdivisionHierarchy& hierarchy, UnknownLayout layout, std::vector<double> tension)
    : synthesis_(hierarchy, std::move(layout), std::move(tension)),
      energy_(hierarchy.level(hierarchy.level_count())) {}

const GalerkinHierarchy& FitSystem::galerkin() {
  if (!galerkin_is_current_) galerkin_.build(synthesis_, energy_);
  galerkin_is_current_ = true;
  return galerkin_;
}

void FitSystem::set_samples(const std::vector<SurfaceSample>& samples, const std::vector<Vec3>& positions,
                            const QuadraticEnergyOptions& options) {
  energy_.assemble(samples, positions, options);
  galerkin_is_current_ = false;
}

double FitSystem::energy_of(const std::vector<double>& values) const {
  std::vector<Vec3> positions;
  synthesis_.positions_of(values, positions);
  return energy_.value(positions);
}

void FitSystem::prepare_preconditioner(const std::vector<std::uint8_t>& active) {
  const UnknownLayout& layout = synthesis_.layout();
  const std::size_t normal_count = layout.normal_begin.back() - layout.normal_begin.front();
  std::size_t active_count = 0;
  for (std::size_t i = layout.normal_begin.front(); i < layout.normal_begin.back(); ++i)
    active_count += active[i] != 0;
  // Coordinates of the finest vertices pay only while nearly all of them are free.
  dense_ = 10 * active_count >= 9 * normal_count && layout.coded_level_count > 0;
  inverse_diagonal_.assign(layout.count, 0.0);
  base_inverse_.resize(9 * layout.base_vertex_count);
  const int coded = layout.coded_level_count;
  const auto inverse_of = [](double h) { return h > 0 ? 1 / h : 0.0; };
  const GalerkinHierarchy& galerkin = this->galerkin();
  for (int l = 0; l < coded; ++l) {
    const auto level = static_cast<std::size_t>(l);
    const LevelTopology& topology = synthesis_.hierarchy().level(l);
    const int matrix_level = dense_ ? coded : l + 1;
    parallel_for(topology.edge_count, [&](std::size_t e) {
      inverse_diagonal_[layout.normal_begin[level] + e] = inverse_of(quadratic_form(
          galerkin.diagonal(matrix_level, topology.vertex_count + e), synthesis_.normal(l, e)));
    });
    const std::vector<std::uint32_t>& edges = layout.tangential_edges[level];
    for (std::size_t i = 0; i < edges.size(); ++i)
      for (std::size_t k = 0; k < 2; ++k)
        inverse_diagonal_[layout.tangential_begin[level] + 2 * i + k] =
            inverse_of(quadratic_form(galerkin.diagonal(l + 1, topology.vertex_count + edges[i]),
                                      synthesis_.tangential_frame(l, i)[k]));
  }
  for (std::size_t v = 0; v < layout.base_vertex_count; ++v) {
    SymmetricMatrix3 block = galerkin.diagonal(dense_ ? coded : 0, v);
    if (dense_) {
      // A base vertex slides along the surface with its whole neighbourhood: the coarse block's smallest
      // eigenvalue, bounded by its share of the trace, is the stiffness of that.
      const SymmetricMatrix3& coarse = galerkin.diagonal(0, v);
      const float slide = 0.02f * (coarse.xx + coarse.yy + coarse.zz);
      block.xx += slide;
      block.yy += slide;
      block.zz += slide;
    }
    invert(block, base_inverse_.data() + 9 * v);
  }
}

void FitSystem::precondition(const std::vector<std::uint8_t>& active, const std::vector<double>& residual,
                             std::vector<double>& result) {
  const UnknownLayout& layout = synthesis_.layout();
  const auto apply_diagonal = [&](const std::vector<double>& in, std::vector<double>& out) {
    out.resize(in.size());
    for (std::size_t v = 0; v < layout.base_vertex_count; ++v) {
      const double* m = base_inverse_.data() + 9 * v;
      const double* r = in.data() + 3 * v;
      for (std::size_t k = 0; k < 3; ++k)
        out[3 * v + k] = m[3 * k] * r[0] + m[3 * k + 1] * r[1] + m[3 * k + 2] * r[2];
    }
    parallel_for(in.size() - 3 * layout.base_vertex_count, [&](std::size_t i) {
      const std::size_t unknown = 3 * layout.base_vertex_count + i;
      out[unknown] = inverse_diagonal_[unknown] * in[unknown];
    });
  };
  if (dense_) {
    synthesis_.analyze_transposed(residual, scratch_);
    std::vector<double> scaled;
    apply_diagonal(scratch_, scaled);
    synthesis_.analyze(scaled, result);
    for (std::size_t i = layout.tangential_begin.front(); i < layout.count; ++i)
      result[i] = inverse_diagonal_[i] * residual[i];
  } else {
    apply_diagonal(residual, result);
  }
  parallel_for(result.size(), [&](std::size_t i) {
    if (!active[i]) result[i] = 0;
  });
}

MinimizeResult FitSystem::minimize(const std::vector<std::uint8_t>& active, const MinimizeOptions& options,
                                   std::vector<double>& values) {
  const std::size_t count = layout().count;
  MinimizeResult result;
  std::vector<Vec3> positions, force, displacement;
  std::vector<double> dual, residual(count), z, direction(count), product, change(count), candidate(count);
  for (int outer = 0; outer < options.maximum_outer; ++outer) {
    synthesis_.synthesize(values, positions);
    const double energy = energy_.gradient(positions, force);
    if (outer == 0) result.initial_energy = energy;
    result.final_energy = energy;
    synthesis_.adjoint(force, dual);
    prepare_preconditioner(active);
    parallel_for(count, [&](std::size_t i) {
      residual[i] = active[i] ? -dual[i] : 0.0;
      change[i] = 0;
    });
    precondition(active, residual, z);
    direction = z;
    double rz = inner_product(residual, z);
    const double target = options.inner_tolerance * options.inner_tolerance * rz;
    for (int inner = 0; inner < options.maximum_inner && rz > target && rz > 0; ++inner) {
      synthesis_.forward(direction, displacement);
      energy_.multiply(displacement, force);
      synthesis_.adjoint(force, product);
      parallel_for(count, [&](std::size_t i) {
        if (!active[i]) product[i] = 0;
      });
      const double curvature = inner_product(direction, product);
      if (!(curvature > 0)) break;
      const double step = rz / curvature;
      parallel_for(count, [&](std::size_t i) {
        change[i] += step * direction[i];
        residual[i] -= step * product[i];
      });
      precondition(active, residual, z);
      const double next = inner_product(residual, z);
      const double ratio = next / rz;
      rz = next;
      parallel_for(count, [&](std::size_t i) { direction[i] = z[i] + ratio * direction[i]; });
      ++result.inner;
    }
    ++result.outer;
    bool lowered = false;
    double step = 1;
    for (int halving = 0; halving <= options.maximum_halvings && !lowered; ++halving, step *= 0.5) {
      parallel_for(count, [&](std::size_t i) { candidate[i] = values[i] + step * change[i]; });
      const double lower = energy_of(candidate);
      if (lower < energy) {
        lowered = true;
        values = candidate;
        result.final_energy = lower;
      }
    }
    if (!lowered || energy - result.final_energy < options.outer_tolerance * energy) break;
  }
  synthesis_.synthesize(values, positions);
  return result;
}

}  // namespace nmc
