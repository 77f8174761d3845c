// SPDX-License-Identifier: Apache-2.0
#include "encoder/sphere/sphere_problem.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "encoder/core/parallel.h"
#include "encoder/sphere/exact_orientation.h"

namespace nmc {

VertexGraph vertex_graph(std::uint32_t vertex_count, const std::vector<Triangle>& triangles) {
  VertexGraph graph;
  graph.offsets.assign(vertex_count + 1, 0);
  // On a closed oriented surface every directed edge occurs once, so corner k -> k + 1 lists each neighbor
  // once.
  for (const Triangle& t : triangles)
    for (const std::uint32_t v : t) ++graph.offsets[v + 1];
  for (std::uint32_t v = 0; v < vertex_count; ++v) graph.offsets[v + 1] += graph.offsets[v];
  graph.neighbors.resize(graph.offsets.back());
  std::vector<std::uint32_t> fill(graph.offsets.begin(), graph.offsets.end() - 1);
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k) graph.neighbors[fill[t[k]]++] = t[(k + 1) % 3];
  for (std::uint32_t v = 0; v < vertex_count; ++v)
    std::sort(graph.neighbors.begin() + graph.offsets[v], graph.neighbors.begin() + graph.offsets[v + 1]);

  graph.edge_slots.resize(graph.neighbors.size());
  for (std::uint32_t v = 0; v < vertex_count; ++v) {
    for (std::uint32_t i = graph.offsets[v]; i < graph.offsets[v + 1]; ++i) {
      const std::uint32_t w = graph.neighbors[i];
      if (w > v) {
        graph.edge_slots[i] = graph.edge_count++;
      } else {
        const auto begin = graph.neighbors.begin() + graph.offsets[w];
        const auto end = graph.neighbors.begin() + graph.offsets[w + 1];
        graph.edge_slots[i] = graph.edge_slots[std::lower_bound(begin, end, v) - graph.neighbors.begin()];
      }
    }
  }
  return graph;
}

double BlockMatrix::mean_diagonal() const {
  double sum = 0;
  for (const auto& block : diagonal) sum += block[0] + block[2];
  return sum / (2.0 * static_cast<double>(diagonal.size()));
}

void BlockMatrix::multiply(const VertexGraph& graph, const std::vector<Tangent2>& vector,
                           std::vector<Tangent2>& result) const {
  result.resize(vector.size());
  parallel_for(vector.size(), [&](std::size_t v) {
    const auto& d = diagonal[v];
    Tangent2 sum{d[0] * vector[v][0] + d[1] * vector[v][1], d[1] * vector[v][0] + d[2] * vector[v][1]};
    for (std::uint32_t i = graph.offsets[v]; i < graph.offsets[v + 1]; ++i) {
      const std::uint32_t w = graph.neighbors[i];
      const auto& b = off_diagonal[graph.edge_slots[i]];
      if (v < w) {
        sum[0] += b[0] * vector[w][0] + b[1] * vector[w][1];
        sum[1] += b[2] * vector[w][0] + b[3] * vector[w][1];
      } else {
        sum[0] += b[0] * vector[w][0] + b[2] * vector[w][1];
        sum[1] += b[1] * vector[w][0] + b[3] * vector[w][1];
      }
    }
    result[v] = sum;
  });
}

SphereProblem::SphereProblem(const std::vector<Vec3>& reference, std::vector<Triangle> triangles,
                             const SphereEnergyWeights& weights)
    : weights_(weights), triangles_(std::move(triangles)) {
  const std::uint32_t vertex_count = static_cast<std::uint32_t>(reference.size());
  double total_area = 0;
  for (const Triangle& t : triangles_)
    total_area +=
        0.5 * nmc::norm(cross(reference[t[1]] - reference[t[0]], reference[t[2]] - reference[t[0]]));
  const double sphere_area = 4 * std::numbers::pi;
  const double scale = total_area > 0 ? sphere_area / total_area : 1;
  const double minimum_area = 1e-4 * sphere_area / static_cast<double>(triangles_.size());
  references_.resize(triangles_.size());
  parallel_for(triangles_.size(), [&](std::size_t f) {
    const Triangle& t = triangles_[f];
    references_[f] =
        reference_triangle(reference[t[0]], reference[t[1]], reference[t[2]], scale, minimum_area);
  });

  graph_ = vertex_graph(vertex_count, triangles_);
  corner_offsets_ = graph_.offsets;
  corners_.resize(3 * triangles_.size());
  std::vector<std::uint32_t> fill(corner_offsets_.begin(), corner_offsets_.end() - 1);
  triangle_edges_.resize(triangles_.size());
  edge_corners_.resize(graph_.edge_count);
  for (std::uint32_t f = 0; f < triangles_.size(); ++f) {
    const Triangle& t = triangles_[f];
    for (int k = 0; k < 3; ++k) {
      corners_[fill[t[k]]++] = 3 * f + k;
      const std::uint32_t from = t[(k + 1) % 3], to = t[(k + 2) % 3];
      const auto begin = graph_.neighbors.begin() + graph_.offsets[from];
      const auto end = graph_.neighbors.begin() + graph_.offsets[from + 1];
      const std::uint32_t slot =
          graph_.edge_slots[std::lower_bound(begin, end, to) - graph_.neighbors.begin()];
      triangle_edges_[f][k] = slot;
      edge_corners_[slot][from < to ? 0 : 1] = 3 * f + k;
    }
  }
}

double SphereProblem::energy(const std::vector<Vec3>& positions) const {
  return parallel_sum<double>(triangles_.size(), [&](std::size_t f) {
    const Triangle& t = triangles_[f];
    return triangle_energy(weights_, references_[f], positions[t[0]], positions[t[1]], positions[t[2]]);
  });
}

double SphereProblem::gradient(const std::vector<Vec3>& positions, std::vector<Vec3>& gradient) const {
  std::vector<TriangleEnergy> energies(triangles_.size());
  const double energy = parallel_sum<double>(triangles_.size(), [&](std::size_t f) {
    const Triangle& t = triangles_[f];
    energies[f] =
        triangle_energy_gradient(weights_, references_[f], positions[t[0]], positions[t[1]], positions[t[2]]);
    return energies[f].value;
  });
  gradient.resize(positions.size());
  parallel_for(positions.size(), [&](std::size_t v) {
    Vec3 sum;
    for (std::uint32_t i = corner_offsets_[v]; i < corner_offsets_[v + 1]; ++i) {
      const std::uint32_t f = corners_[i] / 3, k = corners_[i] % 3;
      const Triangle& t = triangles_[f];
      const std::uint32_t next = (k + 1) % 3, last = (k + 2) % 3;
      // The edge opposite to `next` joins this corner with `last`, and the other way round. Differences keep
      // the accuracy of short edges; they differ from -2 x by a radial part that the projection removes.
      sum += 2 * energies[f].gradient[next] * (positions[v] - positions[t[last]]);
      sum += 2 * energies[f].gradient[last] * (positions[v] - positions[t[next]]);
    }
    gradient[v] = project_to_tangent(positions[v], sum);
  });
  return energy;
}

// The 6 x 6 Hessian of one triangle in the frames of its corners, in the pieces that the global blocks
// gather.
struct SphereProblem::LocalHessian {
  std::array<std::array<double, 3>, 3> diagonal;  // xx, xy, yy per corner
  std::array<std::array<double, 4>, 3>
      off_diagonal;  // per edge k: rows of corner k + 1, columns of corner k + 2
  std::array<Tangent2, 3> gradient;
};

double SphereProblem::hessian(const std::vector<Vec3>& positions, const std::vector<TangentFrame>& frames,
                              HessianKind kind, std::vector<Tangent2>& gradient, BlockMatrix& hessian) const {
  const bool exact = kind == HessianKind::kExact;
  // Two ways to a positive semi-definite matrix of a triangle.
  const bool less_solid_angle = !exact && weights_.is_area_alone();
  const bool by_parts = !exact && !less_solid_angle;
  std::vector<LocalHessian> locals(triangles_.size());
  const double energy = parallel_sum<double>(triangles_.size(), [&](std::size_t f) {
    const Triangle& t = triangles_[f];
    const Vec3* x[3] = {&positions[t[0]], &positions[t[1]], &positions[t[2]]};
    const TangentFrame* frame[3] = {&frames[t[0]], &frames[t[1]], &frames[t[2]]};
    const TriangleEnergy e = triangle_energy_hessian(weights_, references_[f], *x[0], *x[1], *x[2]);

    Eigen::Matrix3d by_lengths;
    std::array<double, 3> slopes = e.gradient;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) by_lengths(i, j) = e.hessian[i][j];
    if (less_solid_angle) {
      // Where areas are kept the slope of the energy by the triangle's area is 2: without that multiple of the solid
      // angle, which adds up to nothing over the sphere, little of the matrix is negative.
      const TriangleEnergy angle = solid_angle_hessian(*x[0], *x[1], *x[2]);
      for (int i = 0; i < 3; ++i) {
        slopes[i] -= 2 * weights_.area * angle.gradient[i];
        for (int j = 0; j < 3; ++j) by_lengths(i, j) -= 2 * weights_.area * angle.hessian[i][j];
      }
    }
    if (by_parts) {
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
      eigen.computeDirect(by_lengths);
      by_lengths = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() *
                   eigen.eigenvectors().transpose();
    }

    Eigen::Matrix<double, 3, 6> jacobian = Eigen::Matrix<double, 3, 6>::Zero();
    for (int k = 0; k < 3; ++k) {
      const int p = (k + 1) % 3, q = (k + 2) % 3;
      const Vec3 edge = *x[p] - *x[q];
      jacobian(k, 2 * p) = 2 * dot(frame[p]->u, edge);
      jacobian(k, 2 * p + 1) = 2 * dot(frame[p]->v, edge);
      jacobian(k, 2 * q) = -2 * dot(frame[q]->u, edge);
      jacobian(k, 2 * q + 1) = -2 * dot(frame[q]->v, edge);
    }
    Eigen::Matrix<double, 6, 6> h = jacobian.transpose() * by_lengths * jacobian;
    for (int k = 0; k < 3; ++k) {
      const double slope = slopes[k];
      if (by_parts && slope <= 0) continue;
      const int p = (k + 1) % 3, q = (k + 2) % 3;
      // Replacing the cosine by 1 makes the block of the edge positive semi-definite, since |T_p^T T_q| <= 1.
      const double on_diagonal = 2 * slope * (by_parts ? 1 : dot(*x[p], *x[q]));
      for (const int r : {2 * p, 2 * p + 1, 2 * q, 2 * q + 1}) h(r, r) += on_diagonal;
      h(2 * p, 2 * q) -= 2 * slope * dot(frame[p]->u, frame[q]->u);
      h(2 * p, 2 * q + 1) -= 2 * slope * dot(frame[p]->u, frame[q]->v);
      h(2 * p + 1, 2 * q) -= 2 * slope * dot(frame[p]->v, frame[q]->u);
      h(2 * p + 1, 2 * q + 1) -= 2 * slope * dot(frame[p]->v, frame[q]->v);
    }
    if (less_solid_angle) {
      // The lower triangle is what Eigen reads, and what the loop above may have left out.
      for (int k = 0; k < 3; ++k) {
        const int p = (k + 1) % 3, q = (k + 2) % 3;
        h.block<2, 2>(2 * q, 2 * p) = h.block<2, 2>(2 * p, 2 * q).transpose().eval();
      }
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> eigen(h);
      h = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() * eigen.eigenvectors().transpose();
    }
    LocalHessian& local = locals[f];
    const Eigen::Matrix<double, 6, 1> g =
        jacobian.transpose() * Eigen::Vector3d(e.gradient[0], e.gradient[1], e.gradient[2]);
    for (int k = 0; k < 3; ++k) {
      const int p = (k + 1) % 3, q = (k + 2) % 3;
      local.gradient[k] = {g[2 * k], g[2 * k + 1]};
      local.diagonal[k] = {h(2 * k, 2 * k), h(2 * k, 2 * k + 1), h(2 * k + 1, 2 * k + 1)};
      // Only this triangle of the block (p, q) was written by the loop above; by symmetry the product part
      // agrees.
      local.off_diagonal[k] = {h(2 * p, 2 * q), h(2 * p, 2 * q + 1), h(2 * p + 1, 2 * q),
                               h(2 * p + 1, 2 * q + 1)};
    }
    return e.value;
  });

  gradient.resize(positions.size());
  hessian.diagonal.resize(positions.size());
  hessian.off_diagonal.resize(graph_.edge_count);
  parallel_for(positions.size(), [&](std::size_t v) {
    Tangent2 sum{};
    std::array<double, 3> block{};
    for (std::uint32_t i = corner_offsets_[v]; i < corner_offsets_[v + 1]; ++i) {
      const LocalHessian& local = locals[corners_[i] / 3];
      const std::uint32_t k = corners_[i] % 3;
      for (int c = 0; c < 2; ++c) sum[c] += local.gradient[k][c];
      for (int c = 0; c < 3; ++c) block[c] += local.diagonal[k][c];
    }
    gradient[v] = sum;
    hessian.diagonal[v] = block;
  });
  parallel_for(graph_.edge_count, [&](std::size_t edge) {
    // Side 0 runs from the lower to the higher index, so its rows are the lower vertex's; side 1 is
    // transposed.
    const std::uint32_t c0 = edge_corners_[edge][0], c1 = edge_corners_[edge][1];
    const auto& a = locals[c0 / 3].off_diagonal[c0 % 3];
    const auto& b = locals[c1 / 3].off_diagonal[c1 % 3];
    hessian.off_diagonal[edge] = {a[0] + b[0], a[1] + b[2], a[2] + b[1], a[3] + b[3]};
  });
  return energy;
}

bool is_safely_oriented(const Vec3& x0, const Vec3& x1, const Vec3& x2) {
  const Vec3 e1 = x1 - x0, e2 = x2 - x0;
  const double volume = dot(x0, cross(e1, e2));
  // The error of the differences is a rounding of their own size; 16 of them is a generous bound.
  const double margin = 16 * std::numeric_limits<double>::epsilon();
  return volume > 0 && volume * volume > margin * margin * squared_norm(e1) * squared_norm(e2);
}

std::size_t SphereProblem::flipped_count(const std::vector<Vec3>& positions) const {
  return parallel_sum<std::size_t>(triangles_.size(), [&](std::size_t f) -> std::size_t {
    const Triangle& t = triangles_[f];
    return is_safely_oriented(positions[t[0]], positions[t[1]], positions[t[2]]) ? 0 : 1;
  });
}

int SphereProblem::covering_degree(const std::vector<Vec3>& positions) const {
  const double solid_angle = parallel_sum<double>(triangles_.size(), [&](std::size_t f) {
    const Triangle& t = triangles_[f];
    return signed_solid_angle(positions[t[0]], positions[t[1]], positions[t[2]]);
  });
  return static_cast<int>(std::lround(solid_angle / (4 * std::numbers::pi)));
}

double norm(const std::vector<Vec3>& vectors) { return std::sqrt(dot(vectors, vectors)); }

double dot(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  return parallel_sum<double>(a.size(), [&](std::size_t i) { return dot(a[i], b[i]); });
}

double dot(const std::vector<Tangent2>& a, const std::vector<Tangent2>& b) {
  return parallel_sum<double>(a.size(), [&](std::size_t i) { return a[i][0] * b[i][0] + a[i][1] * b[i][1]; });
}

}  // namespace nmc
