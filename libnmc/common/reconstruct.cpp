// SPDX-License-Identifier: Apache-2.0
#include "libnmc/common/reconstruct.h"

#include <algorithm>

#include "libnmc/common/local_frame.h"

namespace nmc {

namespace {

/// A butterfly stencil: the edge (a, b), its tips left and right, and the wings near a and near b on both
/// sides.
struct RegularStencil {
  std::uint32_t a, b;
  std::uint32_t tip[2], wing_a[2], wing_b[2];
};

/// What predict_odd_vertex() computes inside the surface, operation by operation.
Vec3 predict_regular(const RegularStencil& s, double t, const Vec3* x) {
  const Vec3 midpoint = 0.5 * (x[s.a] + x[s.b]);
  if (t == 0) return midpoint;
  Vec3 wings, tips;
  for (int side = 0; side < 2; ++side) {
    tips = tips + x[s.tip[side]];
    wings = wings + (x[s.wing_a[side]] + x[s.wing_b[side]]);
  }
  return midpoint + t * (0.0625 * ((tips + tips) - wings));
}

/// Detail added to predictions, for edges in increasing order.
class DetailReader {
 public:
  DetailReader(const LevelTopology& coarse, const LevelQuantizer& quantizer,
               const LevelCoefficients* coefficients, std::uint32_t first_edge, const Vec3* positions)
      : coarse_(coarse), quantizer_(quantizer), positions_(positions) {
    if (!coefficients) return;
    normal_ = coefficients->normal.data();
    tangential_end_ = coefficients->tangential.end();
    tangential_ =
        std::lower_bound(coefficients->tangential.begin(), tangential_end_, first_edge,
                         [](const TangentialCoefficient& t, std::uint32_t edge) { return t.edge < edge; });
  }

  /// `p` displaced; `normal()` gives the normal of the odd vertex.
  template <class Normal>
  Vec3 displaced(std::uint32_t edge, Vec3 p, const Normal& normal) {
    if (!normal_) return p;
    const std::int32_t c = normal_[edge];
    if (tangential_ != tangential_end_ && tangential_->edge == edge) return displaced_sideways(edge, c, p);
    if (c != 0) p = p + (static_cast<double>(c) * quantizer_.normal_step) * normal();
    return p;
  }

 private:
  NMC_SELDOM Vec3 displaced_sideways(std::uint32_t edge, std::int32_t c, Vec3 p) {
    const LocalFrame frame = odd_vertex_frame(coarse_, edge, positions_);
    p = p + (static_cast<double>(c) * quantizer_.normal_step) * frame.normal;
    p = p + (static_cast<double>(tangential_->along) * quantizer_.tangential_step) * frame.along;
    p = p + (static_cast<double>(tangential_->across) * quantizer_.tangential_step) * frame.across;
    ++tangential_;
    return p;
  }

  const LevelTopology& coarse_;
  const LevelQuantizer& quantizer_;
  const Vec3* positions_;
  const std::int32_t* normal_ = nullptr;
  const TangentialCoefficient* tangential_ = nullptr;
  const TangentialCoefficient* tangential_end_ = nullptr;
};

/// The corner of `face` at `vertex`, which it has.
std::uint32_t corner_at(const LevelTopology& topology, std::uint32_t face, std::uint32_t vertex) {
  const std::uint32_t* v = topology.face_vertices.data() + std::size_t{3} * face;
  return v[0] == vertex ? 0u : v[1] == vertex ? 1u : 2u;
}

/// Beyond `edge` of `face`: the odd vertex of the next edge around `vertex`, one of its ends.
std::uint32_t odd_vertex_beyond(const LevelTopology& parent, std::uint32_t edge, std::uint32_t face,
                                std::uint32_t vertex) {
  const std::uint32_t beyond = parent.face_across(edge, face);
  const std::uint32_t* e = parent.face_edges.data() + std::size_t{3} * beyond;
  const std::uint32_t side = e[0] == edge ? 0u : e[1] == edge ? 1u : 2u;
  return parent.vertex_count + e[3 - side - corner_at(parent, beyond, vertex)];
}

}  // namespace

void reconstruct_odd_vertices(const LevelTopology& coarse, const RingWeights& ring_weights,
                              const LevelQuantizer& quantizer, const LevelCoefficients* coefficients,
                              std::uint32_t first_edge, std::uint32_t last_edge, Vec3* positions) {
  DetailReader detail(coarse, quantizer, coefficients, first_edge, positions);
  Vec3* odd = positions + coarse.vertex_count;
  for (std::uint32_t edge = first_edge; edge < last_edge; ++edge) {
    const Vec3 p = predict_odd_vertex(coarse, ring_weights, edge, quantizer.tension, positions);
    odd[edge] = detail.displaced(edge, p, [&] { return odd_vertex_normal(coarse, edge, positions); });
  }
}

void reconstruct_odd_vertices_of_split(const LevelTopology& parent, const LevelTopology& coarse,
                                       const RingWeights& ring_weights, const LevelQuantizer& quantizer,
                                       const LevelCoefficients* coefficients, std::uint32_t first_edge,
                                       std::uint32_t last_edge, Vec3* positions) {
  const Vec3* const x = positions;
  const std::uint32_t V = parent.vertex_count, inner_begin = 2 * parent.edge_count;
  DetailReader detail(coarse, quantizer, coefficients, first_edge, positions);
  Vec3* odd = positions + coarse.vertex_count;
  const auto place = [&](std::uint32_t edge, const RegularStencil& s) {
    const Vec3 p = predict_regular(s, quantizer.tension.share, x);
    odd[edge] = detail.displaced(
        edge, p, [&] { return normalized(cross(x[s.b] - x[s.a], x[s.tip[0]] - x[s.tip[1]])); });
  };

  // The halves (a, m) and (m, b) of each parent edge: on both sides, the odd vertices of the face's other
  // edges, that at a and that at b, and what lies beyond those edges.
  const std::uint32_t halves_end = last_edge < inner_begin ? last_edge : inner_begin;
  std::uint32_t edge = first_edge;
  while (edge < halves_end) {
    const std::uint32_t e = edge / 2, a = parent.edge_vertices[2 * e], b = parent.edge_vertices[2 * e + 1];
    RegularStencil at_a{a, V + e, {}, {}, {}}, at_b{V + e, b, {}, {}, {}};
    for (int side = 0; side < 2; ++side) {
      const std::uint32_t face = parent.edge_faces[2 * e + static_cast<std::uint32_t>(side)];
      const std::uint32_t* edges = parent.face_edges.data() + std::size_t{3} * face;
      const std::uint32_t edge_at_a = edges[corner_at(parent, face, b)];
      const std::uint32_t edge_at_b = edges[corner_at(parent, face, a)];
      at_a.tip[side] = at_b.wing_a[side] = V + edge_at_a;
      at_b.tip[side] = at_a.wing_b[side] = V + edge_at_b;
      at_a.wing_a[side] = odd_vertex_beyond(parent, edge_at_a, face, a);
      at_b.wing_b[side] = odd_vertex_beyond(parent, edge_at_b, face, b);
    }
    for (; edge < halves_end && edge / 2 == e; ++edge) {
      const RegularStencil& stencil = edge % 2 == 0 ? at_a : at_b;
      const std::uint32_t end = edge % 2 == 0 ? a : b;
      if (butterfly_internal::is_extraordinary(coarse, ring_weights, end)) {
        const Vec3 p = predict_odd_vertex(coarse, ring_weights, edge, quantizer.tension, positions);
        odd[edge] = detail.displaced(edge, p, [&] { return odd_vertex_normal(coarse, edge, positions); });
      } else {
        place(edge, stencil);
      }
    }
  }

  // The inner edges (m_k+1, m_k+2) of each parent face: m_k and the corners around it on the left, corner k
  // and what lies beyond its two edges on the right. The ends are odd vertices, so always regular.
  while (edge < last_edge) {
    const std::uint32_t face = (edge - inner_begin) / 3, end = inner_begin + 3 * face + 3;
    const std::uint32_t* v = parent.face_vertices.data() + std::size_t{3} * face;
    const std::uint32_t* e = parent.face_edges.data() + std::size_t{3} * face;
    for (; edge < last_edge && edge < end; ++edge) {
      const std::uint32_t k = edge - inner_begin - 3 * face, k1 = k == 2 ? 0 : k + 1, k2 = k == 0 ? 2 : k - 1;
      place(edge, {V + e[k1],
                   V + e[k2],
                   {V + e[k], v[k]},
                   {v[k2], odd_vertex_beyond(parent, e[k1], face, v[k])},
                   {v[k1], odd_vertex_beyond(parent, e[k2], face, v[k])}});
    }
  }
}

}  // namespace nmc
