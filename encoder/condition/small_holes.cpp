// SPDX-License-Identifier: Apache-2.0
#include "encoder/condition/small_holes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "encoder/condition/pieces.h"

namespace nmc::conditioning {

namespace {

constexpr double kSliverArea = 1e-12;  // relative to the longest edge squared, as in slivers.cpp

/// Liepa's weight: the largest bend along any edge first, then the area.
struct Weight {
  double bend_rad = 0, area = 0;
  bool operator<(const Weight& other) const {
    return bend_rad != other.bend_rad ? bend_rad < other.bend_rad : area < other.area;
  }
  bool is_possible() const { return std::isfinite(area); }
};
constexpr Weight kImpossible = {std::numeric_limits<double>::infinity(),
                                std::numeric_limits<double>::infinity()};

/// The best triangulation of one polygon. The polygon runs against the boundary, so its triangles agree with
/// the surface around them.
class PolygonTriangulation {
 public:
  /// `half_edges` are the boundary half-edges in their own order.
  PolygonTriangulation(const WorkingMesh& mesh, const std::vector<std::uint32_t>& opposite,
                       const std::vector<std::uint32_t>& half_edges)
      : mesh_(mesh), count_(half_edges.size()) {
    for (std::size_t i = 0; i < count_; ++i) {
      const std::uint32_t h = half_edges[count_ - 1 - i];
      polygon_.push_back(head_of(mesh.triangles, h));
      side_normal_.push_back(normalized(mesh.area_normal(h / 3), {0, 0, 0}));  // of polygon edge i, i + 1
      neighbours_.emplace_back();
      // The boundary half-edge that starts at polygon_[i] follows h in boundary order.
      for_each_in_umbrella(opposite, half_edges[(count_ - i) % count_], [&](std::uint32_t around) {
        neighbours_.back().push_back(head_of(mesh.triangles, around));
        neighbours_.back().push_back(apex_of(mesh.triangles, around));
      });
      std::sort(neighbours_.back().begin(), neighbours_.back().end());
    }
  }

  /// The triangles, or nothing when no triangulation is possible.
  std::vector<Triangle> solve(double& area) {
    weight_.assign(count_ * count_, Weight{});
    middle_.assign(count_ * count_, 0);
    for (std::size_t span = 2; span < count_; ++span)
      for (std::size_t i = 0; i + span < count_; ++i) {
        const std::size_t k = i + span;
        Weight best = kImpossible;
        const bool is_whole = span == count_ - 1;
        if (is_whole || !is_edge(i, k))
          for (std::size_t m = i + 1; m < k; ++m) {
            const Weight weight = combined(i, m, k, is_whole);
            if (weight < best) {
              best = weight;
              middle_[i * count_ + k] = m;
            }
          }
        weight_[i * count_ + k] = best;
      }
    std::vector<Triangle> triangles;
    area = weight_[count_ - 1].area;
    if (weight_[count_ - 1].is_possible()) collect(0, count_ - 1, triangles);
    return triangles;
  }

 private:
  const Vec3& point(std::size_t i) const { return mesh_.positions[polygon_[i]]; }
  Vec3 normal(std::size_t i, std::size_t m, std::size_t k) const {
    return cross(point(m) - point(i), point(k) - point(i));
  }
  bool is_edge(std::size_t i, std::size_t k) const {
    return std::binary_search(neighbours_[i].begin(), neighbours_[i].end(), polygon_[k]);
  }
  /// Unit normal on the other side of polygon diagonal (or side) i, k.
  Vec3 normal_beyond(std::size_t i, std::size_t k) const {
    if (k == i + 1) return side_normal_[i];
    return normalized(normal(i, middle_[i * count_ + k], k), {0, 0, 0});
  }

  Weight combined(std::size_t i, std::size_t m, std::size_t k, bool is_whole) const {
    const Weight &left = weight_[i * count_ + m], &right = weight_[m * count_ + k];
    if (!left.is_possible() || !right.is_possible()) return kImpossible;
    const Vec3 n = normal(i, m, k);
    const double double_area = norm(n);
    const double longest = std::max({squared_norm(point(m) - point(i)), squared_norm(point(k) - point(m)),
                                     squared_norm(point(i) - point(k))});
    if (0.5 * double_area <= kSliverArea * longest) return kImpossible;
    const auto bend = [&](const Vec3& other) {
      return std::acos(std::clamp(dot(n, other) / double_area, -1.0, 1.0));
    };
    double worst =
        std::max({left.bend_rad, right.bend_rad, bend(normal_beyond(i, m)), bend(normal_beyond(m, k))});
    if (is_whole) worst = std::max(worst, bend(side_normal_[count_ - 1]));
    return {worst, left.area + right.area + 0.5 * double_area};
  }

  void collect(std::size_t i, std::size_t k, std::vector<Triangle>& triangles) const {
    if (k - i < 2) return;
    const std::size_t m = middle_[i * count_ + k];
    triangles.push_back({polygon_[i], polygon_[m], polygon_[k]});
    collect(i, m, triangles);
    collect(m, k, triangles);
  }

  const WorkingMesh& mesh_;
  std::size_t count_;
  std::vector<std::uint32_t> polygon_;
  std::vector<Vec3> side_normal_;
  std::vector<std::vector<std::uint32_t>> neighbours_;  // on the surface, sorted
  std::vector<Weight> weight_;  // of the part between polygon corners i < k, at i * count + k
  std::vector<std::size_t> middle_;
};

/// The boundary half-edges of the loop of `start` in order; stops early once it has more than `limit`.
std::vector<std::uint32_t> boundary_loop(const std::vector<std::uint32_t>& opposite, std::uint32_t start,
                                         std::size_t limit) {
  std::vector<std::uint32_t> loop;
  std::uint32_t h = start;
  do {
    loop.push_back(h);
    h = next_half_edge(h);
    while (opposite[h] != kNone) h = next_half_edge(opposite[h]);
  } while (h != start && loop.size() <= limit);
  return loop;
}

/// Pairs the half-edges of the fill with each other and with the loop.
void connect(WorkingMesh& mesh, std::vector<std::uint32_t>& opposite, const std::vector<Triangle>& fill,
             const std::vector<std::uint32_t>& loop) {
  std::vector<std::uint32_t> open = loop;
  for (const Triangle& t : fill) {
    for (int k = 0; k < 3; ++k) open.push_back(static_cast<std::uint32_t>(3 * mesh.triangles.size()) + k);
    mesh.triangles.push_back(t);
    mesh.stored.push_back(t);
    mesh.source.push_back(kFilledHole);
    mesh.is_turned.push_back(0);
  }
  opposite.resize(3 * mesh.triangles.size(), kNone);
  for (std::size_t i = 0; i < open.size(); ++i)
    for (std::size_t j = std::max(i + 1, loop.size()); j < open.size(); ++j) {
      const std::uint32_t a = open[i], b = open[j];
      if (tail_of(mesh.triangles, a) != head_of(mesh.triangles, b) ||
          head_of(mesh.triangles, a) != tail_of(mesh.triangles, b))
        continue;
      opposite[a] = b;
      opposite[b] = a;
    }
}

}  // namespace

void fill_small_holes(WorkingMesh& mesh, std::vector<std::uint32_t>& opposite,
                      const std::vector<std::uint8_t>& is_seam, const ConditionOptions& options) {
  if (options.small_hole_edges < 3) return;
  if (std::find(opposite.begin(), opposite.end(), kNone) == opposite.end()) return;
  Pieces pieces = find_pieces(mesh, opposite);
  const double longest = options.small_hole_length_fraction * mesh.report.diagonal;
  // A fill enlarges its component, which can bring another loop under the area limit: until nothing changes,
  // so that filling the result again fills nothing.
  for (bool filled = true; filled;) {
    filled = false;
    const std::size_t half_edge_count = opposite.size();
    std::vector<std::uint8_t> visited(half_edge_count, 0);
    for (std::uint32_t start = 0; start < half_edge_count; ++start) {
      if (opposite[start] != kNone || visited[start]) continue;
      const std::vector<std::uint32_t> loop = boundary_loop(opposite, start, options.small_hole_edges);
      for (const std::uint32_t h : loop) visited[h] = 1;
      if (loop.size() > options.small_hole_edges) continue;
      double length = 0;
      bool one_triangle = true, on_seam = false;
      for (const std::uint32_t h : loop) {
        length +=
            distance(mesh.positions[tail_of(mesh.triangles, h)], mesh.positions[head_of(mesh.triangles, h)]);
        one_triangle = one_triangle && h / 3 == start / 3;
        on_seam = on_seam || is_seam[tail_of(mesh.triangles, h)];
      }
      if (length > longest || one_triangle || on_seam) continue;
      Piece& piece = pieces.list[pieces.of_triangle[start / 3]];
      // By the isoperimetric inequality a fill that is close to flat cannot be larger than length^2 / (4 pi);
      // loops that could pass are triangulated, the others not.
      double area = 0;
      const std::vector<Triangle> fill = PolygonTriangulation(mesh, opposite, loop).solve(area);
      if (fill.empty() || area > options.small_hole_area_fraction * piece.area) continue;
      ++mesh.report.filled_holes;
      mesh.note(Defect::kSmallHole, [&] {
        return fmt::format("filled a hole of {} edges at vertex {}", loop.size(),
                           tail_of(mesh.stored, start));
      });
      mesh.report.filled_hole_triangles += fill.size();
      mesh.report.filled_hole_area += area;
      connect(mesh, opposite, fill, loop);
      piece.area += area;
      pieces.of_triangle.resize(mesh.triangles.size(), pieces.of_triangle[start / 3]);
      filled = true;
    }
  }
}

}  // namespace nmc::conditioning
