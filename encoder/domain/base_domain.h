// SPDX-License-Identifier: Apache-2.0
// The base domain: the base mesh seen as unit equilateral triangles glued along their edges (a flat cone
// metric).
//
// Every face has a chart. Its coordinates are the *lattice* coordinates (u, v) of the basis e1 = (1, 0),
// e2 = (1/2, sqrt(3)/2): corner 0 of the face is (0, 0), corner 1 is (1, 0), corner 2 is (0, 1), and the
// barycentric coordinates are (1 - u - v, u, v). In this basis the hinge map from one chart to a neighbouring
// one, a rotation by a multiple of 60 degrees and a translation, has *integer* coefficients. Points of the
// domain are kept on the grid of spacing 2^-48, so a hinge map of a point within 16 units is exact in double
// arithmetic: whether a point lies on an edge or a corner, and which way a triangle turns, does not depend on
// the chart in which one looks.
//
// Based on: Lee, Sweldens, Schroeder, Cowsar, Dobkin, "MAPS" (1998); Khodakovsky, Litke, Schroeder, "Globally
// smooth parameterizations with low distortion" (2003), section 3 (hinge maps).
#ifndef NMC_ENCODER_DOMAIN_BASE_DOMAIN_H_
#define NMC_ENCODER_DOMAIN_BASE_DOMAIN_H_

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "encoder/core/triangle_mesh.h"

namespace nmc {

inline constexpr std::uint32_t kNoFace = 0xffffffffu;
inline constexpr std::uint32_t kNoVertex = 0xffffffffu;

/// A point or vector in the lattice coordinates of some chart. Affine operations (midpoint, interpolation,
/// orientation) work on (u, v) directly; lengths need squared_length().
struct ChartPoint {
  double u = 0, v = 0;
  bool operator==(const ChartPoint&) const = default;
};
inline ChartPoint operator+(const ChartPoint& a, const ChartPoint& b) { return {a.u + b.u, a.v + b.v}; }
inline ChartPoint operator-(const ChartPoint& a, const ChartPoint& b) { return {a.u - b.u, a.v - b.v}; }
inline ChartPoint operator*(double s, const ChartPoint& a) { return {s * a.u, s * a.v}; }

/// Cartesian coordinates (x, y) of a lattice point; base edges have length 1.
inline std::array<double, 2> to_cartesian(const ChartPoint& a) {
  return {a.u + 0.5 * a.v, 0.86602540378443864676 * a.v};
}
inline ChartPoint from_cartesian(double x, double y) {
  const double v = y * 1.15470053837925152902;
  return {x - 0.5 * v, v};
}
/// Squared Euclidean length of a vector of lattice coordinates.
inline double squared_length(const ChartPoint& a) { return (a.u * a.u + a.u * a.v) + a.v * a.v; }

/// Twice the signed area of (a, b, c) in units of a *base face's doubled area*: 1 for the face itself,
/// positive when counter-clockwise. Rounded; the exact sign is orientation() in exact_orientation.h.
inline double face_ratio(const ChartPoint& a, const ChartPoint& b, const ChartPoint& c) {
  return (b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u);
}

/// The nearest point of the 2^-48 grid. Requires |u|, |v| < 8.
inline ChartPoint snap_to_grid(const ChartPoint& a) {
  // 24 + x lies in [16, 32), where neighbouring doubles are 2^-48 apart.
  constexpr double kShift = 24.0;
  return {(a.u + kShift) - kShift, (a.v + kShift) - kShift};
}

/// A point of the domain: a face and lattice coordinates in its chart, u >= 0, v >= 0, u + v <= 1, on the
/// grid. A point on an edge or at a corner may be named by any of its faces.
struct DomainPoint {
  std::uint32_t face = kNoFace;
  ChartPoint at;
  std::array<double, 3> barycentric() const { return {(1.0 - at.u) - at.v, at.u, at.v}; }
};

/// An orientation-preserving isometry between charts: rotation by `turns` * 60 degrees, then the integer
/// translation.
struct ChartMap {
  std::int8_t turns = 0;  // 0..5
  std::int8_t hops = 0;   // faces crossed
  std::int16_t tu = 0, tv = 0;

  ChartPoint rotate(const ChartPoint& p) const {
    switch (turns) {
      case 1:
        return {-p.v, p.u + p.v};
      case 2:
        return {-p.u - p.v, p.u};
      case 3:
        return {-p.u, -p.v};
      case 4:
        return {p.v, -p.u - p.v};
      case 5:
        return {p.u + p.v, -p.u};
      default:
        return p;
    }
  }
  ChartPoint operator()(const ChartPoint& p) const {
    const ChartPoint q = rotate(p);
    return {q.u + tu, q.v + tv};
  }
};

/// a after b.
ChartMap compose(const ChartMap& a, const ChartMap& b);
ChartMap inverse(const ChartMap& a);

/// Three points (the corners of a triangle) in the chart of one face.
struct ChartTriangle {
  std::uint32_t face = kNoFace;
  std::array<ChartPoint, 3> corners;
};

enum class EdgeTag : std::uint8_t { kSmooth, kCrease, kBoundary };

/// The lattice coordinates of corner k of any face.
inline constexpr std::array<ChartPoint, 3> kFaceCorners = {ChartPoint{0, 0}, ChartPoint{1, 0},
                                                           ChartPoint{0, 1}};

/// Immutable after construction; every query may run concurrently. Faces form an oriented 2-manifold
/// simplicial complex with or without boundary, any genus, any number of components.
///
/// Edge k of a face is the one opposite its corner k, from corner k+1 to corner k+2.
class BaseDomain {
 public:
  BaseDomain() = default;

  /// `faces` index `vertex_count` base vertices; `crease_edges` are pairs of base vertices that carry a
  /// crease. Throws Error (kInternal) where the faces are not an oriented manifold. O(faces * 60) time and 12
  /// bytes for each of these entries (the neighbourhood tables).
  BaseDomain(std::size_t vertex_count, std::vector<Triangle> faces,
             const std::vector<std::array<std::uint32_t, 2>>& crease_edges = {});

  std::size_t vertex_count() const { return vertex_first_.empty() ? 0 : vertex_first_.size() - 1; }
  std::size_t face_count() const { return faces_.size(); }
  const std::vector<Triangle>& faces() const { return faces_; }
  const Triangle& face(std::uint32_t f) const { return faces_[f]; }

  /// The face across edge k, or kNoFace on the boundary.
  std::uint32_t neighbor(std::uint32_t f, int k) const { return neighbors_[f][k]; }
  /// Hinge map from the chart of neighbor(f, k) to the chart of f. Only where there is a neighbour.
  const ChartMap& hinge(std::uint32_t f, int k) const { return hinges_[f][k]; }
  EdgeTag edge_tag(std::uint32_t f, int k) const { return tags_[f][k]; }

  /// The faces around a base vertex in counter-clockwise order; for a boundary vertex the first one is the
  /// one whose clockwise edge is on the boundary. Its size is the cone angle in units of 60 degrees.
  std::span<const std::uint32_t> faces_around(std::uint32_t vertex) const {
    return {ring_.data() + vertex_first_[vertex], ring_.data() + vertex_first_[vertex + 1]};
  }
  bool is_boundary_vertex(std::uint32_t vertex) const { return boundary_vertex_[vertex] != 0; }
  /// The corner of `f` at which `vertex` sits, or -1.
  int corner_of(std::uint32_t f, std::uint32_t vertex) const {
    for (int k = 0; k < 3; ++k)
      if (faces_[f][k] == vertex) return k;
    return -1;
  }
  /// The base vertex at which a point sits exactly, or kNoVertex.
  std::uint32_t cone_at(const DomainPoint& p) const;
  /// A domain point at a base vertex (in the first of faces_around).
  DomainPoint cone_point(std::uint32_t vertex) const;
  /// Number of connected components, and the component of a face.
  std::size_t component_count() const { return component_count_; }
  std::uint32_t component(std::uint32_t f) const { return component_[f]; }

  /// How many faces a shortest dual path may cross in unfold(): enough for triangles that span the
  /// neighbourhoods of two base vertices.
  static constexpr int kUnfoldHops = 5;

  /// The map from the chart of `from` to the chart of `to` along the shortest dual path (ties: the path found
  /// first by a breadth-first search that takes edges 0, 1, 2 in order), or nullptr beyond kUnfoldHops. O(log
  /// 60).
  const ChartMap* find_map(std::uint32_t from, std::uint32_t to) const;

  /// The faces within kUnfoldHops of `f`, ascending, and the maps from their charts to the chart of `f`.
  std::span<const std::uint32_t> nearby_faces(std::uint32_t f) const {
    return {near_face_.data() + near_first_[f], near_face_.data() + near_first_[f + 1]};
  }
  std::span<const ChartMap> nearby_maps(std::uint32_t f) const {
    return {near_map_.data() + near_first_[f], near_map_.data() + near_first_[f + 1]};
  }

  /// Coordinates of `p` in the chart of `f`, which may lie outside the face. A point at a cone is taken from
  /// that face around the cone that is nearest to `f`. `hops` (optional) receives the number of faces
  /// crossed. Exact on grid points. nullopt where `p` is further than kUnfoldHops away.
  std::optional<ChartPoint> unfold(const DomainPoint& p, std::uint32_t f, int* hops = nullptr) const;

  /// The point that has coordinates `p` in the chart of `f`: walks across edges while outside, stops at the
  /// boundary by clamping to the boundary edge, snaps to the grid. Near a cone the walk turns the way of the
  /// most negative barycentric coordinate.
  DomainPoint normalize(std::uint32_t f, const ChartPoint& p) const;

  /// Like normalize(), but along the straight segment from `start` (a point of face f that is not a cone) to
  /// `target`, both in the chart of f, so that cones beside the segment are passed on the right side.
  /// `to_start` receives the map from the chart of the result's face to the chart of f.
  DomainPoint walk(std::uint32_t f, const ChartPoint& start, const ChartPoint& target,
                   ChartMap* to_start) const;

  /// The face whose chart sees all points with the fewest hops in total (ties: the lowest position in
  /// `points`, then the ring order around a cone), or kNoFace. Cones are seen from the side of the other
  /// points, so a triangle with a corner at a cone unfolds on its own side of it. O(points^2).
  std::uint32_t common_chart(std::span<const DomainPoint> points) const;

  /// common_chart() and unfold() of three points; nullopt where they span too many faces. For triangles of a
  /// parameterized surface use Parameterization::unfold, which knows on which side of a cone a triangle lies.
  std::optional<ChartTriangle> unfold_triangle(const DomainPoint& a, const DomainPoint& b,
                                               const DomainPoint& c) const;

 private:
  /// The side of face `from` that leads to face `to` through side `side` of the latter.
  int side_towards(std::uint32_t from, std::uint32_t to, int side) const;
  /// Drops negative barycentric coordinates and keeps the proportion of the others.
  static DomainPoint clamp_to_face(std::uint32_t f, ChartPoint at);
  void connect(std::size_t vertex_count, const std::vector<std::array<std::uint32_t, 2>>& crease_edges);
  void build_rings(std::size_t vertex_count);
  void label_components();
  void build_neighborhoods();

  std::vector<Triangle> faces_;
  std::vector<std::array<std::uint32_t, 3>> neighbors_;
  std::vector<std::array<ChartMap, 3>> hinges_;
  std::vector<std::array<EdgeTag, 3>> tags_;
  std::vector<std::uint32_t> vertex_first_, ring_;
  std::vector<std::uint8_t> boundary_vertex_;
  std::vector<std::uint32_t> component_;
  std::size_t component_count_ = 0;
  std::vector<std::size_t> near_first_;
  std::vector<std::uint32_t> near_face_;
  std::vector<ChartMap> near_map_;
};

}  // namespace nmc

#endif  // NMC_ENCODER_DOMAIN_BASE_DOMAIN_H_
