// SPDX-License-Identifier: Apache-2.0
#include "libnmc/common/butterfly.h"

#include "libnmc/common/face_walk.h"

namespace nmc {

namespace {

/// cos(2 pi i / n) by its Taylor series, folded to the first eighth of a turn: library cosines differ in
/// their last bits from system to system, this one does not (spec 6.2.3).
double cosine_of_fraction(std::uint32_t i, std::uint32_t n) {
  constexpr double kTwoPi = 6.283185307179586;
  i %= n;
  if (2 * i > n) i = n - i;  // cos(-x) = cos(x)
  double sign = 1;
  std::uint32_t twice = 4 * i, whole = 2 * n;  // the angle as twice/whole quarter turns, now in [0, 2]
  if (twice > n) {                             // beyond a quarter turn: cos(pi - x) = -cos(x)
    sign = -1;
    twice = whole - twice;
  }
  // twice / n is now the angle in quarter turns, in [0, 1].
  const bool use_sine = 2 * twice > n;
  const std::uint32_t folded = use_sine ? n - twice : twice;
  const double x = kTwoPi * 0.25 * (static_cast<double>(folded) / static_cast<double>(n));
  const double x2 = x * x;
  double term = use_sine ? x : 1.0, sum = term;
  for (int k = use_sine ? 2 : 1; k < 20; k += 2) {
    term = -(term * x2) / static_cast<double>(k * (k + 1));
    sum = sum + term;
  }
  return sign * sum;
}

}  // namespace

Status RingWeights::build(const LevelTopology& base) {
  if (!valence_.assign(base.vertex_count, 0) || !offset_.assign(kMaximumValence + 1, kNone))
    return no_memory();
  weights_.clear();
  for (const std::uint32_t v : base.face_vertices) ++valence_[v];
  for (std::uint32_t v = 0; v < base.vertex_count; ++v) {
    const std::uint32_t n = valence_[v];
    if (offset_[n] != kNone) continue;
    offset_[n] = static_cast<std::uint32_t>(weights_.size());
    if (!weights_.resize(weights_.size() + n + 1)) return no_memory();
    double* s = weights_.data() + offset_[n];
    double sum = 0;
    for (std::uint32_t i = 0; i < n; ++i) {
      if (n == 3) {
        s[i] = i == 0 ? 5.0 / 12 : -1.0 / 12;
      } else if (n == 4) {
        s[i] = i == 0 ? 0.375 : i == 2 ? -0.125 : 0.0;
      } else {
        s[i] =
            ((0.25 + cosine_of_fraction(i, n)) + 0.5 * cosine_of_fraction(2 * i, n)) / static_cast<double>(n);
      }
      sum = sum + s[i];
    }
    s[n] = 1 - sum;
  }
  return find_spokes(base);
}

Status RingWeights::find_spokes(const LevelTopology& base) {
  if (!first_spoke_.assign(base.vertex_count, kNone) || !place_.assign(std::size_t{2} * base.edge_count, 0) ||
      !spokes_.reserve(std::size_t{2} * base.edge_count)) {
    return no_memory();
  }
  spokes_.clear();
  for (std::uint32_t e = 0; e < base.edge_count; ++e) {
    if (!base.is_boundary(e)) continue;
    for (std::uint32_t end = 0; end < 2; ++end) first_spoke_[base.edge_vertices[2 * e + end]] = kOnBoundary;
  }
  for (std::uint32_t half = 0; half < 2 * base.edge_count; ++half) {
    const std::uint32_t v = base.edge_vertices[half];
    if (first_spoke_[v] != kNone) continue;
    first_spoke_[v] = static_cast<std::uint32_t>(spokes_.size());
    std::uint32_t edge = half / 2;
    for (std::uint32_t i = 0; i < valence_[v]; ++i) {
      const std::uint32_t end = base.edge_vertices[2 * edge] == v ? 0u : 1u;
      place_[2 * edge + end] = static_cast<std::uint8_t>(i);
      if (!spokes_.push_back({edge, end})) return no_memory();
      // The face counter-clockwise of the spoke holds it directed away from the vertex: left of an outward
      // edge.
      const std::uint32_t face = base.edge_faces[2 * edge + end];
      edge = base.face_edges[3 * face + previous_corner(side_of(base, edge, face))];
    }
  }
  return ok_status();
}

Vec3 predict_odd_vertex(const LevelTopology& topology, const RingWeights& ring_weights, std::uint32_t edge,
                        Tension tension, const Vec3* x) {
  using namespace butterfly_internal;
  const std::uint32_t a = topology.edge_vertices[2 * edge], b = topology.edge_vertices[2 * edge + 1];
  const Vec3 midpoint = 0.5 * (x[a] + x[b]);
  const double t = tension.share;
  if (t == 0) return midpoint;
  Vec3 correction;  // of the full butterfly, to be added to the midpoint
  if (topology.is_curve(edge)) {
    const std::uint32_t before = curve_continuation(topology, a, edge),
                        after = curve_continuation(topology, b, edge);
    if (before != kNone && after != kNone) {
      correction = 0.0625 * ((x[a] + x[b]) - (x[before] + x[after]));
    } else if (before == kNone && after == kNone) {
      return midpoint;
    } else {
      const std::uint32_t corner = before == kNone ? a : b, inner = before == kNone ? b : a;
      const Vec3& next = x[before == kNone ? after : before];
      correction = 0.125 * (((x[inner] + x[inner]) - x[corner]) - next);
    }
    return midpoint + t * correction;
  }
  const bool extraordinary_a = is_extraordinary(topology, ring_weights, a);
  const bool extraordinary_b = is_extraordinary(topology, ring_weights, b);
  if (!extraordinary_a && !extraordinary_b) {
    Vec3 wings, tips;
    for (int side = 0; side < 2; ++side) {
      const std::uint32_t face = topology.edge_faces[2 * edge + side];
      const std::uint32_t c = topology.opposite_vertex(edge, face);
      tips = tips + x[c];
      const std::uint32_t g = wing(topology, face, b), h = wing(topology, face, a);
      const Vec3 wing_a = g != kNone ? x[g] : (x[a] + x[c]) - x[b];
      const Vec3 wing_b = h != kNone ? x[h] : (x[b] + x[c]) - x[a];
      wings = wings + (wing_a + wing_b);
    }
    correction = 0.0625 * ((tips + tips) - wings);
    return midpoint + t * correction;
  }
  Vec3 rings;
  for (int end = 0; end < 2; ++end) {
    if (!(end == 0 ? extraordinary_a : extraordinary_b)) continue;
    const std::uint32_t v = end == 0 ? a : b;
    const std::uint32_t valence = ring_weights.valence(v);
    const double* s = ring_weights.of_valence(valence);
    Vec3 sum = s[valence] * x[v];
    visit_ring(topology, v, edge, valence,
               [&](std::uint32_t i, std::uint32_t neighbour) { sum = sum + s[i] * x[neighbour]; });
    rings = rings + sum;
  }
  if (extraordinary_a && extraordinary_b) rings = 0.5 * rings;
  return midpoint + t * (rings - midpoint);
}

}  // namespace nmc
