// SPDX-License-Identifier: Apache-2.0
#include "libnmc/common/subdivision.h"

#include <algorithm>
#include <initializer_list>

namespace nmc {

namespace {

/// The ends of the edge opposite to the corner `slot` = 3 * face + corner, directed as in the face.
struct DirectedEdge {
  DirectedEdge(const Array<std::uint32_t>& corners, std::uint32_t slot)
      : start(corners[slot - slot % 3 + (slot + 1) % 3]), end(corners[slot - slot % 3 + (slot + 2) % 3]) {}
  std::uint32_t low() const { return std::min(start, end); }
  std::uint32_t high() const { return std::max(start, end); }

  std::uint32_t start, end;
};

/// Numbers the edges of level 0 by first visit and finds the face on their other side.
NMC_SELDOM Status number_base_edges(LevelTopology& topology, Memory* memory) {
  const std::uint32_t slot_count = 3 * topology.face_count;
  const Array<std::uint32_t>& corners = topology.face_vertices;
  // Slots in order of the lower end of their edge, then of the higher one, then of the slot: two passes of a
  // sort by counting, which keeps the order of equals. `begin[v]` is where the next slot of v goes.
  Array<std::uint32_t> begin(memory), unsorted(memory), sorted(memory);
  if (!unsorted.resize(slot_count) || !sorted.resize(slot_count)) return no_memory();
  for (std::uint32_t slot = 0; slot < slot_count; ++slot) sorted[slot] = slot;
  for (const bool by_low : {false, true}) {
    const auto key = [&](std::uint32_t slot) {
      const DirectedEdge edge(corners, slot);
      return by_low ? edge.low() : edge.high();
    };
    unsorted.swap(sorted);
    if (!begin.assign(std::size_t{topology.vertex_count} + 1, 0)) return no_memory();
    for (const std::uint32_t slot : unsorted) ++begin[key(slot) + 1];
    for (std::uint32_t v = 0; v < topology.vertex_count; ++v) begin[v + 1] += begin[v];
    for (const std::uint32_t slot : unsorted) sorted[begin[key(slot)]++] = slot;
  }
  Array<std::uint32_t> partner(memory);  // the slot of the same edge in the other face
  if (!partner.assign(slot_count, kNone)) return no_memory();
  for (std::uint32_t i = 0; i < slot_count;) {
    std::uint32_t end = i + 1;
    const DirectedEdge edge(corners, sorted[i]);
    const auto is_same = [&](const DirectedEdge& other) {
      return other.low() == edge.low() && other.high() == edge.high();
    };
    while (end < slot_count && is_same(DirectedEdge(corners, sorted[end]))) ++end;
    NMC_CHECK_STREAM(end - i <= 2, "4.4", "an edge of the base mesh has more than two faces");
    if (end - i == 2) {
      const std::uint32_t s = sorted[i], t = sorted[i + 1];
      NMC_CHECK_STREAM(edge.start != DirectedEdge(corners, t).start, "4.4",
                       "two faces of the base mesh disagree in orientation");
      partner[s] = t;
      partner[t] = s;
    }
    i = end;
  }
  if (!topology.face_edges.assign(slot_count, kNone)) return no_memory();
  topology.edge_vertices.clear();
  topology.edge_faces.clear();
  std::uint32_t edge_count = 0;
  for (std::uint32_t slot = 0; slot < slot_count; ++slot) {
    if (topology.face_edges[slot] != kNone) continue;
    const std::uint32_t other = partner[slot];
    const DirectedEdge edge(corners, slot);
    topology.face_edges[slot] = edge_count;
    if (other != kNone) topology.face_edges[other] = edge_count;
    if (!topology.edge_vertices.push_back(edge.start) || !topology.edge_vertices.push_back(edge.end) ||
        !topology.edge_faces.push_back(slot / 3) ||
        !topology.edge_faces.push_back(other == kNone ? kNone : other / 3)) {
      return no_memory();
    }
    ++edge_count;
  }
  topology.edge_count = edge_count;
  return ok_status();
}

/// One umbrella per vertex: walking from one face around the vertex must meet all of its faces.
NMC_SELDOM Status check_umbrellas(const LevelTopology& topology, Memory* memory) {
  Array<std::uint32_t> valence(memory), first_face(memory);
  if (!valence.resize(topology.vertex_count) || !first_face.assign(topology.vertex_count, kNone)) {
    return no_memory();
  }
  for (std::uint32_t face = 0; face < topology.face_count; ++face) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t v = topology.face_vertices[3 * face + k];
      ++valence[v];
      if (first_face[v] == kNone) first_face[v] = face;
    }
  }
  for (std::uint32_t v = 0; v < topology.vertex_count; ++v) {
    NMC_CHECK_STREAM(valence[v] > 0, "4.4", "a vertex of the base mesh has no face");
    NMC_CHECK_STREAM(valence[v] <= kMaximumValence, "8", "a vertex of the base mesh has too many faces");
    std::uint32_t seen = 0;
    // Two walks, over the edge after and the edge before the corner; a closed umbrella ends within the first.
    for (int turn = 1; turn <= 2; ++turn) {
      std::uint32_t face = first_face[v];
      while (true) {
        if (turn == 1 || face != first_face[v]) ++seen;
        if (seen > valence[v]) break;
        const std::uint32_t* corners = topology.face_vertices.data() + std::size_t{3} * face;
        const int k = corners[0] == v ? 0 : corners[1] == v ? 1 : 2;
        const std::uint32_t edge = topology.face_edges[3 * face + (k + turn) % 3];
        const std::uint32_t left = topology.edge_faces[2 * edge], right = topology.edge_faces[2 * edge + 1];
        face = left == face ? right : left;
        if (face == kNone || face == first_face[v]) break;
      }
      if (face == first_face[v]) break;
    }
    NMC_CHECK_STREAM(seen == valence[v], "4.4",
                     "the faces around a vertex of the base mesh are not connected");
  }
  return ok_status();
}

void add_curve_edge(std::uint32_t vertex, std::uint32_t edge, LevelTopology& topology) {
  std::uint32_t* slots = topology.vertex_curve_edges.data() + std::size_t{2} * vertex;
  if (slots[0] == kNone)
    slots[0] = edge;
  else if (slots[1] == kNone)
    slots[1] = edge;
  else
    slots[1] = slots[0];
}

}  // namespace

NMC_SELDOM Status build_base_topology(const std::uint32_t* face_vertices, std::uint32_t face_count,
                                      std::uint32_t vertex_count, Memory* memory, LevelTopology& topology) {
  if (face_count > kNone / 4 || vertex_count > kNone / 4) {
    return NMC_ERROR(kLimit, "8", "the base mesh is too large");
  }
  topology.vertex_count = vertex_count;
  topology.base_vertex_count = vertex_count;
  topology.level = 0;
  topology.face_count = face_count;
  if (!topology.face_vertices.resize(std::size_t{3} * face_count)) return no_memory();
  for (std::uint32_t face = 0; face < face_count; ++face) {
    const std::uint32_t* v = face_vertices + std::size_t{3} * face;
    NMC_CHECK_STREAM(v[0] < vertex_count && v[1] < vertex_count && v[2] < vertex_count, "4.4",
                     "a face of the base mesh names a vertex that does not exist");
    NMC_CHECK_STREAM(v[0] != v[1] && v[1] != v[2] && v[2] != v[0], "4.4",
                     "a face of the base mesh has two equal corners");
    for (int k = 0; k < 3; ++k) topology.face_vertices[3 * face + k] = v[k];
  }
  NMC_TRY(number_base_edges(topology, memory));
  NMC_TRY(check_umbrellas(topology, memory));
  return set_creases(nullptr, topology);
}

NMC_SELDOM void LevelTopology::set_memory(Memory* memory) {
  for (Array<std::uint32_t>* array : {&face_vertices, &face_edges, &edge_vertices, &edge_faces, &vertex_curve_edges})
    array->set_memory(memory);
  edge_is_curve.set_memory(memory);
}

NMC_SELDOM Status set_creases(const std::uint8_t* is_crease, LevelTopology& topology) {
  bool any = false;
  for (std::uint32_t e = 0; e < topology.edge_count && !any; ++e)
    any = topology.is_boundary(e) || (is_crease && is_crease[e]);
  topology.edge_is_curve.clear();
  topology.vertex_curve_edges.clear();
  if (!any) return ok_status();
  if (!topology.edge_is_curve.resize(topology.edge_count) ||
      !topology.vertex_curve_edges.assign(std::size_t{2} * topology.vertex_count, kNone)) {
    return no_memory();
  }
  for (std::uint32_t e = 0; e < topology.edge_count; ++e) {
    if (!topology.is_boundary(e) && !(is_crease && is_crease[e])) continue;
    topology.edge_is_curve[e] = 1;
    add_curve_edge(topology.edge_vertices[2 * e], e, topology);
    add_curve_edge(topology.edge_vertices[2 * e + 1], e, topology);
  }
  return ok_status();
}

namespace {

/// Value by value: an array that is copied at once would be written in small pieces and read back in large
/// ones, which processors wait for.
template <class... Values>
void store_12(std::uint32_t* to, Values... values) {
  static_assert(sizeof...(values) == 12);
  ((*to++ = values), ...);
}

}  // namespace

void split_faces(const LevelTopology& coarse, std::uint32_t* fine_face_vertices) {
  for (std::uint32_t f = 0; f < coarse.face_count; ++f) {
    const std::uint32_t* v = coarse.face_vertices.data() + std::size_t{3} * f;
    const std::uint32_t* e = coarse.face_edges.data() + std::size_t{3} * f;
    const std::uint32_t m0 = coarse.vertex_count + e[0], m1 = coarse.vertex_count + e[1],
                        m2 = coarse.vertex_count + e[2];
    store_12(fine_face_vertices + std::size_t{12} * f, v[0], m2, m1, m2, v[1], m0, m1, m0, v[2], m0, m1, m2);
  }
}

Status subdivide(const LevelTopology& coarse, bool faces_only, LevelTopology& fine) {
  const std::uint32_t V = coarse.vertex_count, E = coarse.edge_count, F = coarse.face_count;
  if (F > kNone / 16 || E > kNone / 16 || V > kNone / 2 - E) {
    return NMC_ERROR(kLimit, "8", "the level has too many vertices");
  }
  fine.vertex_count = V + E;
  fine.edge_count = 2 * E + 3 * F;
  fine.face_count = 4 * F;
  fine.base_vertex_count = coarse.base_vertex_count;
  fine.level = coarse.level + 1;
  if (!fine.face_vertices.resize_unset(std::size_t{12} * F)) return no_memory();
  split_faces(coarse, fine.face_vertices.data());
  if (faces_only) return ok_status();

  if (!fine.face_edges.resize_unset(std::size_t{12} * F) ||
      !fine.edge_vertices.resize_unset(std::size_t{2} * fine.edge_count) ||
      !fine.edge_faces.resize_unset(std::size_t{2} * fine.edge_count)) {
    return no_memory();
  }
  for (std::uint32_t e = 0; e < E; ++e) {
    const std::uint32_t a = coarse.edge_vertices[2 * e], b = coarse.edge_vertices[2 * e + 1], m = V + e;
    std::uint32_t* vertices = fine.edge_vertices.data() + std::size_t{4} * e;
    vertices[0] = a;
    vertices[1] = m;
    vertices[2] = m;
    vertices[3] = b;
    std::uint32_t* faces = fine.edge_faces.data() + std::size_t{4} * e;
    for (int side = 0; side < 2; ++side) {
      const std::uint32_t f = coarse.edge_faces[2 * e + side];
      for (int half = 0; half < 2; ++half) {
        std::uint32_t child = kNone;
        if (f != kNone) {
          const std::uint32_t* v = coarse.face_vertices.data() + std::size_t{3} * f;
          const std::uint32_t end = half == 0 ? a : b;
          child = 4 * f + (v[0] == end ? 0u : v[1] == end ? 1u : 2u);
        }
        faces[2 * half + side] = child;
      }
    }
  }
  for (std::uint32_t f = 0; f < F; ++f) {
    const std::uint32_t* v = coarse.face_vertices.data() + std::size_t{3} * f;
    const std::uint32_t* e = coarse.face_edges.data() + std::size_t{3} * f;
    std::uint32_t inner[3],
        half[3][2];  // half[k][0]: the half of edge k at corner k+1, half[k][1]: at corner k+2
    for (std::uint32_t k = 0; k < 3; ++k) {
      inner[k] = 2 * E + 3 * f + k;
      fine.edge_vertices[2 * inner[k]] = V + e[(k + 1) % 3];
      fine.edge_vertices[2 * inner[k] + 1] = V + e[(k + 2) % 3];
      fine.edge_faces[2 * inner[k]] = 4 * f + 3;
      fine.edge_faces[2 * inner[k] + 1] = 4 * f + k;
      const std::uint32_t flipped = coarse.edge_vertices[2 * e[k]] == v[(k + 1) % 3] ? 0u : 1u;
      half[k][0] = 2 * e[k] + flipped;
      half[k][1] = 2 * e[k] + 1 - flipped;
    }
    // Child k has, opposite to its corners 0..2 as listed at the top of subdivision.h:
    store_12(fine.face_edges.data() + std::size_t{12} * f,  //
             inner[0], half[1][1], half[2][0],              //  4f+0: (v0, m2, m1)
             half[0][0], inner[1], half[2][1],              //  4f+1: (m2, v1, m0)
             half[0][1], half[1][0], inner[2],              //  4f+2: (m1, m0, v2)
             inner[0], inner[1], inner[2]);                 //  4f+3: (m0, m1, m2)
  }

  fine.edge_is_curve.clear();
  fine.vertex_curve_edges.clear();
  if (!coarse.has_curves()) return ok_status();
  if (!fine.edge_is_curve.resize(fine.edge_count) ||
      !fine.vertex_curve_edges.assign(std::size_t{2} * fine.vertex_count, kNone)) {
    return no_memory();
  }
  for (std::uint32_t e = 0; e < E; ++e) {
    if (!coarse.edge_is_curve[e]) continue;
    fine.edge_is_curve[2 * e] = fine.edge_is_curve[2 * e + 1] = 1;
    fine.vertex_curve_edges[2 * (V + e)] = 2 * e;
    fine.vertex_curve_edges[2 * (V + e) + 1] = 2 * e + 1;
  }
  for (std::uint32_t v = 0; v < V; ++v) {
    for (int k = 0; k < 2; ++k) {
      const std::uint32_t e = coarse.vertex_curve_edges[2 * v + k];
      if (e != kNone)
        fine.vertex_curve_edges[2 * v + k] = 2 * e + (coarse.edge_vertices[2 * e] == v ? 0u : 1u);
    }
  }
  return ok_status();
}

}  // namespace nmc
