// SPDX-License-Identifier: Apache-2.0
#include "encoder/condition/pair_edges.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "encoder/condition/sides.h"

namespace nmc::conditioning {

namespace {

/// With more triangles around one edge than this, no pair of them is a likely continuation, and looking at
/// all pairs would cost the square of their number: they stay open.
constexpr std::size_t kLargestCrowd = 256;

/// A triangle around a crowded edge that has no partner yet. The edge runs from its lower to its higher
/// vertex.
struct Leaf {
  std::uint32_t half_edge;
  bool forward;  // the half-edge, as its triangle is turned so far, runs from the lower to the higher vertex
  double angle_rad;  // of the triangle around the edge, counter-clockwise seen against the edge, in [0, 2 pi)
};

class Pairing {
 public:
  explicit Pairing(WorkingMesh& mesh) : mesh_(mesh), pairs_(3 * mesh.triangles.size(), kNone) {}

  PairedEdges run(const EdgeGroups& edges) {
    PairedEdges result;
    edges.for_each([&](std::span<const GroupedHalfEdge> group) { pair_plainly(group); });
    const CutEdges cut = open_contradictory_pairs(mesh_, pairs_);
    result.cut_edges = cut.edges;
    result.non_orientable_pieces = cut.pieces;
    Sides sides(mesh_, pairs_);
    for (const auto& crowd : crowds_) {
      std::vector<Leaf> leaves = leaves_of(crowd, sides);
      if (!pair_material_wedges(leaves, sides)) pair_flattest_first(leaves, sides, false);
    }
    // Turning a piece can make leaves of an earlier edge agree; until nothing changes.
    for (bool changed = !crowds_.empty(); changed;) {
      changed = false;
      for (const auto& crowd : crowds_) {
        std::vector<Leaf> leaves = leaves_of(crowd, sides);
        changed |= pair_flattest_first(leaves, sides, false);
        changed |= pair_flattest_first(leaves, sides, true);
      }
    }
    result.crowded_edges = crowded_edge_count_;
    for (const auto& crowd : crowds_)
      result.crowded_edges_open +=
          std::any_of(crowd.begin(), crowd.end(), [&](std::uint32_t h) { return pairs_[h] == kNone; });
    turn(sides);
    result.pairs = std::move(pairs_);
    return result;
  }

 private:
  void join(std::uint32_t a, std::uint32_t b) {
    pairs_[a] = b;
    pairs_[b] = a;
  }

  std::uint64_t stored_edge(std::uint32_t h) const {
    const std::uint64_t a = tail_of(mesh_.stored, h), b = head_of(mesh_.stored, h);
    return std::min(a, b) << 32 | std::max(a, b);
  }

  void pair_plainly(std::span<const GroupedHalfEdge> group) {
    if (group.size() < 2) return;
    if (group.size() == 2) {
      join(group[0].half_edge(), group[1].half_edge());
      return;
    }
    ++crowded_edge_count_;
    mesh_.note(Defect::kCrowdedEdge, [&] {
      const std::uint32_t h = group[0].half_edge();
      return fmt::format("the edge between vertices {} and {} has {} triangles", tail_of(mesh_.stored, h),
                         head_of(mesh_.stored, h), group.size());
    });
    std::vector<std::pair<std::uint64_t, std::uint32_t>> by_stored_edge;
    for (const GroupedHalfEdge& entry : group)
      by_stored_edge.push_back({stored_edge(entry.half_edge()), entry.half_edge()});
    std::sort(by_stored_edge.begin(), by_stored_edge.end());
    crowds_.emplace_back();
    for (const GroupedHalfEdge& entry : group) crowds_.back().push_back(entry.half_edge());
    for (std::size_t i = 0; i < by_stored_edge.size();) {
      std::size_t j = i + 1;
      while (j < by_stored_edge.size() && by_stored_edge[j].first == by_stored_edge[i].first) ++j;
      if (j - i == 2) join(by_stored_edge[i].second, by_stored_edge[i + 1].second);
      i = j;
    }
  }

  /// The half-edges of a crowd that are still open, by angle; equal angles (overlapping triangles) by number.
  std::vector<Leaf> leaves_of(const std::vector<std::uint32_t>& crowd, Sides& sides) const {
    const std::uint32_t a = tail_of(mesh_.triangles, crowd[0]), b = head_of(mesh_.triangles, crowd[0]);
    const std::uint32_t lower = std::min(a, b);
    const Vec3 origin = mesh_.positions[lower];
    const Vec3 axis = normalized(mesh_.positions[std::max(a, b)] - origin);
    const Vec3 helper = std::abs(axis.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    const Vec3 u = normalized(cross(axis, helper)), v = cross(axis, u);
    std::vector<Leaf> leaves;
    for (const std::uint32_t h : crowd) {
      if (pairs_[h] != kNone) continue;
      const Vec3 d = mesh_.positions[apex_of(mesh_.triangles, h)] - origin;
      const double angle = std::atan2(dot(d, v), dot(d, u));
      leaves.push_back({h, (tail_of(mesh_.triangles, h) == lower) != sides.is_turned(h / 3),
                        angle < 0 ? angle + 2 * std::numbers::pi : angle});
    }
    std::sort(leaves.begin(), leaves.end(), [](const Leaf& x, const Leaf& y) {
      return x.angle_rad != y.angle_rad ? x.angle_rad < y.angle_rad : x.half_edge < y.half_edge;
    });
    return leaves;
  }

  /// The normal of a forward triangle points to growing angles, that of a backward one to falling angles;
  /// material is opposite to the normal. So a wedge of material begins at a backward triangle and ends at the
  /// next forward.
  bool pair_material_wedges(const std::vector<Leaf>& leaves, Sides& sides) {
    const std::size_t count = leaves.size();
    if (count % 2 != 0) return false;
    for (std::size_t i = 0; i < count; ++i)
      if (leaves[i].forward == leaves[(i + 1) % count].forward) return false;
    for (std::size_t i = 0; i < count; ++i) {
      if (leaves[i].forward) continue;
      const std::uint32_t next = leaves[(i + 1) % count].half_edge;
      join(leaves[i].half_edge, next);
      sides.join(leaves[i].half_edge / 3, next / 3, false);
    }
    return true;
  }

  /// With `turn_pieces` pairs that disagree, without it pairs that agree. Two that disagree in one piece can
  /// never be a pair.
  bool pair_flattest_first(const std::vector<Leaf>& leaves, Sides& sides, bool turn_pieces) {
    struct Candidate {
      double bend_rad;
      std::size_t i, j;
    };
    if (leaves.size() > kLargestCrowd) return false;
    std::vector<Candidate> candidates;
    for (std::size_t i = 0; i < leaves.size(); ++i)
      for (std::size_t j = i + 1; j < leaves.size(); ++j)
        candidates.push_back(
            {std::abs(std::numbers::pi - (leaves[j].angle_rad - leaves[i].angle_rad)), i, j});
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const Candidate& a, const Candidate& b) { return a.bend_rad < b.bend_rad; });
    const auto agree = [&](const Leaf& a, const Leaf& b) {
      // Turning a piece on the way here changes what `forward` said for its leaves.
      const auto is_forward = [&](const Leaf& leaf) {
        const std::uint32_t tail = tail_of(mesh_.triangles, leaf.half_edge);
        return (tail < head_of(mesh_.triangles, leaf.half_edge)) != sides.is_turned(leaf.half_edge / 3);
      };
      return is_forward(a) != is_forward(b);
    };
    bool changed = false;
    for (const Candidate& c : candidates) {
      const std::uint32_t a = leaves[c.i].half_edge, b = leaves[c.j].half_edge;
      if (pairs_[a] != kNone || pairs_[b] != kNone) continue;
      const bool agreeing = agree(leaves[c.i], leaves[c.j]);
      if (!agreeing && (!turn_pieces || sides.in_one_piece(a / 3, b / 3))) continue;
      join(a, b);
      sides.join(a / 3, b / 3, !agreeing);
      changed = true;
    }
    return changed;
  }

  void turn(Sides& sides) {
    std::vector<std::uint8_t> turned(mesh_.triangles.size());
    for (std::uint32_t t = 0; t < turned.size(); ++t) turned[t] = sides.is_turned(t);
    const auto first = std::find(turned.begin(), turned.end(), 1);
    if (first == turned.end()) return;
    mesh_.note(Defect::kMisoriented, [&] {
      return fmt::format("triangle {} is oriented against its neighbours",
                         mesh_.source[static_cast<std::size_t>(first - turned.begin())]);
    });
    turn_triangles(mesh_, pairs_, turned);
  }

  WorkingMesh& mesh_;
  std::vector<std::uint32_t> pairs_;
  std::size_t crowded_edge_count_ = 0;
  std::vector<std::vector<std::uint32_t>> crowds_;  // the half-edges of each crowded edge
};

}  // namespace

PairedEdges pair_edges(WorkingMesh& mesh, const EdgeGroups& edges) { return Pairing(mesh).run(edges); }

}  // namespace nmc::conditioning
