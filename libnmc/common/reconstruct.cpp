// SPDX-License-Identifier: Apache-2.0
#include "libnmc/common/reconstruct.h"

#include <algorithm>

#include "libnmc/common/face_walk.h"
#include "libnmc/common/local_frame.h"

namespace nmc {

namespace {

/// What predict_odd_vertex() computes inside the surface for the edge (a, b), operation by operation: tips
/// and wings on the left and on the right. That sums begin at zero is left out where the sign of a zero
/// cannot matter.
inline Vec3 predict_regular(double t, const Vec3& a, const Vec3& b, const Vec3& left_tip,
                            const Vec3& right_tip, const Vec3& left_wing_a, const Vec3& left_wing_b,
                            const Vec3& right_wing_a, const Vec3& right_wing_b) {
  const Vec3 midpoint = 0.5 * (a + b);
  if (t == 0) return midpoint;
  const Vec3 tips = (Vec3{} + left_tip) + right_tip;
  const Vec3 wings = (left_wing_a + left_wing_b) + (right_wing_a + right_wing_b);
  return midpoint + t * (0.0625 * ((tips + tips) - wings));
}

/// Displaces predicted vertices. Most coefficients are zero, so this is a pass of its own.
void add_detail(const LevelTopology& coarse, const LevelQuantizer& quantizer,
                const LevelCoefficients& coefficients, std::uint32_t first_edge, std::uint32_t last_edge,
                Vec3* positions) {
  const TangentialCoefficient* tangential =
      std::lower_bound(coefficients.tangential.begin(), coefficients.tangential.end(), first_edge,
                       [](const TangentialCoefficient& t, std::uint32_t edge) { return t.edge < edge; });
  const std::int32_t* const normal = coefficients.normal.data();
  Vec3* const odd = positions + coarse.vertex_count;
  std::uint32_t edge = first_edge;
  while (edge < last_edge) {
    const bool has_tangential = tangential != coefficients.tangential.end() && tangential->edge < last_edge;
    const std::uint32_t next_tangential = has_tangential ? tangential->edge : last_edge;
    for (; edge < next_tangential; ++edge) {
      if (normal[edge] == 0) continue;
      const double offset = static_cast<double>(normal[edge]) * quantizer.normal_step;
      odd[edge] = odd[edge] + offset * odd_vertex_normal(coarse, edge, positions);
    }
    if (!has_tangential) break;
    const LocalFrame frame = odd_vertex_frame(coarse, edge, positions);
    Vec3 p = odd[edge] + (static_cast<double>(normal[edge]) * quantizer.normal_step) * frame.normal;
    p = p + (static_cast<double>(tangential->along) * quantizer.tangential_step) * frame.along;
    odd[edge] = p + (static_cast<double>(tangential->across) * quantizer.tangential_step) * frame.across;
    ++tangential;
    ++edge;
  }
}

/// Whether the stencils of the halves of parent edge `e` meet a curve, so that the general rules are needed.
bool is_curve_near(const LevelTopology& parent, std::uint32_t e, const EdgeSide sides[2]) {
  if (!parent.has_curves()) return false;
  const std::uint8_t* is_curve = parent.edge_is_curve.data();
  if (is_curve[e]) return true;
  return (is_curve[sides[0].other[0]] | is_curve[sides[0].other[1]] | is_curve[sides[1].other[0]] |
          is_curve[sides[1].other[1]]) != 0;
}

/// What predict_odd_vertex() computes for the half `edge` = (a, b) at base vertex `corner`, extraordinary, of
/// which the other end is an odd vertex: all around the corner are those of the parent's spokes, so that
/// there is no walking from face to face.
Vec3 predict_beside(const RingWeights& ring_weights, std::uint32_t corner, std::uint32_t edge,
                    std::uint32_t level, const Vec3& a, const Vec3& b, const Vec3* middle, double t,
                    const Vec3* x) {
  const Vec3 midpoint = 0.5 * (a + b);
  const std::uint32_t valence = ring_weights.valence(corner);
  const double* s = ring_weights.of_valence(valence);
  Vec3 sum = s[valence] * x[corner];
  ring_weights.visit_spokes(corner, edge, level, [&](std::uint32_t i, std::uint32_t parent_edge) {
    sum = sum + s[i] * middle[parent_edge];
  });
  return midpoint + t * ((Vec3{} + sum) - midpoint);
}

}  // namespace

void reconstruct_odd_vertices(const LevelTopology& coarse, const RingWeights& ring_weights,
                              const LevelQuantizer& quantizer, const LevelCoefficients* coefficients,
                              std::uint32_t first_edge, std::uint32_t last_edge, Vec3* positions) {
  Vec3* odd = positions + coarse.vertex_count;
  for (std::uint32_t edge = first_edge; edge < last_edge; ++edge)
    odd[edge] = predict_odd_vertex(coarse, ring_weights, edge, quantizer.tension, positions);
  if (coefficients) add_detail(coarse, quantizer, *coefficients, first_edge, last_edge, positions);
}

void reconstruct_odd_vertices_of_split(const LevelTopology& parent, const LevelTopology& coarse,
                                       const RingWeights& ring_weights, const LevelQuantizer& quantizer,
                                       const LevelCoefficients* coefficients, std::uint32_t first_edge,
                                       std::uint32_t last_edge, Vec3* positions) {
  const Vec3* const x = positions;
  const Vec3* const middle = positions + parent.vertex_count;  // of the parent's edges
  Vec3* const odd = positions + coarse.vertex_count;
  const std::uint32_t inner_begin = 2 * parent.edge_count;
  const double t = quantizer.tension.share;
  const auto predict_generally = [&](std::uint32_t edge) {
    odd[edge] = predict_odd_vertex(coarse, ring_weights, edge, quantizer.tension, x);
  };

  // The halves (a, m) and (m, b) of each parent edge: on both sides, the odd vertices of the face's other
  // edges, that at a and that at b, and of the next edges around a and b.
  const std::uint32_t halves_end = last_edge < inner_begin ? last_edge : inner_begin;
  std::uint32_t edge = first_edge;
  while (edge < halves_end) {
    const std::uint32_t e = edge / 2;
    const EdgeSide sides[2] = {edge_side(parent, e, 0), edge_side(parent, e, 1)};
    if (edge % 2 != 0 || edge + 1 == halves_end || is_curve_near(parent, e, sides)) {
      predict_generally(edge++);
      continue;
    }
    const Vec3& m = middle[e];
    const Vec3* at[2][2];      // odd vertices of the other edges: side, end
    const Vec3* around[2][2];  // and of the next edges around the ends
    for (std::uint32_t i = 0; i < 2; ++i) {
      for (std::uint32_t end = 0; end < 2; ++end) {
        const std::uint32_t other = sides[i].other[end];
        const FaceBeyond beyond = face_beyond(parent, other, sides[i].face);
        at[i][end] = middle + other;
        around[i][end] = middle + (i == end ? beyond.edge_at_head : beyond.edge_at_tail);
      }
    }
    for (std::uint32_t end = 0; end < 2; ++end, ++edge) {
      const std::uint32_t corner = parent.edge_vertices[2 * e + end];
      const Vec3 &left_tip = *at[0][end], &right_tip = *at[1][end];
      const Vec3 &a = end == 0 ? x[corner] : m, &b = end == 0 ? m : x[corner];
      if (butterfly_internal::is_extraordinary(coarse, ring_weights, corner)) {
        odd[edge] = t == 0 ? 0.5 * (a + b)
                           : predict_beside(ring_weights, corner, edge, coarse.level, a, b, middle, t, x);
      } else {
        const Vec3 &left_far = *around[0][end], &left_near = *at[0][1 - end];
        const Vec3 &right_far = *around[1][end], &right_near = *at[1][1 - end];
        odd[edge] =
            end == 0
                ? predict_regular(t, a, b, left_tip, right_tip, left_far, left_near, right_far, right_near)
                : predict_regular(t, a, b, left_tip, right_tip, left_near, left_far, right_near, right_far);
      }
    }
  }

  // The inner edges (m_k+1, m_k+2) of each parent face: m_k and the corners around it on the left, corner k
  // and what lies beyond its two edges on the right. The ends are odd vertices, so always regular.
  while (edge < last_edge) {
    const std::uint32_t face = (edge - inner_begin) / 3, first = inner_begin + 3 * face;
    const std::uint32_t* v = parent.face_vertices.data() + std::size_t{3} * face;
    const std::uint32_t* e = parent.face_edges.data() + std::size_t{3} * face;
    const bool has_curve = parent.has_curves() && (parent.edge_is_curve[e[0]] | parent.edge_is_curve[e[1]] |
                                                   parent.edge_is_curve[e[2]]) != 0;
    if (edge != first || first + 3 > last_edge || has_curve) {
      predict_generally(edge++);
      continue;
    }
    const Vec3* after[3];   // beyond the edge that comes after a corner
    const Vec3* before[3];  // and beyond the one before it
    for (std::uint32_t k = 0; k < 3; ++k) {
      const FaceBeyond beyond = face_beyond(parent, e[k], face);
      after[next_corner(k)] = middle + beyond.edge_at_tail;
      before[previous_corner(k)] = middle + beyond.edge_at_head;
    }
    for (std::uint32_t k = 0; k < 3; ++k, ++edge) {
      const std::uint32_t k1 = next_corner(k), k2 = previous_corner(k);
      odd[edge] = predict_regular(t, middle[e[k1]], middle[e[k2]], middle[e[k]], x[v[k]], x[v[k2]], x[v[k1]],
                                  *before[k], *after[k]);
    }
  }
  if (coefficients) add_detail(coarse, quantizer, *coefficients, first_edge, last_edge, positions);
}

}  // namespace nmc
