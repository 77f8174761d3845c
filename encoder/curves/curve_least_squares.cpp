// SPDX-License-Identifier: Apache-2.0
#include "encoder/curves/curve_least_squares.h"

#include <stdexcept>

#include "encoder/core/error.h"

namespace nmc {

namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Triplets = std::vector<Eigen::Triplet<double>>;

std::size_t segment_count(std::size_t vertex_count, bool is_closed) {
  return vertex_count - (is_closed ? 0 : 1);
}

// Normal equations along the normals: unknown k of vertex i is row normal_count * i + k.
void assemble(const CurveIntegrals& integrals, const std::vector<CurveFrame>& frames, int normal_count,
              bool is_closed, Sparse& matrix, Eigen::VectorXd& right) {
  const std::size_t count = frames.size();
  Triplets entries;
  right.resize(normal_count * static_cast<Eigen::Index>(count));
  const auto row = [&](std::size_t i, int k) { return static_cast<int>(i) * normal_count + k; };
  for (std::size_t i = 0; i < count; ++i) {
    for (int k = 0; k < normal_count; ++k) {
      right[row(i, k)] = dot(integrals.load[i], frames[i].normal[static_cast<std::size_t>(k)]);
      // The normals of one vertex are orthonormal.
      entries.emplace_back(row(i, k), row(i, k), integrals.mass[i]);
    }
  }
  for (std::size_t i = 0; i < segment_count(count, is_closed); ++i) {
    const std::size_t j = (i + 1) % count;
    for (int k = 0; k < normal_count; ++k) {
      for (int m = 0; m < normal_count; ++m) {
        const double value = integrals.mass_right[i] * dot(frames[i].normal[static_cast<std::size_t>(k)],
                                                           frames[j].normal[static_cast<std::size_t>(m)]);
        entries.emplace_back(row(i, k), row(j, m), value);
        entries.emplace_back(row(j, m), row(i, k), value);
      }
    }
  }
  matrix.resize(right.size(), right.size());
  matrix.setFromTriplets(entries.begin(), entries.end());
}

Eigen::VectorXd solve(const Sparse& matrix, const Eigen::VectorXd& right) {
  // A mass matrix is positive definite; the tiny shift covers segments without length.
  Sparse shifted = matrix;
  const double shift = 1e-14 * matrix.diagonal().maxCoeff();
  for (Eigen::Index i = 0; i < shifted.rows(); ++i) shifted.coeffRef(i, i) += shift;
  const Eigen::SimplicialLDLT<Sparse> solver(shifted);
  if (solver.info() != Eigen::Success)
    throw Error(ExitCode::kInternal, "the least squares problem of a curve level is singular");
  return solver.solve(right);
}

std::vector<std::array<double, 2>> to_pairs(const Eigen::VectorXd& values, int normal_count) {
  std::vector<std::array<double, 2>> pairs(static_cast<std::size_t>(values.size() / normal_count));
  for (std::size_t i = 0; i < pairs.size(); ++i)
    for (int k = 0; k < normal_count; ++k)
      pairs[i][static_cast<std::size_t>(k)] = values[static_cast<Eigen::Index>(i) * normal_count + k];
  return pairs;
}

// Rows: vertices; columns: odd vertices. Vertices at odd indices are the new ones.
Sparse sombrero_matrix(std::size_t vertex_count, int normal_count, bool is_closed) {
  Triplets entries;
  const std::size_t odd_count = vertex_count / 2;
  for (std::size_t i = 0; i < odd_count; ++i) {
    const std::size_t left = 2 * i, middle = 2 * i + 1;
    const std::size_t right = is_closed ? (2 * i + 2) % vertex_count : 2 * i + 2;
    for (int k = 0; k < normal_count; ++k) {
      const int column = static_cast<int>(i) * normal_count + k;
      const auto row = [&](std::size_t v) { return static_cast<int>(v) * normal_count + k; };
      entries.emplace_back(row(left), column, -0.25);
      entries.emplace_back(row(middle), column, 0.5);
      entries.emplace_back(row(right), column, -0.25);
    }
  }
  Sparse matrix(static_cast<Eigen::Index>(vertex_count) * normal_count,
                static_cast<Eigen::Index>(odd_count) * normal_count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

}  // namespace

CurveIntegrals integrate(const ReferenceCurve& reference, const NormalCurveLevel& level, bool is_closed) {
  const std::size_t count = level.positions.size();
  CurveIntegrals result;
  result.mass.assign(count, 0);
  result.mass_right.assign(count, 0);
  result.load.assign(count, Vec3{});
  std::vector<double> knots;
  for (std::size_t i = 0; i < segment_count(count, is_closed); ++i) {
    const std::size_t j = (i + 1) % count;
    const double from = level.parameters[i];
    const double to = j == 0 ? level.parameters[0] + 1 : level.parameters[j];
    reference.knots_between(from, to, knots);
    knots.push_back(to);
    double u = from;
    for (const double next : knots) {
      // p is linear in t on the segment, so the hats are linear in u as well, and arc length is uniform in u.
      const double width = (next - u) * reference.length();
      const double span = to - from;
      if (!(span > 0)) break;
      const double at[3] = {u, (u + next) / 2, next};
      const double weight[3] = {width / 6, 4 * width / 6, width / 6};
      for (int s = 0; s < 3; ++s) {
        const double right = (at[s] - from) / span, left = 1 - right;
        // The end of a closed curve's last piece is its first point.
        const Vec3 residual = reference(at[s]) - (left * level.positions[i] + right * level.positions[j]);
        result.mass[i] += weight[s] * left * left;
        result.mass[j] += weight[s] * right * right;
        result.mass_right[i] += weight[s] * left * right;
        result.load[i] += weight[s] * left * residual;
        result.load[j] += weight[s] * right * residual;
        result.squared_error += weight[s] * squared_norm(residual);
      }
      u = next;
    }
  }
  return result;
}

std::vector<std::array<double, 2>> solve_along_normals(const CurveIntegrals& integrals,
                                                       const std::vector<CurveFrame>& frames,
                                                       int normal_count, bool is_closed) {
  Sparse matrix;
  Eigen::VectorXd right;
  assemble(integrals, frames, normal_count, is_closed, matrix, right);
  return to_pairs(solve(matrix, right), normal_count);
}

std::vector<std::array<double, 2>> solve_sombreros(const CurveIntegrals& integrals,
                                                   const std::vector<CurveFrame>& frames, int normal_count,
                                                   bool is_closed) {
  Sparse matrix;
  Eigen::VectorXd right;
  assemble(integrals, frames, normal_count, is_closed, matrix, right);
  const Sparse basis = sombrero_matrix(frames.size(), normal_count, is_closed);
  const Sparse reduced = basis.transpose() * matrix * basis;
  return to_pairs(solve(reduced, basis.transpose() * right), normal_count);
}

std::vector<std::array<double, 2>> apply_sombreros(const std::vector<std::array<double, 2>>& coefficients,
                                                   std::size_t level_vertex_count, bool is_closed) {
  std::vector<std::array<double, 2>> offsets(level_vertex_count);
  for (std::size_t i = 0; i < coefficients.size(); ++i) {
    const std::size_t right = is_closed ? (2 * i + 2) % level_vertex_count : 2 * i + 2;
    for (std::size_t k = 0; k < 2; ++k) {
      offsets[2 * i][k] -= 0.25 * coefficients[i][k];
      offsets[2 * i + 1][k] += 0.5 * coefficients[i][k];
      offsets[right][k] -= 0.25 * coefficients[i][k];
    }
  }
  return offsets;
}

std::vector<Vec3> solve_vectorial(const CurveIntegrals& integrals, bool is_closed) {
  const std::size_t count = integrals.mass.size();
  Triplets entries;
  for (std::size_t i = 0; i < count; ++i)
    entries.emplace_back(static_cast<int>(i), static_cast<int>(i), integrals.mass[i]);
  for (std::size_t i = 0; i < segment_count(count, is_closed); ++i) {
    const int j = static_cast<int>((i + 1) % count);
    entries.emplace_back(static_cast<int>(i), j, integrals.mass_right[i]);
    entries.emplace_back(j, static_cast<int>(i), integrals.mass_right[i]);
  }
  Sparse matrix(static_cast<Eigen::Index>(count), static_cast<Eigen::Index>(count));
  matrix.setFromTriplets(entries.begin(), entries.end());
  std::vector<Vec3> offsets(count);
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::VectorXd right(static_cast<Eigen::Index>(count));
    for (std::size_t i = 0; i < count; ++i) right[static_cast<Eigen::Index>(i)] = integrals.load[i][axis];
    const Eigen::VectorXd solution = solve(matrix, right);
    for (std::size_t i = 0; i < count; ++i) offsets[i][axis] = solution[static_cast<Eigen::Index>(i)];
  }
  return offsets;
}

}  // namespace nmc
