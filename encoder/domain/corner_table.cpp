// SPDX-License-Identifier: Apache-2.0
#include "encoder/domain/corner_table.h"

#include <string>
#include <utility>

#include "encoder/core/error.h"

namespace nmc {
namespace {

[[noreturn]] void not_manifold(const std::string& what) {
  throw Error(ExitCode::kInvalidInput, "parameterization needs an oriented 2-manifold: " + what);
}

}  // namespace

CornerTable::CornerTable(std::size_t vertex_count, const std::vector<Triangle>& triangles)
    : real_vertex_count_(vertex_count), real_face_count_(triangles.size()) {
  vertex_.resize(3 * triangles.size());
  for (std::size_t f = 0; f < triangles.size(); ++f)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = triangles[f][k];
      if (v >= vertex_count) not_manifold("a corner index is out of range");
      if (v == triangles[f][(k + 1) % 3]) not_manifold("a triangle has two equal corners");
      vertex_[3 * f + k] = v;
    }
  connect();
  close_boundaries();
  live_.assign(vertex_.size() / 3, 1);
}

void CornerTable::connect() {
  // Corners bucketed by the lower vertex of their opposite edge: counting sort, then a short search per
  // bucket.
  opposite_.assign(vertex_.size(), kNone);
  std::vector<std::uint32_t> first(real_vertex_count_ + 1, 0);
  const auto low = [this](Corner c) { return std::min(vertex_[next(c)], vertex_[previous(c)]); };
  const auto high = [this](Corner c) { return std::max(vertex_[next(c)], vertex_[previous(c)]); };
  for (Corner c = 0; c < vertex_.size(); ++c) ++first[low(c) + 1];
  for (std::size_t v = 0; v < real_vertex_count_; ++v) first[v + 1] += first[v];
  std::vector<Corner> bucket(vertex_.size());
  {
    std::vector<std::uint32_t> at(first.begin(), first.end() - 1);
    for (Corner c = 0; c < vertex_.size(); ++c) bucket[at[low(c)]++] = c;
  }
  for (std::size_t v = 0; v < real_vertex_count_; ++v)
    for (std::uint32_t i = first[v]; i < first[v + 1]; ++i)
      for (std::uint32_t j = i + 1; j < first[v + 1]; ++j) {
        const Corner a = bucket[i], b = bucket[j];
        if (high(a) != high(b)) continue;
        if (opposite_[a] != kNone || opposite_[b] != kNone)
          not_manifold("an edge has more than two triangles");
        if (vertex_[next(a)] == vertex_[next(b)])
          not_manifold("neighbouring triangles are oriented differently");
        opposite_[a] = b;
        opposite_[b] = a;
      }
}

void CornerTable::close_boundaries() {
  const std::size_t real_corners = vertex_.size();
  corner_at_.assign(real_vertex_count_, kNone);
  for (Corner c = 0; c < real_corners; ++c) corner_at_[vertex_[c]] = c;

  // The boundary half-edge that starts at each boundary vertex, named by the corner opposite to it.
  std::vector<Corner> leaving(real_vertex_count_, kNone);
  bool any = false;
  for (Corner c = 0; c < real_corners; ++c)
    if (opposite_[c] == kNone) {
      if (leaving[vertex_[next(c)]] != kNone) not_manifold("a vertex touches the boundary more than once");
      leaving[vertex_[next(c)]] = c;
      any = true;
    }
  if (any) {
    for (Corner seed = 0; seed < real_corners; ++seed) {
      if (opposite_[seed] != kNone) continue;
      const auto ghost = static_cast<std::uint32_t>(corner_at_.size());
      const auto first_face = static_cast<std::uint32_t>(vertex_.size() / 3);
      corner_at_.push_back(3 * first_face);
      // Half-edge a -> b of the surface gets the ghost face (ghost, b, a); successive half-edges of the loop
      // share the edge ghost - b.
      Corner c = seed;
      std::uint32_t count = 0;
      do {
        const std::uint32_t a = vertex_[next(c)], b = vertex_[previous(c)];
        const auto g = static_cast<Corner>(vertex_.size());
        vertex_.insert(vertex_.end(), {ghost, b, a});
        opposite_.insert(opposite_.end(), {c, kNone, kNone});
        opposite_[c] = g;
        ++count;
        c = leaving[b];
      } while (c != kNone && opposite_[c] == kNone);
      if (c != seed) not_manifold("a boundary loop does not close");
      for (std::uint32_t i = 0; i < count; ++i) {
        const Corner mine = 3 * (first_face + i) + 2;  // opposite the edge ghost - b
        const Corner theirs =
            3 * (first_face + (i + 1) % count) + 1;  // in the next face: opposite a' - ghost, a' = b
        opposite_[mine] = theirs;
        opposite_[theirs] = mine;
      }
    }
  }
  // One umbrella per vertex: walking round must meet as many corners as there are.
  std::vector<std::uint32_t> corner_count(corner_at_.size(), 0);
  for (const std::uint32_t v : vertex_) ++corner_count[v];
  for (std::uint32_t v = 0; v < real_vertex_count_; ++v) {
    if (corner_at_[v] == kNone) continue;
    std::uint32_t count = 0;
    Corner c = corner_at_[v];
    do {
      ++count;
      c = rotate(c);
    } while (c != corner_at_[v] && count <= corner_count[v]);
    if (count != corner_count[v]) not_manifold("two sheets meet at a vertex");
  }
}

int CornerTable::valence(std::uint32_t v) const {
  int count = 0;
  Corner c = corner_at_[v];
  do {
    ++count;
    c = rotate(c);
  } while (c != corner_at_[v]);
  return count;
}

bool CornerTable::is_boundary_vertex(std::uint32_t v) const {
  Corner c = corner_at_[v];
  do {
    if (is_ghost_face(face_of(c))) return true;
    c = rotate(c);
  } while (c != corner_at_[v]);
  return false;
}

void CornerTable::collapse(Corner c) {
  // Faces (v, u, a) = face_of(c) and (v, b, u) across the edge v - u.
  const Corner at_v = c, at_u = next(c), at_a = previous(c);
  const Corner at_b = opposite_[at_a], other_u = next(at_b), other_v = previous(at_b);
  const std::uint32_t u = vertex_[at_u], v = vertex_[at_v];
  const Corner ua = opposite_[at_v], av = opposite_[at_u];
  const Corner bu = opposite_[other_v], vb = opposite_[other_u];
  for (Corner d = rotate(at_v); face_of(d) != face_of(at_b); d = rotate(d)) vertex_[d] = u;
  opposite_[ua] = av;
  opposite_[av] = ua;
  opposite_[bu] = vb;
  opposite_[vb] = bu;
  corner_at_[vertex_[at_a]] = next(ua);
  corner_at_[u] = previous(ua);
  corner_at_[vertex_[at_b]] = previous(bu);
  corner_at_[v] = kNone;
  live_[face_of(at_v)] = live_[face_of(at_b)] = 0;
}

void CornerTable::undo_collapse(Corner c) {
  const Corner at_v = c, at_u = next(c), at_a = previous(c);
  const Corner at_b = opposite_[at_a], other_u = next(at_b), other_v = previous(at_b);
  const std::uint32_t v = vertex_[at_v];
  live_[face_of(at_v)] = live_[face_of(at_b)] = 1;
  for (const Corner d : {at_v, at_u, other_u, other_v}) opposite_[opposite_[d]] = d;
  for (Corner d = rotate(at_v); face_of(d) != face_of(at_b); d = rotate(d)) vertex_[d] = v;
  corner_at_[v] = at_v;
  corner_at_[vertex_[at_u]] = at_u;
}

void CornerTable::flip(Corner c) {
  // (p, a, b) and (q, b, a) become (p, a, q) and (q, b, p), in place: corner b of the first face moves to q,
  // corner a of the second to p.
  const Corner p = c, a = next(c), b = previous(c);
  const Corner q = opposite_[c], b2 = next(q), a2 = previous(q);
  const std::uint32_t vp = vertex_[p], va = vertex_[a], vb = vertex_[b], vq = vertex_[q];
  const Corner bp = opposite_[a], aq = opposite_[b2];
  vertex_[b] = vq;
  vertex_[a2] = vp;
  opposite_[p] = aq;
  opposite_[aq] = p;
  opposite_[q] = bp;
  opposite_[bp] = q;
  opposite_[a] = b2;
  opposite_[b2] = a;
  corner_at_[va] = a;
  corner_at_[vb] = b2;
  corner_at_[vp] = p;
  corner_at_[vq] = q;
}

void CornerTable::unflip(Corner c) {
  // (p, a, q) and (q, b, p) become (p, a, b) and (q, b, a).
  const Corner p = c, a = next(c), b = previous(c);
  const Corner b2 = opposite_[a], q = previous(b2), a2 = next(b2);
  const Corner aq = opposite_[p], bp = opposite_[q];
  vertex_[b] = vertex_[b2];
  vertex_[a2] = vertex_[a];
  opposite_[a] = bp;
  opposite_[bp] = a;
  opposite_[b2] = aq;
  opposite_[aq] = b2;
  opposite_[p] = q;
  opposite_[q] = p;
  corner_at_[vertex_[a]] = a;
  corner_at_[vertex_[b]] = b;
  corner_at_[vertex_[p]] = p;
  corner_at_[vertex_[q]] = q;
}

}  // namespace nmc
