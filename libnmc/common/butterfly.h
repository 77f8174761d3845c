// SPDX-License-Identifier: Apache-2.0
// Prediction of odd vertices: the modified butterfly scheme with curve rules and tension (spec 6.2).
//
// Based on: Dyn, Levin, Gregory. A butterfly subdivision scheme. ACM TOG 9(2), 1990; Zorin, Schroeder,
// Sweldens. Interpolating subdivision for meshes with arbitrary topology. SIGGRAPH 1996 (extraordinary
// vertices); Dyn, Gregory, Levin. A 4-point interpolatory scheme. CAGD 4, 1987 (boundaries and creases).
//
//   regular stencil of the edge (a, b):        g ------ c ------ h      p = 1/2 (a+b) + 1/8 (c+d)
//                                               \      /\      /            - 1/16 (g+h+i+j)
//   A wing that would lie beyond a curve          \  /    \  /
//   edge (a, c) is mirrored: a + c - b.            a ------ b
//                                                 /  \    /  \          .
//                                               /      \/      \        .
//                                              i ------ d ------ j
#ifndef NMC_COMMON_BUTTERFLY_H_
#define NMC_COMMON_BUTTERFLY_H_

#include <cstdint>

#include "libnmc/common/memory.h"
#include "libnmc/common/status.h"
#include "libnmc/common/subdivision.h"
#include "libnmc/common/vec3.h"

namespace nmc {

/// Weights of the ring of an extraordinary vertex for every valence that occurs in a base mesh (spec 6.2.3).
/// Built once per base mesh; valid for all its levels.
class RingWeights {
 public:
  explicit RingWeights(Memory* memory = nullptr)
      : valence_(memory),
        offset_(memory),
        weights_(memory),
        first_spoke_(memory),
        spokes_(memory),
        place_(memory) {}
  Status build(const LevelTopology& base);
  /// Faces around base vertex `vertex`.
  std::uint32_t valence(std::uint32_t vertex) const { return valence_[vertex]; }
  /// `valence` weights: of the neighbour on the edge to be split, then counter-clockwise; last the vertex's
  /// own.
  const double* of_valence(std::uint32_t valence) const { return weights_.data() + offset_[valence]; }

  /// The neighbours of a base vertex without a boundary at level `level` >= 1, counter-clockwise from the
  /// other end of `edge`, one of its edges there: each is the odd vertex of an edge of the level below. Calls
  /// visit(i, edge of the level below).
  template <class Visit>
  void visit_spokes(std::uint32_t vertex, std::uint32_t edge, std::uint32_t level, const Visit& visit) const {
    // The first of the 2^level parts of base edge e is e 2^level, the last the one before (e + 1) 2^level.
    const std::uint32_t last_part = (1u << level) - 1, base_edge = edge >> level;
    const std::uint32_t end = (edge & last_part) != 0 ? 1u : 0u, valence = valence_[vertex];
    const Spoke* spokes = spokes_.data() + first_spoke_[vertex];
    std::uint32_t place = place_[2 * base_edge + end];
    for (std::uint32_t i = 0; i < valence; ++i) {
      const Spoke spoke = spokes[place];
      visit(i, (spoke.base_edge << (level - 1)) + (spoke.end ? last_part >> 1 : 0u));
      if (++place == valence) place = 0;
    }
  }

 private:
  static constexpr std::uint32_t kOnBoundary = kNone - 1;
  Status find_spokes(const LevelTopology& base);

  struct Spoke {
    std::uint32_t base_edge;
    std::uint32_t end;  // which end of it the vertex is
  };
  Array<std::uint32_t> valence_;  // per base vertex
  Array<std::uint32_t> offset_;   // per valence, into weights_
  Array<double> weights_;
  Array<std::uint32_t> first_spoke_;  // per base vertex, into spokes_
  Array<Spoke> spokes_;               // of vertices without a boundary, counter-clockwise
  Array<std::uint8_t> place_;         // per end of a base edge, among the spokes of its vertex
};

/// How strongly the prediction bends: the share of the butterfly's correction that is added to the midpoint.
/// 1 is the butterfly, 0 the midpoint (spec 3.3: stored per level in quarters).
struct Tension {
  double share = 1;
};

/// Predicted position of the odd vertex of `edge`. `positions` are those of the vertices of `topology`.
/// O(1) for regular neighbourhoods, O(valence) next to an extraordinary vertex. Bits are normative.
Vec3 predict_odd_vertex(const LevelTopology& topology, const RingWeights& ring_weights, std::uint32_t edge,
                        Tension tension, const Vec3* positions);

/// The same prediction as a list of vertices and weights, for those who need its transpose. Calls
/// visit(vertex, weight); a vertex may be visited several times; the weights sum to 1 up to rounding.
template <class Visit>
void visit_stencil(const LevelTopology& topology, const RingWeights& ring_weights, std::uint32_t edge,
                   Tension tension, const Visit& visit);

// ---- implementation ----

namespace butterfly_internal {

/// A base vertex inside the surface, away from curves, with other than six faces.
inline bool is_extraordinary(const LevelTopology& topology, const RingWeights& ring_weights,
                             std::uint32_t vertex) {
  return vertex < topology.base_vertex_count && topology.curve_degree(vertex) == 0 &&
         ring_weights.valence(vertex) != 6;
}

/// The other end of the curve that continues through `vertex`, coming along `edge`; kNone at a corner.
inline std::uint32_t curve_continuation(const LevelTopology& topology, std::uint32_t vertex,
                                        std::uint32_t edge) {
  if (topology.curve_degree(vertex) != 2) return kNone;
  const std::uint32_t* slots = topology.vertex_curve_edges.data() + std::size_t{2} * vertex;
  const std::uint32_t next = slots[0] == edge ? slots[1] : slots[0];
  return topology.edge_vertices[2 * next] ^ topology.edge_vertices[2 * next + 1] ^ vertex;
}

/// The wing beyond the edge (near, tip) of `face`, or kNone when that edge is a curve. `far` is the third
/// corner.
inline std::uint32_t wing(const LevelTopology& topology, std::uint32_t face, std::uint32_t far) {
  const std::uint32_t* corners = topology.face_vertices.data() + std::size_t{3} * face;
  const int k = corners[0] == far ? 0 : corners[1] == far ? 1 : 2;
  const std::uint32_t side = topology.face_edges[3 * face + k];
  if (topology.is_curve(side)) return kNone;
  const std::uint32_t left = topology.edge_faces[2 * side], right = topology.edge_faces[2 * side + 1];
  return topology.opposite_vertex(side, left == face ? right : left);
}

/// The neighbours of an inner vertex, counter-clockwise from the other end of `edge`.
template <class Visit>
void visit_ring(const LevelTopology& topology, std::uint32_t vertex, std::uint32_t edge,
                std::uint32_t valence, const Visit& visit) {
  for (std::uint32_t i = 0; i < valence; ++i) {
    const bool outward = topology.edge_vertices[2 * edge] == vertex;
    visit(i, topology.edge_vertices[2 * edge + (outward ? 1 : 0)]);
    // The face counter-clockwise of the spoke holds it directed away from the vertex: left of an outward
    // edge.
    const std::uint32_t face = topology.edge_faces[2 * edge + (outward ? 0 : 1)];
    const std::uint32_t* corners = topology.face_vertices.data() + std::size_t{3} * face;
    const int k = corners[0] == vertex ? 0 : corners[1] == vertex ? 1 : 2;
    edge = topology.face_edges[3 * face + (k + 1) % 3];
  }
}

}  // namespace butterfly_internal

template <class Visit>
void visit_stencil(const LevelTopology& topology, const RingWeights& ring_weights, std::uint32_t edge,
                   Tension tension, const Visit& visit) {
  using namespace butterfly_internal;
  const std::uint32_t a = topology.edge_vertices[2 * edge], b = topology.edge_vertices[2 * edge + 1];
  const double t = tension.share;
  if (topology.is_curve(edge)) {
    const std::uint32_t before = curve_continuation(topology, a, edge),
                        after = curve_continuation(topology, b, edge);
    if (before != kNone && after != kNone) {
      visit(a, 0.5 + t * 0.0625);
      visit(b, 0.5 + t * 0.0625);
      visit(before, -t * 0.0625);
      visit(after, -t * 0.0625);
    } else if (before == kNone && after == kNone) {
      visit(a, 0.5);
      visit(b, 0.5);
    } else {
      const std::uint32_t corner = before == kNone ? a : b, inner = before == kNone ? b : a;
      visit(corner, 0.5 - t * 0.125);
      visit(inner, 0.5 + t * 0.25);
      visit(before == kNone ? after : before, -t * 0.125);
    }
    return;
  }
  const bool extraordinary_a = is_extraordinary(topology, ring_weights, a);
  const bool extraordinary_b = is_extraordinary(topology, ring_weights, b);
  if (!extraordinary_a && !extraordinary_b) {
    const double w = t * 0.0625;
    visit(a, 0.5);
    visit(b, 0.5);
    for (int side = 0; side < 2; ++side) {
      const std::uint32_t face = topology.edge_faces[2 * edge + side];
      const std::uint32_t c = topology.opposite_vertex(edge, face);
      visit(c, 2 * w);
      for (int end = 0; end < 2; ++end) {
        const std::uint32_t near = end == 0 ? a : b, far = end == 0 ? b : a;
        const std::uint32_t g = wing(topology, face, far);
        if (g != kNone) {
          visit(g, -w);
        } else {
          visit(near, -w);
          visit(c, -w);
          visit(far, w);
        }
      }
    }
    return;
  }
  const double half = extraordinary_a && extraordinary_b ? 0.5 : 1.0;
  visit(a, 0.5 * (1 - t));
  visit(b, 0.5 * (1 - t));
  for (int end = 0; end < 2; ++end) {
    if (!(end == 0 ? extraordinary_a : extraordinary_b)) continue;
    const std::uint32_t v = end == 0 ? a : b;
    const std::uint32_t valence = ring_weights.valence(v);
    const double* s = ring_weights.of_valence(valence);
    visit_ring(topology, v, edge, valence,
               [&](std::uint32_t i, std::uint32_t neighbour) { visit(neighbour, t * half * s[i]); });
    visit(v, t * half * s[valence]);
  }
}

}  // namespace nmc

#endif  // NMC_COMMON_BUTTERFLY_H_
