// SPDX-License-Identifier: Apache-2.0
// The variational problem of a level: mass matrix and load vector, exactly integrated, and its solutions.
//
// Based on: I. Friedel, thesis, equations (3.2) to (3.4) and section 3.7.1.
#ifndef NMC_ENCODER_CURVES_CURVE_LEAST_SQUARES_H_
#define NMC_ENCODER_CURVES_CURVE_LEAST_SQUARES_H_

#include <Eigen/Sparse>
#include <array>
#include <vector>

#include "encoder/curves/normal_curve.h"

namespace nmc {

/// Integrals of hat functions, weighted by the arc length of R o p.
struct CurveIntegrals {
  std::vector<double> mass;        // of vertex i with itself
  std::vector<double> mass_right;  // of vertex i with i + 1
  std::vector<Vec3> load;          // of hat i with (R o p - S), S the level's positions
  double squared_error = 0;        // of R o p - S, over the length
};

/// Splits every segment at the reference's knots, where all integrands are polynomials of degree 3 at most:
/// Simpson's rule is exact.
CurveIntegrals integrate(const ReferenceCurve& reference, const NormalCurveLevel& level, bool is_closed);

/// Offsets of all vertices along their normals (columns: the `normal_count` normals) that minimize the
/// squared error.
std::vector<std::array<double, 2>> solve_along_normals(const CurveIntegrals& integrals,
                                                       const std::vector<CurveFrame>& frames,
                                                       int normal_count, bool is_closed);

/// The same with sombreros: returns one coefficient per odd vertex and normal; the vertex offsets follow from
/// apply_sombreros(). `level_vertex_count` even and odd vertices alternate.
std::vector<std::array<double, 2>> solve_sombreros(const CurveIntegrals& integrals,
                                                   const std::vector<CurveFrame>& frames, int normal_count,
                                                   bool is_closed);
std::vector<std::array<double, 2>> apply_sombreros(const std::vector<std::array<double, 2>>& coefficients,
                                                   std::size_t level_vertex_count, bool is_closed);

/// Free vectors instead of offsets along normals.
std::vector<Vec3> solve_vectorial(const CurveIntegrals& integrals, bool is_closed);

}  // namespace nmc

#endif  // NMC_ENCODER_CURVES_CURVE_LEAST_SQUARES_H_
