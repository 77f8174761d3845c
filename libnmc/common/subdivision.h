// SPDX-License-Identifier: Apache-2.0
// Connectivity of a semi-regular mesh, level by level (spec 6.1).
//
// Level 0 is the base mesh. One step splits each triangle into four and numbers everything without a search,
// so that a decoder needs no hash table and two implementations cannot disagree:
//
//          v2                 vertex of edge e          V + e
//          /\                 face f  ->  4f+0  (v0, m2, m1)
//         / 2\                            4f+1  (m2, v1, m0)      m_k lies on the edge opposite to corner k
//     m1 /____\ m0                        4f+2  (m1, m0, v2)
//       /\ 3  /\                          4f+3  (m0, m1, m2)
//      / 0\  /1 \             edge e = (a, b), odd vertex m  ->  2e (a, m),  2e+1 (m, b)
//  v0 /____\/____\ v1         inside face f  ->  2E + 3f + k = (m_k+1, m_k+2), parallel to the edge opposite
//  to
//          m2                                    corner k; its left face is 4f+3, its right face 4f+k
#ifndef NMC_COMMON_SUBDIVISION_H_
#define NMC_COMMON_SUBDIVISION_H_

#include <cstdint>

#include "libnmc/common/memory.h"
#include "libnmc/common/status.h"

namespace nmc {

inline constexpr std::uint32_t kNone = 0xffffffffu;
/// Largest number of faces around a vertex of the base mesh (spec 8): bounds the work of the stencils.
inline constexpr std::uint32_t kMaximumValence = 256;

/// Connectivity of one level. An edge is directed: its left face holds it as (first vertex, second vertex) in
/// counter-clockwise order and always exists; its right face is kNone on a boundary.
struct LevelTopology {
  explicit LevelTopology(Memory* memory = nullptr) { set_memory(memory); }
  /// Only before anything is built.
  void set_memory(Memory* memory);

  std::uint32_t vertex_count = 0;
  std::uint32_t edge_count = 0;
  std::uint32_t face_count = 0;
  std::uint32_t level = 0;              // splits since the base mesh
  std::uint32_t base_vertex_count = 0;  // the vertices below it come from the base mesh; others are regular
  Array<std::uint32_t> face_vertices;   // 3 per face
  Array<std::uint32_t> face_edges;      // 3 per face: the edge opposite to the corner
  Array<std::uint32_t> edge_vertices;   // 2 per edge
  Array<std::uint32_t> edge_faces;      // 2 per edge: left, right
  /// Curve edges are boundary edges and creases. Both arrays are empty when the base mesh has none.
  Array<std::uint8_t> edge_is_curve;        // 1 per edge
  Array<std::uint32_t> vertex_curve_edges;  // 2 per vertex: its curve edges; see curve_degree()

  bool has_curves() const { return !edge_is_curve.empty(); }
  bool is_boundary(std::uint32_t edge) const { return edge_faces[2 * edge + 1] == kNone; }
  bool is_curve(std::uint32_t edge) const { return has_curves() && edge_is_curve[edge] != 0; }
  /// Number of curve edges at a vertex, 3 standing for three and more. The two entries of vertex_curve_edges
  /// are kNone when unused; both hold the same edge when there are three or more.
  int curve_degree(std::uint32_t vertex) const {
    if (!has_curves()) return 0;
    const std::uint32_t first = vertex_curve_edges[2 * vertex], second = vertex_curve_edges[2 * vertex + 1];
    if (first == kNone) return 0;
    if (second == kNone) return 1;
    return first == second ? 3 : 2;
  }
  /// The face on the other side of `edge`, or kNone. The edge must belong to `face`.
  std::uint32_t face_across(std::uint32_t edge, std::uint32_t face) const {
    return edge_faces[2 * edge] ^ edge_faces[2 * edge + 1] ^ face;
  }
  /// The corner of `face` that is not on `edge`. The edge must belong to the face.
  std::uint32_t opposite_vertex(std::uint32_t edge, std::uint32_t face) const {
    const std::uint32_t* v = face_vertices.data() + std::size_t{3} * face;
    return v[0] ^ v[1] ^ v[2] ^ edge_vertices[2 * edge] ^ edge_vertices[2 * edge + 1];
  }
};

/// Builds level 0 from `face_count` triangles. Edges are numbered by first visit: faces in order, corners 0,
/// 1, 2, the edge opposite to the corner. Fails with kCorrupt unless the mesh is an oriented 2-manifold with
/// or without boundary: indices in range, no face with two equal corners, no directed edge twice, one
/// umbrella per vertex, every vertex used, valence <= kMaximumValence. O(faces log faces) time.
Status build_base_topology(const std::uint32_t* face_vertices, std::uint32_t face_count,
                           std::uint32_t vertex_count, Memory* memory, LevelTopology& topology);

/// Marks base edges as creases (spec 4.5): `is_crease` holds one byte per edge of level 0. Boundary edges are
/// curve edges in any case. Call before the first split.
Status set_creases(const std::uint8_t* is_crease, LevelTopology& base_topology);

/// The corners of the 4 * face_count faces of the next finer level, 12 indices per face of `coarse`.
void split_faces(const LevelTopology& coarse, std::uint32_t* fine_face_vertices);

/// The next finer level. With `faces_only` only face_vertices and the counts are filled: all that a finest
/// level needs. Fails with kNoMemory, or with kLimit when a count would not fit 32 bits.
Status subdivide(const LevelTopology& coarse, bool faces_only, LevelTopology& fine);

}  // namespace nmc

#endif  // NMC_COMMON_SUBDIVISION_H_
