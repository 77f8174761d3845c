// SPDX-License-Identifier: Apache-2.0
#include "encoder/pipeline/place_settling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "encoder/core/parallel.h"
#include "encoder/spatial/triangle_geometry.h"
#include "libnmc/common/local_frame.h"

namespace nmc {

namespace {

/// A little inside the tolerance, as only points are tested and not all that lies between them.
constexpr double kInside = 0.98;
/// Points of the input are held by the faces around the places up to this many tolerances, or the longest move.
constexpr double kReach = 2;
constexpr int kLongestChange = 64;  // steps
constexpr int kSweeps = 3;         // over the vertices around one place
constexpr int kPointsAlongEdge = 8;

/// Small changes one by one, large ones in growing strides.
int next_length(int steps) { return steps + std::max(1, steps / 3); }

struct Change {
  int normal = 0, along = 0, across = 0;
};

}  // namespace

/// The faces around the places, the points that they hold, and the integers that move them.
class PlaceSettling::Neighbourhood {
 public:
  Neighbourhood(const PlaceSettling& settling, const std::vector<Place>& places, const SurfaceIndex& surface,
                std::vector<Vec3>& positions, QuantizedMesh& mesh)
      : settling_(settling),
        positions_(positions),
        mesh_(mesh),
        topology_(settling.hierarchy_.level(mesh.level_count() - 1)),
        quantizer_(mesh.quantizers.back()) {
    std::vector<std::uint32_t> faces;
    for (const Place& place : places) {
      for (const std::uint32_t corner : settling_.faces_[place.at.triangle])
        append_second_ring(corner, faces);
    }
    sort_unique(faces);
    double reach = kReach * settling.tolerance_;
    for (const Place& place : places) reach = std::max(reach, 1.01 * norm(place.move));
    hold_points(faces, surface, reach);
    for (const Place& place : places) places_.push_back(&place);
    std::stable_sort(places_.begin(), places_.end(),
                     [](const Place* a, const Place* b) { return a->at.triangle < b->at.triangle; });
  }

  bool is_of_last_level(std::uint32_t vertex) const { return vertex >= topology_.vertex_count; }

  /// What lies beyond the tolerance around a vertex: sum of squared excesses, in tolerances.
  double excess_around(std::uint32_t vertex) {
    rings_of(vertex);
    return excess_of_rings(std::numeric_limits<double>::infinity());
  }

  /// The best change of one vertex of the last level, `longest` steps at most. True where there was one; `excess` is
  /// that around the vertex before and after.
  bool improve(std::uint32_t vertex, int longest, double& excess) {
    rings_of(vertex);
    const double before = excess_of_rings(std::numeric_limits<double>::infinity());
    excess = before;
    if (before == 0) return false;
    const std::uint32_t edge = vertex - topology_.vertex_count;
    const LocalFrame frame = odd_vertex_frame(topology_, edge, positions_.data());
    const Vec3 start = positions_[vertex];
    Change best;
    /// Whether the change is the best so far.
    const auto attempt = [&](const Change& change) {
      positions_[vertex] = start + (change.normal * quantizer_.normal_step) * frame.normal +
                           (change.along * quantizer_.tangential_step) * frame.along +
                           (change.across * quantizer_.tangential_step) * frame.across;
      const double now = excess_of_rings(excess);
      if (now >= excess * (1 - 1e-6)) return false;
      excess = now;
      best = change;
      return true;
    };
    for (const int sign : {1, -1})
      for (int steps = 1; steps <= longest && excess > 0; steps = next_length(steps))
        if (!attempt({sign * steps, 0, 0})) break;
    // Bits of a tangential part are many: only where the normal does not point there.
    const int normal = best.normal;
    for (const std::array<int, 2> part : {std::array<int, 2>{1, 0}, {-1, 0}, {0, 1}, {0, -1}})
      for (int length = 1; length <= longest && excess > 0; length = next_length(length))
        if (!attempt({normal, length * part[0], length * part[1]})) break;
    positions_[vertex] = start + (best.normal * quantizer_.normal_step) * frame.normal +
                         (best.along * quantizer_.tangential_step) * frame.along +
                         (best.across * quantizer_.tangential_step) * frame.across;
    if (excess >= before) return false;
    mesh_.normal.back()[edge] += best.normal;
    change_tangential(edge, best.along, best.across, mesh_.tangential.back());
    return true;
  }

  /// Corners of the faces at a vertex, itself first.
  std::vector<std::uint32_t> ring_vertices(std::uint32_t vertex) const {
    std::vector<std::uint32_t> ring{vertex};
    for_faces_of(vertex, [&](std::uint32_t f) {
      for (const std::uint32_t v : settling_.faces_[f])
        if (std::find(ring.begin(), ring.end(), v) == ring.end()) ring.push_back(v);
    });
    return ring;
  }

 private:
  template <class Body>
  void for_faces_of(std::uint32_t vertex, const Body& body) const {
    for (std::uint32_t i = settling_.first_face_[vertex]; i < settling_.first_face_[vertex + 1]; ++i)
      body(settling_.faces_of_vertex_[i]);
  }

  static void sort_unique(std::vector<std::uint32_t>& list) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }

  void append_second_ring(std::uint32_t vertex, std::vector<std::uint32_t>& faces) const {
    for (const std::uint32_t corner : ring_vertices(vertex))
      for_faces_of(corner, [&](std::uint32_t f) { faces.push_back(f); });
  }

  void hold_points(const std::vector<std::uint32_t>& faces, const SurfaceIndex& surface, double reach) {
    std::vector<Triangle> near;
    near.reserve(faces.size());
    for (const std::uint32_t f : faces) near.push_back(settling_.faces_[f]);
    const SurfaceIndex near_index(positions_, near);
    const std::vector<Vec3>& points = settling_.input_points_;
    std::vector<std::uint32_t> face_of(points.size(), kNoTriangle);
    parallel_for(points.size(), [&](std::size_t i) {
      const SurfacePoint at = near_index.closest_point(points[i], reach);
      // Points that another part of the surface is nearer to are that part's.
      if (at.found() && (at.t == 0 || !surface.is_within(points[i], at.t * (1 - 1e-9))))
        face_of[i] = faces[at.triangle];
    });
    for (std::uint32_t i = 0; i < points.size(); ++i)
      if (face_of[i] != kNoTriangle) held_.push_back({face_of[i], i});
    std::sort(held_.begin(), held_.end(), [](const Held& a, const Held& b) {
      return a.face != b.face ? a.face < b.face : a.point < b.point;
    });
  }

  void rings_of(std::uint32_t vertex) {
    first_ring_.clear();
    for_faces_of(vertex, [&](std::uint32_t f) { first_ring_.push_back(f); });
    second_ring_.clear();
    append_second_ring(vertex, second_ring_);
    sort_unique(second_ring_);
  }

  static double squared_excess(double distance, double tolerance) {
    const double beyond = distance / tolerance - kInside;
    return beyond > 0 ? beyond * beyond : 0;
  }

  /// Of a point of the mesh.
  double excess_of(const Vec3& point) const {
    if (settling_.input_.is_within(point, kInside * settling_.tolerance_)) return 0;
    return squared_excess(settling_.input_.closest_point(point).t, settling_.tolerance_);
  }

  double squared_distance_to(const Vec3& point, std::uint32_t f) const {
    const Triangle& t = settling_.faces_[f];
    return closest_point_on_triangle(point, positions_[t[0]], positions_[t[1]], positions_[t[2]]).squared_distance;
  }

  /// Stops where `limit` is reached.
  double excess_of_rings(double limit) const {
    const double tolerance = settling_.tolerance_, inside = kInside * tolerance;
    double sum = 0;
    for (const std::uint32_t f : second_ring_) {
      for (auto held = std::lower_bound(held_.begin(), held_.end(), f,
                                        [](const Held& h, std::uint32_t face) { return h.face < face; });
           held != held_.end() && held->face == f; ++held) {
        const Vec3& point = settling_.input_points_[held->point];
        double nearest = squared_distance_to(point, f);
        for (std::size_t k = 0; k < second_ring_.size() && nearest > inside * inside; ++k)
          nearest = std::min(nearest, squared_distance_to(point, second_ring_[k]));
        sum += squared_excess(std::sqrt(nearest), tolerance);
      }
      if (sum >= limit) return sum;
    }
    for (const std::uint32_t f : first_ring_) {
      const Triangle& t = settling_.faces_[f];
      const Vec3 &a = positions_[t[0]], &b = positions_[t[1]], &c = positions_[t[2]];
      const double longest = std::max({norm(b - a), norm(c - b), norm(a - c)});
      const double pieces = std::ceil(longest / settling_.spacing_);
      const int n = static_cast<int>(std::clamp(pieces, 1.0, double{kPointsAlongEdge}));
      for (int i = 0; i <= n; ++i) {
        for (int j = 0; i + j <= n; ++j) {
          const double u = static_cast<double>(i) / n, v = static_cast<double>(j) / n;
          sum += excess_of(a + u * (b - a) + v * (c - a));
        }
      }
      // Between these points a place would be overlooked for which all this is done.
      for (auto place = std::lower_bound(places_.begin(), places_.end(), f,
                                         [](const Place* p, std::uint32_t face) { return p->at.triangle < face; });
           place != places_.end() && (*place)->at.triangle == f; ++place) {
        const double* weights = (*place)->at.barycentric;
        sum += excess_of(weights[0] * a + weights[1] * b + weights[2] * c);
      }
      if (sum >= limit) return sum;
    }
    return sum;
  }

  struct Held {
    std::uint32_t face, point;
  };

  const PlaceSettling& settling_;
  std::vector<Vec3>& positions_;
  QuantizedMesh& mesh_;
  const LevelTopology& topology_;
  const LevelQuantizer& quantizer_;
  std::vector<Held> held_;  // points of the input by the face nearest to them
  std::vector<const Place*> places_;  // by face
  std::vector<std::uint32_t> first_ring_, second_ring_;
};

PlaceSettling::PlaceSettling(const SurfaceIndex& input, const std::vector<Vec3>& input_points,
                             const SubdivisionHierarchy& hierarchy, const std::vector<Triangle>& faces,
                             double tolerance, double spacing)
    : input_(input),
      input_points_(input_points),
      hierarchy_(hierarchy),
      faces_(faces),
      tolerance_(tolerance),
      spacing_(spacing),
      first_face_(hierarchy.level(hierarchy.level_count()).vertex_count + 1, 0) {
  for (const Triangle& t : faces_)
    for (const std::uint32_t v : t) ++first_face_[v + 1];
  std::partial_sum(first_face_.begin(), first_face_.end(), first_face_.begin());
  faces_of_vertex_.resize(3 * faces_.size());
  std::vector<std::uint32_t> next(first_face_.begin(), first_face_.end() - 1);
  for (std::uint32_t f = 0; f < faces_.size(); ++f)
    for (const std::uint32_t v : faces_[f]) faces_of_vertex_[next[v]++] = f;
}

std::vector<Place> PlaceSettling::settle(const std::vector<Place>& places, const SurfaceIndex& surface,
                                         std::vector<Vec3>& positions, QuantizedMesh& mesh) const {
  const bool has_integers = mesh.level_count() > 0 && mesh.level_count() == hierarchy_.level_count();
  if (places.empty() || !has_integers) return places;
  Neighbourhood near(*this, places, surface, positions, mesh);
  std::vector<std::uint32_t> order(places.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return squared_norm(places[a].move) > squared_norm(places[b].move);
  });
  std::vector<std::uint8_t> is_left(places.size(), 0);
  for (const std::uint32_t p : order) {
    const Place& place = places[p];
    const Triangle& corners = faces_[place.at.triangle];
    std::array<std::size_t, 3> nearest{0, 1, 2};
    std::sort(nearest.begin(), nearest.end(), [&](std::size_t a, std::size_t b) {
      return place.at.barycentric[a] != place.at.barycentric[b] ? place.at.barycentric[a] > place.at.barycentric[b]
                                                                : a < b;
    });
    const double steps = std::ceil(1.5 * norm(place.move) / mesh.quantizers.back().normal_step);
    const int longest = static_cast<int>(std::clamp(steps, 1.0, double{kLongestChange}));
    const auto is_settled = [&] {
      return std::all_of(corners.begin(), corners.end(), [&](std::uint32_t v) { return near.excess_around(v) == 0; });
    };
    // Where a vertex of a coarser level is itself too far off, its neighbours cannot help.
    const bool is_at_coarser = !near.is_of_last_level(corners[nearest[0]]) && place.at.barycentric[nearest[0]] > 0.5;
    bool settled = is_settled();
    for (int sweep = 0; sweep < kSweeps && !settled; ++sweep) {
      bool moved = false;
      double excess;
      for (const std::size_t k : nearest)
        if (near.is_of_last_level(corners[k])) moved |= near.improve(corners[k], longest, excess);
      settled = is_settled();
      if (settled || is_at_coarser) break;
      if (moved) continue;
      if (sweep > 0) break;
      for (const std::uint32_t v : near.ring_vertices(corners[nearest[0]]))
        if (near.is_of_last_level(v)) moved |= near.improve(v, longest, excess);
      settled = is_settled();
      if (!moved) break;
    }
    is_left[p] = !settled;
  }
  std::vector<Place> left;
  for (std::size_t p = 0; p < places.size(); ++p)
    if (is_left[p]) left.push_back(places[p]);
  return left;
}

}  // namespace nmc
