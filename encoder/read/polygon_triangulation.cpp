// SPDX-License-Identifier: Apache-2.0
#include "encoder/read/polygon_triangulation.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace nmc {

namespace {

struct Point2 {
  double x, y;
  bool operator==(const Point2&) const = default;
};

/// Twice the signed area of the triangle a b c.
double turn(const Point2& a, const Point2& b, const Point2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// Newell's normal; coordinates are taken relative to the first corner so that a small polygon far from the
/// origin keeps its digits.
Vec3 newell_normal(std::span<const Vec3> corners) {
  Vec3 normal;
  const Vec3& origin = corners[0];
  for (std::size_t i = 1; i + 1 < corners.size(); ++i)
    normal += cross(corners[i] - origin, corners[i + 1] - origin);
  return normal;
}

/// Projects along the dominant axis; the polygon then runs counter-clockwise wherever it is simple.
std::vector<Point2> project(std::span<const Vec3> corners, const Vec3& normal) {
  int axis = 2;
  if (std::abs(normal.x) > std::abs(normal.y) && std::abs(normal.x) > std::abs(normal.z)) {
    axis = 0;
  } else if (std::abs(normal.y) > std::abs(normal.z)) {
    axis = 1;
  }
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  const double sign = normal[axis] < 0 ? -1.0 : 1.0;
  std::vector<Point2> points;
  points.reserve(corners.size());
  for (const Vec3& p : corners) {
    const Vec3 relative = p - corners[0];
    points.push_back({sign * relative[u], relative[v]});
  }
  return points;
}

/// True where every triangle of the fan about corner `apex` has its front on the side of `normal`.
bool is_fan(std::span<const Vec3> corners, std::size_t apex, const Vec3& normal) {
  const std::size_t count = corners.size();
  const Vec3& origin = corners[apex];
  for (std::size_t i = 1; i + 1 < count; ++i) {
    const Vec3 triangle =
        cross(corners[(apex + i) % count] - origin, corners[(apex + i + 1) % count] - origin);
    if (!(dot(triangle, normal) > 0)) return false;
  }
  return true;
}

void append_fan(std::uint32_t count, std::uint32_t apex,
                std::vector<std::array<std::uint32_t, 3>>& triangles) {
  for (std::uint32_t i = 1; i + 1 < count; ++i)
    triangles.push_back({apex, (apex + i) % count, (apex + i + 1) % count});
}

/// A polygon of some 30,000 corners, half of them reflex, needs as many. Hostile files have larger ones.
constexpr std::size_t kMaximumTests = 500'000'000;

/// The corners not clipped yet, as a ring.
class EarClipper {
 public:
  explicit EarClipper(std::vector<Point2> points) : points_(std::move(points)), remaining_(points_.size()) {
    const auto count = static_cast<std::uint32_t>(points_.size());
    previous_.resize(count);
    next_.resize(count);
    may_block_.resize(count);
    for (std::uint32_t i = 0; i < count; ++i) {
      previous_[i] = i == 0 ? count - 1 : i - 1;
      next_[i] = i + 1 == count ? 0 : i + 1;
    }
    for (std::uint32_t i = 0; i < count; ++i) {
      may_block_[i] = !(corner_turn(i) > 0);
      if (may_block_[i]) blockers_.push_back(i);
    }
  }

  void run(std::vector<std::array<std::uint32_t, 3>>& triangles) {
    std::uint32_t corner = 0;
    std::size_t since_last_ear = 0;
    while (remaining_ > 3) {
      if (tests_left_ == 0) {
        corner = clip(corner, triangles);
      } else if (is_ear(corner)) {
        corner = clip(corner, triangles);
        since_last_ear = 0;
      } else if (++since_last_ear < remaining_) {
        corner = next_[corner];
      } else {
        // Only a polygon that is not simple gets here; the flattest corner does the least harm.
        tests_left_ -= std::min(tests_left_, remaining_);
        corner = clip(flattest_corner(corner), triangles);
        since_last_ear = 0;
      }
    }
    triangles.push_back({previous_[corner], corner, next_[corner]});
  }

 private:
  double corner_turn(std::uint32_t i) const {
    return turn(points_[previous_[i]], points_[i], points_[next_[i]]);
  }

  /// Only reflex and straight corners can lie in a candidate ear of a simple polygon, so only they are
  /// tested. A corner that touches the ear's corners in space (a bridge to a hole) does not block it.
  bool is_ear(std::uint32_t corner) {
    const Point2& a = points_[previous_[corner]];
    const Point2& b = points_[corner];
    const Point2& c = points_[next_[corner]];
    if (!(turn(a, b, c) > 0)) return false;
    std::size_t kept = 0;
    bool blocked = false;
    tests_left_ -= std::min<std::size_t>(tests_left_, 1 + blockers_.size());
    for (std::size_t k = 0; k < blockers_.size(); ++k) {
      const std::uint32_t other = blockers_[k];
      if (!may_block_[other]) continue;
      blockers_[kept++] = other;
      if (blocked) continue;
      const Point2& p = points_[other];
      if (p == a || p == b || p == c) continue;
      blocked = turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
    }
    blockers_.resize(kept);
    return !blocked;
  }

  std::uint32_t clip(std::uint32_t corner, std::vector<std::array<std::uint32_t, 3>>& triangles) {
    const std::uint32_t before = previous_[corner], after = next_[corner];
    triangles.push_back({before, corner, after});
    next_[before] = after;
    previous_[after] = before;
    may_block_[corner] = false;
    --remaining_;
    // Clipping an ear only narrows the angles beside it: a convex corner stays convex.
    if (may_block_[before]) may_block_[before] = !(corner_turn(before) > 0);
    if (may_block_[after]) may_block_[after] = !(corner_turn(after) > 0);
    // Going on two corners further makes strips instead of one long fan of slivers.
    return next_[after];
  }

  std::uint32_t flattest_corner(std::uint32_t start) const {
    std::uint32_t best = start;
    double best_turn = std::abs(corner_turn(start));
    for (std::uint32_t i = next_[start]; i != start; i = next_[i]) {
      const double candidate = std::abs(corner_turn(i));
      if (candidate < best_turn) {
        best = i;
        best_turn = candidate;
      }
    }
    return best;
  }

  std::vector<Point2> points_;
  std::size_t remaining_;
  std::size_t tests_left_ = kMaximumTests;
  std::vector<std::uint32_t> previous_, next_;
  std::vector<bool> may_block_;
  std::vector<std::uint32_t> blockers_;
};

}  // namespace

void triangulate_polygon(std::span<const Vec3> corners,
                         std::vector<std::array<std::uint32_t, 3>>& triangles) {
  const auto count = static_cast<std::uint32_t>(corners.size());
  if (count == 3) {
    triangles.push_back({0, 1, 2});
    return;
  }
  const Vec3 normal = newell_normal(corners);
  const bool has_no_plane = !(squared_norm(normal) > 0) || !is_finite(normal);
  if (has_no_plane || is_fan(corners, 0, normal)) {
    append_fan(count, 0, triangles);
  } else if (count == 4) {
    append_fan(count, is_fan(corners, 1, normal) ? 1 : 0, triangles);
  } else {
    EarClipper(project(corners, normal)).run(triangles);
  }
}

}  // namespace nmc
