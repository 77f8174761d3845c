// SPDX-License-Identifier: Apache-2.0
// The levels below a decoded one, read from its triangle list alone (spec 6.1): face f of one level becomes
// the faces 4f ... 4f+3 of the next, and the first three keep its corners.
#ifndef NMC_DECODER_ADAPTIVE_FACE_HIERARCHY_H_
#define NMC_DECODER_ADAPTIVE_FACE_HIERARCHY_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace nmc {

inline constexpr int next_corner(int k) { return k == 2 ? 0 : k + 1; }
inline constexpr int corner_after_next(int k) { return k == 0 ? 2 : k - 1; }

/// The points of a face that is split `depth` times, by their whole barycentric coordinates b0, b1 and
/// side() - b0 - b1. Holds 4 (side + 1) (side + 2) bytes; one serves all faces of a level.
class FaceLattice {
 public:
  explicit FaceLattice(int depth)
      : side_(std::uint32_t{1} << depth), slots_((std::size_t{side_} + 1) * (side_ + 2) / 2) {
    const std::uint32_t corners[3][2] = {{side_, 0}, {0, side_}, {0, 0}};
    descend(depth, 0, corners);
  }
  std::uint32_t side() const { return side_; }
  /// Where the descendants of a face list the point: 3 * triangle + corner, counted from the first of them.
  std::size_t slot(std::uint32_t b0, std::uint32_t b1) const { return slots_[index(b0, b1)]; }

 private:
  std::size_t index(std::uint32_t b0, std::uint32_t b1) const {
    return std::size_t{b0} * (2 * std::size_t{side_} + 3 - b0) / 2 + b1;
  }
  void descend(int depth, std::size_t leaf, const std::uint32_t (&c)[3][2]) {
    if (depth == 0) {
      for (std::size_t k = 0; k < 3; ++k) slots_[index(c[k][0], c[k][1])] = 3 * leaf + k;
      return;
    }
    std::uint32_t m[3][2];
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < 2; ++i) m[k][i] = (c[next_corner(k)][i] + c[corner_after_next(k)][i]) / 2;
    const std::uint32_t* const children[4][3] = {
        {c[0], m[2], m[1]}, {m[2], c[1], m[0]}, {m[1], m[0], c[2]}, {m[0], m[1], m[2]}};
    for (std::size_t child = 0; child < 4; ++child) {
      std::uint32_t corners[3][2];
      for (int k = 0; k < 3; ++k)
        for (int i = 0; i < 2; ++i) corners[k][i] = children[child][k][i];
      descend(depth - 1, 4 * leaf + child, corners);
    }
  }

  std::uint32_t side_;
  std::vector<std::size_t> slots_;
};

/// A view of the triangles of level `finest_level`, three vertex indices each, which must stay where they
/// are. All calls are O(1).
class FaceHierarchy {
 public:
  FaceHierarchy(std::span<const std::uint32_t> triangles, int finest_level)
      : triangles_(triangles), finest_level_(finest_level) {}

  std::uint32_t face_count(int level) const {
    return static_cast<std::uint32_t>((triangles_.size() / 3) >> (2 * (finest_level_ - level)));
  }
  /// Corner k of a face.
  std::uint32_t corner(int level, std::uint32_t face, int k) const {
    // It stays corner k of the k-th child, and of that child's k-th child, and so on.
    const std::size_t leaf =
        ((std::size_t{1} << (2 * (finest_level_ - level))) - 1) / 3 * static_cast<std::size_t>(k);
    return triangles_[first_slot(level, face) + 3 * leaf + static_cast<std::size_t>(k)];
  }
  /// The odd vertex of the edge opposite to corner k; level < finest_level.
  std::uint32_t middle(int level, std::uint32_t face, int k) const {
    return corner(level + 1, 4 * face + 3, k);
  }
  /// The vertex at a point of a face; `lattice` is that of depth finest_level - level.
  std::uint32_t vertex_at(int level, std::uint32_t face, const FaceLattice& lattice, std::uint32_t b0,
                          std::uint32_t b1) const {
    return triangles_[first_slot(level, face) + lattice.slot(b0, b1)];
  }

 private:
  std::size_t first_slot(int level, std::uint32_t face) const {
    return std::size_t{3} * (std::size_t{face} << (2 * (finest_level_ - level)));
  }

  std::span<const std::uint32_t> triangles_;
  int finest_level_;
};

}  // namespace nmc

#endif  // NMC_DECODER_ADAPTIVE_FACE_HIERARCHY_H_
