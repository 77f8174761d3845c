// SPDX-License-Identifier: Apache-2.0
#include "encoder/domain/simplify.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "encoder/domain/link_condition.h"
#include "encoder/domain/quadric.h"
#include "encoder/domain/vertex_queue.h"

namespace nmc {
namespace {

using Corner = CornerTable::Corner;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Boundary edges against triangles of the same size.
constexpr double kBoundaryWeight = 10;
/// Pull towards the middle of the edge, relative to the quadric's trace: decides only where planes leave a choice.
constexpr double kMiddleWeight = 1e-5;
/// The same for the edge's length in the cost: short edges of a plane go first.
constexpr double kLengthWeight = 1e-7;
constexpr int kMaximumValence = 16;
/// Faces may turn by at most this in one collapse (cosine of 78 degrees).
constexpr double kMinimumTurnCosine = 0.2;

/// The faces that are left of a table, and the vertices they use.
TriangleMesh compact(const CornerTable& table, const std::vector<Vec3>& positions) {
  TriangleMesh mesh;
  std::vector<std::uint32_t> index(table.real_vertex_count(), CornerTable::kNone);
  for (std::uint32_t f = 0; f < table.real_face_count(); ++f) {
    if (!table.is_live_face(f)) continue;
    Triangle t = table.face(f);
    for (std::uint32_t& v : t) {
      if (index[v] == CornerTable::kNone) {
        index[v] = static_cast<std::uint32_t>(mesh.positions.size());
        mesh.positions.push_back(positions[v]);
      }
      v = index[v];
    }
    mesh.triangles.push_back(t);
  }
  return mesh;
}

class Simplifier {
 public:
  explicit Simplifier(const TriangleMesh& mesh)
      : table_(mesh.vertex_count(), mesh.triangles),
        queue_(table_.real_vertex_count()),
        links_(table_) {
    // Centred and of unit size: the quadrics' constants lose no digits then.
    const BoundingBox box = bounding_box(mesh);
    center_ = box.center();
    scale_ = box.diagonal() > 0 ? box.diagonal() : 1;
    for (const Vec3& p : mesh.positions) positions_.push_back((p - center_) / scale_);
    boundary_.resize(table_.real_vertex_count());
    for (std::uint32_t v = 0; v < boundary_.size(); ++v) {
      if (table_.corner_at(v) == CornerTable::kNone) continue;
      ++live_count_;
      boundary_[v] = table_.is_boundary_vertex(v);
    }
    for (std::uint32_t v = 0; v < boundary_.size(); ++v)
      if (table_.corner_at(v) != CornerTable::kNone) refresh(v);
  }

  void reduce_to(std::size_t vertex_count) {
    while (live_count_ > vertex_count && !queue_.empty()) {
      const std::uint32_t v = queue_.top();
      const Merge merge = best_merge(v, true);
      if (merge.cost == kInfinity) {
        queue_.remove(v);  // comes back when something near it changes
      } else if (merge.cost > queue_.key(v)) {
        queue_.set(v, merge.cost);
        if (queue_.top() == v) apply(merge);
      } else {
        apply(merge);
      }
    }
  }

  TriangleMesh mesh() const {
    std::vector<Vec3> positions(positions_.size());
    for (std::size_t v = 0; v < positions.size(); ++v) positions[v] = center_ + scale_ * positions_[v];
    return compact(table_, positions);
  }

 private:
  struct Merge {
    double cost = kInfinity;
    Corner corner = CornerTable::kNone;  // its vertex goes into the next one
    Vec3 position;                       // of the merged vertex
  };

  bool is_real(Corner c) const { return !table_.is_ghost_face(CornerTable::face_of(c)); }

  void add_face(Corner c, Quadric& sum) const {
    const Vec3& a = positions_[table_.vertex(c)];
    const Vec3& b = positions_[table_.vertex(CornerTable::next(c))];
    const Vec3 doubled = cross(b - a, positions_[table_.vertex(CornerTable::previous(c))] - a);
    const double length = norm(doubled);
    if (length > 0) sum += plane_quadric(doubled / length, a, length * length);
  }
  /// The edge opposite c where it is on the boundary, as a line in the plane of its face.
  void add_boundary(Corner c, Quadric& sum) const {
    if (is_real(c) == is_real(table_.opposite(c))) return;
    const Corner inner = is_real(c) ? c : table_.opposite(c);
    const Vec3& a = positions_[table_.vertex(CornerTable::next(inner))];
    const Vec3& b = positions_[table_.vertex(CornerTable::previous(inner))];
    const Vec3 normal = normalized(cross(b - a, positions_[table_.vertex(inner)] - a), {0, 0, 0});
    const Vec3 across = normalized(cross(b - a, normal), {0, 0, 0});
    const double squared = squared_norm(b - a);
    sum += plane_quadric(across, a, kBoundaryWeight * squared * squared);
  }
  void add_star(std::uint32_t v, std::uint32_t except, Quadric& sum) const {
    const Corner first = table_.corner_at(v);
    Corner c = first;
    do {
      const std::uint32_t after = table_.vertex(CornerTable::next(c)), before = table_.vertex(CornerTable::previous(c));
      if (after != except && before != except) {
        if (is_real(c)) add_face(c, sum);
      }
      if (boundary_[v] && after != except) add_boundary(CornerTable::previous(c), sum);
      c = table_.rotate(c);
    } while (c != first);
  }

  /// vertex(c) into the next one; the two shared faces count once.
  Merge merge_of(Corner c) const {
    const std::uint32_t v = table_.vertex(c), u = table_.vertex(CornerTable::next(c));
    Merge merge;
    if (table_.is_ghost_vertex(u)) return merge;
    const bool along_boundary = is_real(c) != is_real(table_.opposite(CornerTable::previous(c)));
    if (boundary_[v] && !along_boundary) return merge;
    Quadric q;
    add_star(v, CornerTable::kNone, q);
    add_star(u, v, q);
    const Vec3& from = positions_[v];
    const Vec3& to = positions_[u];
    const double trace = q.xx + q.yy + q.zz;
    merge.position = boundary_[u] && !boundary_[v] ? to : lowest(q, 0.5 * (from + to), trace);
    merge.cost = std::max(q(merge.position), 0.0) + kLengthWeight * trace * squared_norm(to - from);
    merge.corner = c;
    return merge;
  }

  static Vec3 lowest(const Quadric& q, const Vec3& middle, double trace) {
    const double pull = kMiddleWeight * trace;
    if (!(pull > 0)) return middle;
    const double a = q.xx + pull, d = q.yy + pull, f = q.zz + pull, b = q.xy, c = q.xz, e = q.yz;
    const Vec3 right = {-(q.xx * middle.x + q.xy * middle.y + q.xz * middle.z + q.x),
                        -(q.xy * middle.x + q.yy * middle.y + q.yz * middle.z + q.y),
                        -(q.xz * middle.x + q.yz * middle.y + q.zz * middle.z + q.z)};
    const Vec3 r0 = {d * f - e * e, c * e - b * f, b * e - c * d};
    const double determinant = a * r0.x + b * r0.y + c * r0.z;
    if (!(determinant > 0)) return middle;
    const Vec3 r1 = {r0.y, a * f - c * c, b * c - a * e}, r2 = {r0.z, r1.z, a * d - b * b};
    return middle + Vec3{dot(r0, right), dot(r1, right), dot(r2, right)} / determinant;
  }

  /// The cheapest merge of v; with `valid` the cheapest that may be done, without it a lower bound.
  Merge best_merge(std::uint32_t v, bool valid) {
    merges_.clear();
    const Corner first = table_.corner_at(v);
    Corner c = first;
    do {
      const Merge merge = merge_of(c);
      if (merge.cost < kInfinity) merges_.push_back(merge);
      c = table_.rotate(c);
    } while (c != first);
    std::sort(merges_.begin(), merges_.end(), [](const Merge& a, const Merge& b) {
      return a.cost != b.cost ? a.cost < b.cost : a.corner < b.corner;
    });
    for (const Merge& merge : merges_)
      if (!valid || is_valid(merge)) return merge;
    return {};
  }

  bool is_valid(const Merge& merge) {
    const Corner c = merge.corner;
    const std::uint32_t v = table_.vertex(c), u = table_.vertex(CornerTable::next(c));
    const std::uint32_t a = table_.vertex(CornerTable::previous(c));
    const std::uint32_t b = table_.vertex(table_.opposite(CornerTable::previous(c)));
    const int merged = table_.valence(v) + table_.valence(u) - 4;
    if (merged < 3 || merged > kMaximumValence) return false;
    for (const std::uint32_t w : {a, b})
      if (!table_.is_ghost_vertex(w) && table_.valence(w) < 4) return false;
    return links_.holds(table_, v, u) && faces_turn_little(v, u, merge.position) && faces_turn_little(u, v, merge.position);
  }

  bool faces_turn_little(std::uint32_t v, std::uint32_t other, const Vec3& target) const {
    const Vec3& source = positions_[v];
    const Corner first = table_.corner_at(v);
    Corner d = first;
    do {
      const std::uint32_t after = table_.vertex(CornerTable::next(d)), before = table_.vertex(CornerTable::previous(d));
      if (is_real(d) && after != other && before != other) {
        const Vec3& p = positions_[after];
        const Vec3& q = positions_[before];
        const Vec3 old_normal = cross(p - source, q - source), new_normal = cross(p - target, q - target);
        const double product = dot(old_normal, new_normal);
        const double lengths = squared_norm(old_normal) * squared_norm(new_normal);
        if (lengths > 0 && (!(product > 0) || product * product < kMinimumTurnCosine * kMinimumTurnCosine * lengths))
          return false;
      }
      d = table_.rotate(d);
    } while (d != first);
    return true;
  }

  void apply(const Merge& merge) {
    const std::uint32_t v = table_.vertex(merge.corner), u = table_.vertex(CornerTable::next(merge.corner));
    table_.collapse(merge.corner);
    --live_count_;
    positions_[u] = merge.position;
    queue_.remove(v);
    refresh(u);
    const Corner first = table_.corner_at(u);
    Corner d = first;
    do {
      const std::uint32_t w = table_.vertex(CornerTable::next(d));
      if (!table_.is_ghost_vertex(w)) refresh(w);
      d = table_.rotate(d);
    } while (d != first);
  }

  void refresh(std::uint32_t v) {
    const double cost = best_merge(v, false).cost;
    if (cost < kInfinity)
      queue_.set(v, cost);
    else
      queue_.remove(v);
  }

  CornerTable table_;
  VertexQueue queue_;
  std::vector<Vec3> positions_;
  Vec3 center_;
  double scale_ = 1;
  std::vector<std::uint8_t> boundary_;
  LinkCondition links_;
  std::size_t live_count_ = 0;
  std::vector<Merge> merges_;
};

}  // namespace

std::vector<TriangleMesh> simplify(const TriangleMesh& mesh, const std::vector<int>& vertex_counts,
                                   const Progress& progress) {
  std::vector<std::size_t> order(vertex_counts.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return vertex_counts[a] > vertex_counts[b]; });
  std::vector<TriangleMesh> meshes(vertex_counts.size());
  Simplifier simplifier(mesh);
  for (std::size_t i = 0; i < order.size(); ++i) {
    simplifier.reduce_to(static_cast<std::size_t>(std::max(vertex_counts[order[i]], 4)));
    meshes[order[i]] = simplifier.mesh();
    report(progress, "simplify", static_cast<double>(i + 1) / static_cast<double>(order.size()));
  }
  return meshes;
}

TriangleMesh mesh_of_base(const CollapseHistory& history, std::size_t base_index) {
  CornerTable table = history.coarsest;
  for (std::size_t i = history.steps.size(); i > history.base_step_counts[base_index];)
    table.undo_collapse(history.steps[--i]);
  return compact(table, history.surface->positions);
}

}  // namespace nmc
