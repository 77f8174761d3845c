// SPDX-License-Identifier: Apache-2.0
// Half-edge connectivity of a triangle surface in two flat arrays, with collapses that can be undone.
//
// Plain arrays and not OpenMesh, because collapse and undo run once per input vertex, millions of times, and
// a record of 4 bytes per collapse is enough to undo it here: the arrays of a removed face keep what they
// held.
//
// Boundaries are closed by *ghost* vertices: every boundary loop gets one extra vertex joined to all its
// edges, so that every vertex has a closed ring and the link condition needs no special case.
//
// Based on: Rossignac, Safonova, Szymczak, "3D compression made simple: Edgebreaker on a corner table"
// (2001).
#ifndef NMC_ENCODER_DOMAIN_CORNER_TABLE_H_
#define NMC_ENCODER_DOMAIN_CORNER_TABLE_H_

#include <cstdint>
#include <vector>

#include "encoder/core/triangle_mesh.h"

namespace nmc {

/// Corner 3 f + k is corner k of face f; the edge opposite corner c runs from next(c) to previous(c).
class CornerTable {
 public:
  using Corner = std::uint32_t;
  static constexpr std::uint32_t kNone = 0xffffffffu;

  /// Throws Error (kInvalidInput) where `triangles` are not an oriented 2-manifold with boundary. O(n log n).
  CornerTable(std::size_t vertex_count, const std::vector<Triangle>& triangles);

  static Corner next(Corner c) { return c % 3 == 2 ? c - 2 : c + 1; }
  static Corner previous(Corner c) { return c % 3 == 0 ? c + 2 : c - 1; }
  static std::uint32_t face_of(Corner c) { return c / 3; }

  std::uint32_t vertex(Corner c) const { return vertex_[c]; }
  /// The corner that faces c across the edge opposite c.
  Corner opposite(Corner c) const { return opposite_[c]; }
  /// Some corner at v; kNone for a removed or unused vertex.
  Corner corner_at(std::uint32_t v) const { return corner_at_[v]; }
  /// The corner at the same vertex in the next face counter-clockwise.
  Corner rotate(Corner c) const { return next(opposite_[next(c)]); }
  /// The corner at the same vertex in the next face clockwise.
  Corner rotate_back(Corner c) const { return previous(opposite_[previous(c)]); }

  std::size_t real_vertex_count() const { return real_vertex_count_; }
  std::size_t real_face_count() const { return real_face_count_; }
  std::size_t vertex_slot_count() const { return corner_at_.size(); }
  std::size_t face_slot_count() const { return vertex_.size() / 3; }
  bool is_ghost_vertex(std::uint32_t v) const { return v >= real_vertex_count_; }
  bool is_ghost_face(std::uint32_t f) const { return f >= real_face_count_; }
  /// False for faces removed by collapses.
  bool is_live_face(std::uint32_t f) const { return live_[f] != 0; }
  Triangle face(std::uint32_t f) const { return {vertex_[3 * f], vertex_[3 * f + 1], vertex_[3 * f + 2]}; }

  int valence(std::uint32_t v) const;
  bool is_boundary_vertex(std::uint32_t v) const;

  /// Merges v = vertex(c) into u = vertex(next(c)); removes the two faces at the edge v-u. Requires the link
  /// condition. The corner c undoes it.
  void collapse(Corner c);
  /// Undoes collapse(c); must come in exactly reverse order.
  void undo_collapse(Corner c);

  /// Replaces the edge opposite c by the edge from vertex(c) to vertex(opposite(c)). unflip(c) with
  /// the same corner restores the table.
  void flip(Corner c);
  void unflip(Corner c);

 private:
  void connect();
  void close_boundaries();

  std::size_t real_vertex_count_ = 0, real_face_count_ = 0;
  std::vector<std::uint32_t> vertex_;
  std::vector<Corner> opposite_;
  std::vector<Corner> corner_at_;
  std::vector<std::uint8_t> live_;
};

}  // namespace nmc

#endif  // NMC_ENCODER_DOMAIN_CORNER_TABLE_H_
