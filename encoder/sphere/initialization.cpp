// SPDX-License-Identifier: Apache-2.0
#include "encoder/sphere/initialization.h"

#include <Eigen/Sparse>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "encoder/core/error.h"
#include "encoder/sphere/spherical_energy.h"

namespace nmc {

std::vector<Vec3> centered_normalization(const TriangleMesh& mesh) {
  Vec3 centroid;
  double total = 0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    const double area = norm(cross(b - a, c - a));
    centroid += (area / 3) * (a + b + c);
    total += area;
  }
  if (total > 0) centroid *= 1 / total;
  std::vector<Vec3> positions(mesh.vertex_count());
  for (std::size_t v = 0; v < positions.size(); ++v) positions[v] = normalized(mesh.positions[v] - centroid);
  return positions;
}

std::vector<Vec3> stereographic_start(const TriangleMesh& mesh) {
  // The puncture: the largest triangle, so that the outermost image is well shaped.
  std::size_t puncture = 0;
  double largest = -1;
  for (std::size_t f = 0; f < mesh.triangle_count(); ++f) {
    const Triangle& t = mesh.triangles[f];
    const Vec3& a = mesh.positions[t[0]];
    const double area = squared_norm(cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a));
    if (area > largest) {
      largest = area;
      puncture = f;
    }
  }
  const std::size_t count = mesh.vertex_count();
  std::vector<int> unknown(count, 0);
  for (const std::uint32_t v : mesh.triangles[puncture]) unknown[v] = -1;
  int unknown_count = 0;
  for (int& u : unknown)
    if (u == 0) u = unknown_count++;
  // Seen from the other side of the plane the hole runs clockwise, and the rest counter-clockwise inside it.
  Eigen::MatrixX2d plane = Eigen::MatrixX2d::Zero(static_cast<Eigen::Index>(count), 2);
  for (int k = 0; k < 3; ++k) {
    const double angle = -2 * std::numbers::pi * k / 3;
    plane.row(mesh.triangles[puncture][k]) << std::cos(angle), std::sin(angle);
  }
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::MatrixX2d right = Eigen::MatrixX2d::Zero(unknown_count, 2);
  for (std::size_t f = 0; f < mesh.triangle_count(); ++f) {
    if (f == puncture) continue;
    const Triangle& t = mesh.triangles[f];
    const ReferenceTriangle reference =
        reference_triangle(mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]], 1, 0);
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t p = t[(k + 1) % 3], q = t[(k + 2) % 3];
      const double weight = reference.quarter_cotangent[k];
      for (const auto& [from, to] : {std::pair{p, q}, std::pair{q, p}}) {
        if (unknown[from] < 0) continue;
        entries.emplace_back(unknown[from], unknown[from], weight);
        if (unknown[to] >= 0) {
          entries.emplace_back(unknown[from], unknown[to], -weight);
        } else {
          right.row(unknown[from]) += weight * plane.row(to);
        }
      }
    }
  }
  Eigen::SparseMatrix<double> matrix(unknown_count, unknown_count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(matrix);
  if (solver.info() != Eigen::Success)
    throw Error(ExitCode::kInternal, "the harmonic map could not be solved");
  const Eigen::MatrixX2d solution = solver.solve(right);
  for (std::size_t v = 0; v < count; ++v)
    if (unknown[v] >= 0) plane.row(static_cast<Eigen::Index>(v)) = solution.row(unknown[v]);

  // The median vertex goes to the equator.
  std::vector<double> x(count), y(count), radii(count);
  for (std::size_t v = 0; v < count; ++v) {
    x[v] = plane(static_cast<Eigen::Index>(v), 0);
    y[v] = plane(static_cast<Eigen::Index>(v), 1);
  }
  const auto median = [](std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
    return values[values.size() / 2];
  };
  const double center_x = median(x), center_y = median(y);
  for (std::size_t v = 0; v < count; ++v) radii[v] = std::hypot(x[v] - center_x, y[v] - center_y);
  const double scale = 1 / std::max(median(radii), 1e-300);
  std::vector<Vec3> positions(count);
  for (std::size_t v = 0; v < count; ++v) {
    const double px = scale * (x[v] - center_x), py = scale * (y[v] - center_y);
    const double square = px * px + py * py;
    // From the north pole; counter-clockwise in the plane seen from above is clockwise seen from outside
    // below, so one axis is mirrored.
    positions[v] = normalized({2 * px, -2 * py, square - 1});
  }
  return positions;
}

}  // namespace nmc
