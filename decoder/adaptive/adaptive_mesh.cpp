// SPDX-License-Identifier: Apache-2.0
#include "decoder/adaptive/adaptive_mesh.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "decoder/adaptive/face_hierarchy.h"
#include "libnmc/common/vec3.h"

namespace nmc {

namespace {

using std::size_t;
using std::uint32_t;
using std::uint8_t;

constexpr uint8_t kAllEdges = 7;
constexpr uint8_t kNotChecked = 0xff;

/// How a face with some split edges is cut: bit k of `mask` tells that edge k, opposite to corner k, is
/// split. With two split edges the quad beside the corner between them is cut from the corner
/// `diagonal_from`.
struct Cut {
  uint8_t mask = 0;
  int unsplit = 0;        // with two split edges: the other one
  int diagonal_from = 0;  // unsplit + 1 or unsplit + 2
};

constexpr auto next = next_corner, after_next = corner_after_next;

class Extraction {
 public:
  Extraction(std::span<const uint32_t> triangles, std::span<const double> positions, int level,
             double tolerance)
      : hierarchy_(triangles, level),
        positions_(positions),
        level_(level),
        tolerance_(tolerance),
        base_face_count_(hierarchy_.face_count(0)),
        is_used_(positions.size() / 3, 0) {
    for (int l = 0; l < level; ++l) {
      checked_.emplace_back(hierarchy_.face_count(l), kNotChecked);
      lattices_.emplace_back(level - l);
    }
  }

  AdaptiveMesh run() {
    // Marks only grow, so this ends; a pass without a new mark has found every face good and every tree
    // restricted.
    do {
      has_changed_ = false;
      for (uint32_t face = 0; face < base_face_count_; ++face) refine(0, face);
      restrict_trees();
    } while (has_changed_);
    for (uint32_t face = 0; face < base_face_count_; ++face) emit(0, face);
    number_vertices();
    return std::move(mesh_);
  }

 private:
  Vec3 point(uint32_t vertex) const {
    const double* p = positions_.data() + size_t{3} * vertex;
    return {p[0], p[1], p[2]};
  }
  uint32_t corner(int level, uint32_t face, int k) const { return hierarchy_.corner(level, face, k); }
  uint32_t middle(int level, uint32_t face, int k) const { return hierarchy_.middle(level, face, k); }

  uint8_t split_edges(int level, uint32_t face) const {
    uint8_t mask = 0;
    for (int k = 0; k < 3; ++k) mask |= static_cast<uint8_t>(is_used_[middle(level, face, k)] << k);
    return mask;
  }
  void split_all(int level, uint32_t face) {
    for (int k = 0; k < 3; ++k) {
      uint8_t& is_used = is_used_[middle(level, face, k)];
      if (!is_used) has_changed_ = true;
      is_used = 1;
    }
  }

  Cut cut_of(int level, uint32_t face, uint8_t mask) const {
    Cut cut{mask, 0, 0};
    if (mask != 3 && mask != 5 && mask != 6) return cut;
    cut.unsplit = mask == 6 ? 0 : mask == 5 ? 1 : 2;
    const int b = next(cut.unsplit), c = after_next(cut.unsplit);
    const auto diagonal = [&](int k) {
      return squared_norm(point(corner(level, face, k)) - point(middle(level, face, k)));
    };
    cut.diagonal_from = diagonal(c) < diagonal(b) ? c : b;
    return cut;
  }

  /// How much of the offset of each odd vertex the cut face has at the point b.
  static std::array<double, 3> offset_weights(const Cut& cut, const std::array<double, 3>& b) {
    std::array<double, 3> weights{};
    const auto of = [](const std::array<double, 3>& values, int k) { return values[static_cast<size_t>(k)]; };
    if (cut.mask == 1 || cut.mask == 2 || cut.mask == 4) {
      const int k = cut.mask == 1 ? 0 : cut.mask == 2 ? 1 : 2;
      weights[static_cast<size_t>(k)] = 2 * std::min(of(b, next(k)), of(b, after_next(k)));
    } else if (cut.mask != 0) {
      // The diagonal runs from corner `from` to the middle of the edge opposite to it; `other` is the third
      // corner.
      const int apex = cut.unsplit, from = cut.diagonal_from;
      const int other = from == next(apex) ? after_next(apex) : next(apex);
      double at_diagonal = 2 * of(b, other), beside = 2 * of(b, from);
      if (of(b, apex) < 0.5) {
        at_diagonal = 2 * std::min(of(b, apex), of(b, other));
        beside = 2 * std::max(of(b, apex) - of(b, other), 0.0);
      }
      weights[static_cast<size_t>(from)] = at_diagonal;
      weights[static_cast<size_t>(other)] = beside;
    }
    return weights;
  }

  /// Largest distance at the same parameter between the full mesh and the face as cut, or some value above
  /// `enough` once that is passed. The difference is linear between the points looked at: the vertices of the
  /// full mesh, and the places where a cut, which runs along a median of the face, crosses its edges: their
  /// midpoints.
  double deviation(int level, uint32_t face, const Cut& cut, double enough) const {
    const FaceLattice& lattice = lattices_[static_cast<size_t>(level)];
    const uint32_t side = lattice.side();
    Vec3 v[3], offset[3];
    for (int k = 0; k < 3; ++k) v[k] = point(corner(level, face, k));
    double largest = 0;
    for (int k = 0; k < 3; ++k) {
      offset[k] = point(middle(level, face, k)) - 0.5 * (v[next(k)] + v[after_next(k)]);
      if (!(cut.mask >> k & 1)) largest = std::max(largest, squared_norm(offset[k]));
    }
    const double enough_squared = enough * enough;
    if (largest > enough_squared) return std::sqrt(largest);
    const double unit = 1.0 / side;
    const auto look = [&](const Vec3& full, double b0, double b1, double b2) {
      Vec3 difference = full - ((b0 * v[0] + b1 * v[1]) + b2 * v[2]);
      if (cut.mask != 0) {
        const std::array<double, 3> weights = offset_weights(cut, {b0, b1, b2});
        for (size_t k = 0; k < 3; ++k) difference -= weights[k] * offset[k];
      }
      largest = std::max(largest, squared_norm(difference));
    };
    const auto vertex_at = [&](uint32_t b0, uint32_t b1) {
      return point(hierarchy_.vertex_at(level, face, lattice, b0, b1));
    };
    for (uint32_t b0 = 0; b0 <= side; ++b0) {
      for (uint32_t b1 = 0; b0 + b1 <= side; ++b1) {
        look(vertex_at(b0, b1), b0 * unit, b1 * unit, (side - b0 - b1) * unit);
      }
      if (largest > enough_squared) return std::sqrt(largest);
    }
    if (cut.mask != 0) {
      const bool is_single = cut.mask == 1 || cut.mask == 2 || cut.mask == 4;
      const int k = is_single ? (cut.mask == 1 ? 0 : cut.mask == 2 ? 1 : 2) : cut.diagonal_from;
      for (uint32_t c = 1; c < side; c += 2) {
        const uint32_t half = (side - c) / 2;
        uint32_t p[3], q[3];
        double b[3];
        p[k] = q[k] = c;
        p[next(k)] = q[after_next(k)] = half;
        p[after_next(k)] = q[next(k)] = half + 1;
        b[k] = c * unit;
        b[next(k)] = b[after_next(k)] = 0.5 * (side - c) * unit;
        look(0.5 * (vertex_at(p[0], p[1]) + vertex_at(q[0], q[1])), b[0], b[1], b[2]);
      }
    }
    return std::sqrt(largest);
  }

  /// Splits the face until it is within the tolerance.
  void refine(int level, uint32_t face) {
    if (level == level_) return;
    const uint8_t mask = split_edges(level, face);
    if (mask != kAllEdges) {
      uint8_t& checked = checked_[static_cast<size_t>(level)][face];
      if (checked == mask) return;
      if (deviation(level, face, cut_of(level, face, mask), tolerance_) <= tolerance_) {
        checked = mask;
        return;
      }
      split_all(level, face);
    }
    for (uint32_t child = 4 * face; child < 4 * face + 4; ++child) refine(level + 1, child);
  }

  /// Where an edge of a face is split, the face is there: its parent is split.
  void restrict_trees() {
    for (int level = level_ - 1; level > 0; --level) {
      const auto face_count = static_cast<uint32_t>(checked_[static_cast<size_t>(level)].size());
      for (uint32_t face = 0; face < face_count; ++face) {
        if (split_edges(level, face) != 0) split_all(level - 1, face / 4);
      }
    }
  }

  void emit(int level, uint32_t face) {
    const auto v = [&](int k) { return corner(level, face, k); };
    const auto m = [&](int k) { return middle(level, face, k); };
    const uint8_t mask = level == level_ ? uint8_t{0} : split_edges(level, face);
    if (mask == kAllEdges) {
      for (uint32_t child = 4 * face; child < 4 * face + 4; ++child) emit(level + 1, child);
      return;
    }
    const Cut cut = level == level_ ? Cut{} : cut_of(level, face, mask);
    if (level < level_) {
      // Without a limit: every point is looked at.
      const double found = deviation(level, face, cut, 1.7e308);
      mesh_.largest_deviation = std::max(mesh_.largest_deviation, found);
    }
    if (mask == 0) {
      add(v(0), v(1), v(2));
    } else if (mask == 1 || mask == 2 || mask == 4) {
      const int k = mask == 1 ? 0 : mask == 2 ? 1 : 2;
      add(v(k), v(next(k)), m(k));
      add(v(k), m(k), v(after_next(k)));
    } else {
      const int a = cut.unsplit, b = next(a), c = after_next(a);
      add(v(a), m(c), m(b));
      if (cut.diagonal_from == b) {
        add(m(c), v(b), m(b));
        add(v(b), v(c), m(b));
      } else {
        add(m(c), v(b), v(c));
        add(m(c), v(c), m(b));
      }
    }
  }
  void add(uint32_t a, uint32_t b, uint32_t c) { mesh_.triangles.insert(mesh_.triangles.end(), {a, b, c}); }

  void number_vertices() {
    std::vector<uint32_t> number(is_used_.size(), 0);
    for (const uint32_t vertex : mesh_.triangles) number[vertex] = 1;
    for (uint32_t vertex = 0; vertex < number.size(); ++vertex) {
      if (!number[vertex]) continue;
      number[vertex] = static_cast<uint32_t>(mesh_.source_vertices.size());
      mesh_.source_vertices.push_back(vertex);
    }
    for (uint32_t& vertex : mesh_.triangles) vertex = number[vertex];
  }

  FaceHierarchy hierarchy_;
  std::span<const double> positions_;
  int level_;
  double tolerance_;
  uint32_t base_face_count_;
  std::vector<uint8_t> is_used_;  // per vertex: whether the edge it splits is split
  std::vector<std::vector<uint8_t>>
      checked_;                        // per level and face: the split edges with which it was found good
  std::vector<FaceLattice> lattices_;  // per level
  bool has_changed_ = false;
  AdaptiveMesh mesh_;
};

}  // namespace

AdaptiveMesh extract_adaptive(std::span<const uint32_t> triangles, std::span<const double> positions,
                              int level, double tolerance) {
  return Extraction(triangles, positions, level, tolerance).run();
}

}  // namespace nmc
