// SPDX-License-Identifier: Apache-2.0
#include "encoder/condition/slivers.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "encoder/core/parallel.h"

namespace nmc::conditioning {

namespace {

constexpr double kSliverArea = 1e-12;  // relative to the longest edge squared
constexpr double kNeedleEdge = 1e-4;   // a shortest edge below this part of the longest makes a needle
constexpr int kMaximumRounds = 8;

bool is_sliver(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double longest = std::max({squared_norm(b - a), squared_norm(c - b), squared_norm(a - c)});
  return 0.5 * norm(cross(b - a, c - a)) <= kSliverArea * longest;
}

class SliverRemoval {
 public:
  SliverRemoval(WorkingMesh& mesh, std::vector<std::uint32_t>& opposite,
                const std::vector<std::uint8_t>& is_seam)
      : mesh_(mesh), opposite_(opposite), is_seam_(is_seam), removed_(mesh.triangles.size(), 0) {}

  std::size_t run() {
    std::vector<std::uint32_t> slivers = find();
    mesh_.report.slivers_left = 0;
    if (slivers.empty()) return 0;
    mesh_.note(Defect::kSliver,
               [&] { return fmt::format("triangle {} has no area", mesh_.source[slivers[0]]); });
    std::size_t all_treated = 0;
    for (int round = 0; round < kMaximumRounds && !slivers.empty(); ++round) {
      std::size_t treated = 0;
      for (const std::uint32_t t : slivers)
        if (!removed_[t] && is_sliver(t)) treated += treat(t);
      all_treated += treated;
      if (treated == 0) break;
      slivers = find();
    }
    mesh_.report.slivers_left = slivers.size();
    compact();
    return all_treated;
  }

 private:
  const Vec3& position(std::uint32_t v) const { return mesh_.positions[v]; }
  bool is_sliver(std::uint32_t t) const {
    const Triangle& c = mesh_.triangles[t];
    return conditioning::is_sliver(position(c[0]), position(c[1]), position(c[2]));
  }

  std::vector<std::uint32_t> find() const {
    std::vector<std::uint8_t> flag(mesh_.triangles.size());
    parallel_for(flag.size(),
                 [&](std::size_t t) { flag[t] = !removed_[t] && is_sliver(static_cast<std::uint32_t>(t)); });
    std::vector<std::uint32_t> list;
    for (std::uint32_t t = 0; t < flag.size(); ++t)
      if (flag[t]) list.push_back(t);
    return list;
  }

  bool treat(std::uint32_t t) {
    std::array<std::uint32_t, 3> by_length = {3 * t, 3 * t + 1, 3 * t + 2};
    const auto length = [&](std::uint32_t h) {
      return distance(position(tail_of(mesh_.triangles, h)), position(head_of(mesh_.triangles, h)));
    };
    std::stable_sort(by_length.begin(), by_length.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return length(a) < length(b); });
    const bool is_needle = length(by_length[0]) <= kNeedleEdge * length(by_length[2]);
    if (is_needle && collapse(by_length[0])) return true;
    return flip(by_length[2]);
  }

  /// Whether turning triangle (a, b, c) into (a, b, moved) keeps its side; slivers have no side to keep.
  bool keeps_side(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& moved) const {
    if (conditioning::is_sliver(a, b, c)) return true;
    return !conditioning::is_sliver(a, b, moved) && dot(cross(b - a, c - a), cross(b - a, moved - a)) > 0;
  }

  void link(std::uint32_t a, std::uint32_t b) {
    if (a != kNone) opposite_[a] = b;
    if (b != kNone) opposite_[b] = a;
  }

  std::vector<std::uint32_t> umbrella(std::uint32_t corner) const {
    std::vector<std::uint32_t> corners;
    for_each_in_umbrella(opposite_, corner, [&](std::uint32_t h) { corners.push_back(h); });
    return corners;
  }

  std::vector<std::uint32_t> neighbours(const std::vector<std::uint32_t>& corners) const {
    std::vector<std::uint32_t> around;
    for (const std::uint32_t h : corners) {
      around.push_back(head_of(mesh_.triangles, h));
      around.push_back(apex_of(mesh_.triangles, h));
    }
    std::sort(around.begin(), around.end());
    around.erase(std::unique(around.begin(), around.end()), around.end());
    return around;
  }

  bool is_boundary(const std::vector<std::uint32_t>& corners) const {
    return std::any_of(corners.begin(), corners.end(), [&](std::uint32_t h) {
      return opposite_[h] == kNone || opposite_[previous_half_edge(h)] == kNone;
    });
  }

  /// Moves the tail of the half-edge onto its head, or the head onto the tail.
  bool collapse(std::uint32_t h) {
    const std::uint32_t start = h, end = next_half_edge(h);
    const std::vector<std::uint32_t> at_tail = umbrella(start), at_head = umbrella(end);
    const bool tail_on_boundary = is_boundary(at_tail), head_on_boundary = is_boundary(at_head);
    // A boundary vertex must not be pulled into the inside.
    if (!tail_on_boundary || head_on_boundary)
      if (collapse_onto(h, at_tail, at_head, tail_on_boundary && head_on_boundary)) return true;
    if (!head_on_boundary || tail_on_boundary) {
      // The same edge the other way round; on a boundary there is only one half-edge, whose roles are
      // exchanged.
      return collapse_onto(h, at_head, at_tail, tail_on_boundary && head_on_boundary);
    }
    return false;
  }

  /// `moving` and `staying` are the umbrellas of the two ends of h's edge.
  bool collapse_onto(std::uint32_t h, const std::vector<std::uint32_t>& moving,
                     const std::vector<std::uint32_t>& staying, bool both_on_boundary) {
    const std::uint32_t other = opposite_[h];
    const std::uint32_t from = tail_of(mesh_.triangles, moving[0]), to = tail_of(mesh_.triangles, staying[0]);
    if (both_on_boundary && other != kNone) return false;  // would pinch the surface
    if (is_seam_[from] || is_seam_[to]) return false;
    // Link condition: the ends have no common neighbours but the apexes of the edge's triangles.
    const std::vector<std::uint32_t> a = neighbours(moving), b = neighbours(staying);
    std::vector<std::uint32_t> common;
    std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(common));
    if (common.size() != (other == kNone ? 1u : 2u)) return false;
    for (const std::uint32_t side : {h, other}) {
      if (side == kNone) continue;
      const std::uint32_t left = opposite_[next_half_edge(side)], right = opposite_[previous_half_edge(side)];
      if (left == kNone && right == kNone)
        return false;  // the triangle is an ear; its apex would be orphaned
      if (left != kNone && right != kNone &&
          apex_of(mesh_.triangles, left) == apex_of(mesh_.triangles, right))
        return false;  // an apex of valence three: the neighbours would fall on each other
    }
    for (const std::uint32_t corner : moving) {
      const std::uint32_t t = corner / 3;
      if (t == h / 3 || (other != kNone && t == other / 3)) continue;
      if (!keeps_side(position(head_of(mesh_.triangles, corner)), position(apex_of(mesh_.triangles, corner)),
                      position(from), position(to)))
        return false;
    }
    for (const std::uint32_t corner : moving) {
      mesh_.triangles[corner / 3][corner % 3] = to;
      mesh_.stored[corner / 3][corner % 3] = to;
      change(corner / 3);
    }
    for (const std::uint32_t side : {h, other}) {
      if (side == kNone) continue;
      link(opposite_[next_half_edge(side)], opposite_[previous_half_edge(side)]);
      removed_[side / 3] = 1;
    }
    ++mesh_.report.needles_collapsed;
    return true;
  }

  void change(std::uint32_t t) {
    if (mesh_.source[t] != kFilledHole) mesh_.fate[mesh_.source[t]] = TriangleFate::kReshaped;
  }

  bool flip(std::uint32_t h) {
    const std::uint32_t other = opposite_[h];
    if (other == kNone) return take_away(h);
    //      c                c
    //    /   \            / | .      h = (a, b) becomes (c, d); triangle t is then (c, a, d), the other (d,
    //    b, c)
    //   a --- b    ->    a  |  b
    //    \   /            . | /
    //      d                d
    const std::uint32_t a = tail_of(mesh_.triangles, h), b = head_of(mesh_.triangles, h);
    const std::uint32_t c = apex_of(mesh_.triangles, h), d = apex_of(mesh_.triangles, other);
    if (c == d) return false;
    // Where sheets touch, another one may already have one of the new triangles.
    if (is_seam_[a] || is_seam_[b] || is_seam_[c] || is_seam_[d]) return false;
    const std::vector<std::uint32_t> around = neighbours(umbrella(previous_half_edge(h)));
    if (std::binary_search(around.begin(), around.end(), d)) return false;  // the edge (c, d) exists already
    if (conditioning::is_sliver(position(c), position(a), position(d)) ||
        conditioning::is_sliver(position(d), position(b), position(c)))
      return false;
    // The cap has no side; the new triangles share the plane of its neighbour and must have that one's side.
    const Vec3 side = cross(position(a) - position(b), position(d) - position(b));
    if (!(dot(side, cross(position(a) - position(c), position(d) - position(c))) > 0) ||
        !(dot(side, cross(position(b) - position(d), position(c) - position(d))) > 0))
      return false;
    const std::uint32_t bc = opposite_[next_half_edge(h)], ca = opposite_[previous_half_edge(h)];
    const std::uint32_t ad = opposite_[next_half_edge(other)], db = opposite_[previous_half_edge(other)];
    const std::uint32_t t = h / 3, s = other / 3;
    const auto stored_at = [&](std::uint32_t corner) { return mesh_.stored[corner / 3][corner % 3]; };
    const Triangle stored_t = {stored_at(previous_half_edge(h)), stored_at(h),
                               stored_at(previous_half_edge(other))};
    const Triangle stored_s = {stored_t[2], stored_at(next_half_edge(h)), stored_t[0]};
    mesh_.triangles[t] = {c, a, d};
    mesh_.triangles[s] = {d, b, c};
    mesh_.stored[t] = stored_t;
    mesh_.stored[s] = stored_s;
    const auto connect = [&](std::uint32_t mine, std::uint32_t partner) {
      opposite_[mine] = partner;
      if (partner != kNone) opposite_[partner] = mine;
    };
    connect(3 * t, ca);
    connect(3 * t + 1, ad);
    connect(3 * t + 2, 3 * s + 2);
    connect(3 * s, db);
    connect(3 * s + 1, bc);
    change(t);
    change(s);
    ++mesh_.report.caps_flipped;
    return true;
  }

  /// A cap with its longest edge on the boundary: without it the boundary runs through the obtuse corner
  /// instead.
  bool take_away(std::uint32_t h) {
    const std::uint32_t left = opposite_[next_half_edge(h)], right = opposite_[previous_half_edge(h)];
    if (left == kNone || right == kNone) return false;  // would orphan a vertex or take a whole component
    if (is_boundary(umbrella(previous_half_edge(h))))
      return false;  // would pinch the surface at the obtuse corner
    opposite_[left] = opposite_[right] = kNone;
    removed_[h / 3] = 1;
    ++mesh_.report.caps_removed;
    return true;
  }

  void compact() {
    std::vector<std::uint32_t> renamed(mesh_.triangles.size());
    std::uint32_t kept = 0;
    for (std::uint32_t t = 0; t < renamed.size(); ++t) renamed[t] = removed_[t] ? kNone : kept++;
    for (std::uint32_t t = 0; t < renamed.size(); ++t) {
      if (removed_[t]) continue;
      for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t partner = opposite_[3 * t + k];
        // renamed[t] <= t: the slot written here has been read already.
        opposite_[3 * renamed[t] + k] = partner == kNone ? kNone : 3 * renamed[partner / 3] + partner % 3;
      }
    }
    opposite_.resize(3 * kept);
    mesh_.drop([&](std::size_t t) { return removed_[t] ? TriangleFate::kSliver : TriangleFate::kKept; });
  }

  WorkingMesh& mesh_;
  std::vector<std::uint32_t>& opposite_;
  const std::vector<std::uint8_t>& is_seam_;
  std::vector<std::uint8_t> removed_;
};

}  // namespace

std::size_t remove_slivers(WorkingMesh& mesh, std::vector<std::uint32_t>& opposite,
                           const std::vector<std::uint8_t>& is_seam) {
  return SliverRemoval(mesh, opposite, is_seam).run();
}

}  // namespace nmc::conditioning
