// SPDX-License-Identifier: Apache-2.0
#include "encoder/domain/maps_collapse.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "encoder/domain/extremities.h"
#include "encoder/domain/link_condition.h"
#include "encoder/domain/quadric.h"
#include "encoder/domain/surface_chains.h"
#include "encoder/domain/vertex_queue.h"

namespace nmc {
namespace {

using Corner = CornerTable::Corner;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Line quadrics hold boundaries and creases; weight relative to a plane quadric of an area of the edge
/// squared.
constexpr double kChainWeight = 10;
constexpr int kMaximumValence = 9;
/// Far from a base two more are allowed. Eleven faces span 660 degrees of the domain: when a vertex splits on
/// the way back, one of the two parts of its ring spans less than 360, and that part's vertex finds room.
constexpr int kLooseValence = 2;
/// Of boundary vertices, in faces including the two ghosts: their faces then span at most 300 degrees of the
/// domain, and a vertex that splits off on the way back finds room.
constexpr int kMaximumBoundaryValence = 7;
/// Faces may turn by at most this between before and after a collapse (cosine of 78 degrees).
constexpr double kMinimumTurnCosine = 0.2;
/// Collapses that make a vertex of valence v multiply their cost by this, so that bases have few of them.
double valence_penalty(int valence) {
  if (valence >= 10) return 64;
  if (valence == 9) return 16;
  if (valence == 8) return 4;
  if (valence == 7) return 1.5;
  if (valence == 4) return 2;
  if (valence == 3) return 16;
  return 1;
}

/// Extremities are sought when this many vertices are left: larger bases keep them by their quadrics alone.
constexpr std::size_t kExtremityLevel = 30000;
/// Bases larger than this need no even valences: hardly any level stands on them. Held all the way down from the
/// surface, a valence of at least four makes poor bases of crumpled surfaces (twice the bytes on a dragon's scales).
constexpr std::size_t kStrictLevel = 3000;

class Collapser {
 public:
  Collapser(CollapseHistory& history, const CollapseOptions& options)
      : history_(history),
        table_(history.coarsest),
        options_(options),
        queue_(history.coarsest.real_vertex_count()),
        links_(history.coarsest) {
    normalize_positions();
    accumulate_quadrics();
    valence_.assign(table_.vertex_slot_count(), 0);
    for (Corner c = 0; c < 3 * table_.face_slot_count(); ++c) ++valence_[table_.vertex(c)];
    for (std::uint32_t v = 0; v < table_.real_vertex_count(); ++v)
      live_count_ += table_.corner_at(v) != kNone;
  }

  void run(const std::vector<int>& base_sizes, const Progress& progress) {
    std::vector<std::size_t> order(base_sizes.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return base_sizes[a] > base_sizes[b]; });
    history_.base_step_counts.assign(base_sizes.size(), 0);
    for (std::uint32_t v = 0; v < table_.real_vertex_count(); ++v)
      if (table_.corner_at(v) != kNone && history_.kinds[v] != VertexKind::kLocked)
        queue_.set(v, hoped_cost(v));
    const std::size_t start_count = live_count_;
    for (const std::size_t index : order) {
      const auto target = static_cast<std::size_t>(std::max(base_sizes[index], 1));
      while (live_count_ > target) {
        strict_ = live_count_ < 2 * target && live_count_ <= kStrictLevel;
        if (!extremities_found_ && live_count_ <= kExtremityLevel) protect_extremities();
        while (protected_count_ > 0 && static_cast<double>(protected_count_) >
                                           options_.extremity_share * static_cast<double>(live_count_)) {
          const std::uint32_t v = extremities_[--protected_count_];
          protected_[v] = 0;
          refresh(v);
        }
        if (!step()) break;
        if (live_count_ % 8192 == 0)
          report(progress, "base mesh",
                 static_cast<double>(start_count - live_count_) / static_cast<double>(start_count));
      }
      history_.base_step_counts[index] = history_.steps.size();
    }
  }

 private:
  static constexpr std::uint32_t kNone = CornerTable::kNone;

  /// Centred on the box and scaled to unit diagonal: the quadrics' constants then lose no digits for scans
  /// that lie far from the origin.
  void normalize_positions() {
    const TriangleMesh& mesh = *history_.surface;
    const BoundingBox box = bounding_box(mesh);
    const double diagonal = box.diagonal();
    const double scale = diagonal > 0 ? 1 / diagonal : 1;
    const Vec3 center = box.center();
    positions_.resize(mesh.vertex_count());
    for (std::size_t v = 0; v < positions_.size(); ++v) positions_[v] = scale * (mesh.positions[v] - center);
  }

  void accumulate_quadrics() {
    quadrics_.assign(positions_.size(), {});
    for (std::uint32_t f = 0; f < table_.real_face_count(); ++f) {
      const Triangle t = table_.face(f);
      const Vec3 doubled = cross(positions_[t[1]] - positions_[t[0]], positions_[t[2]] - positions_[t[0]]);
      const double length = norm(doubled);
      if (!(length > 0)) continue;
      const Vec3 normal = doubled / length;
      const Quadric q = plane_quadric(normal, positions_[t[0]], 0.5 * length);
      for (const std::uint32_t v : t) quadrics_[v] += q;
      for (Corner c = 3 * f; c < 3 * f + 3; ++c) {
        if (!history_.is_chain_edge(table_, c)) continue;
        const std::uint32_t a = table_.vertex(CornerTable::next(c)),
                            b = table_.vertex(CornerTable::previous(c));
        const Vec3 along = positions_[b] - positions_[a];
        const Vec3 across = normalized(cross(along, normal), {0, 0, 0});
        const Quadric line = plane_quadric(across, positions_[a], kChainWeight * squared_norm(along));
        quadrics_[a] += line;
        quadrics_[b] += line;
      }
    }
    own_error_.resize(positions_.size());
    for (std::size_t v = 0; v < positions_.size(); ++v) own_error_[v] = quadrics_[v](positions_[v]);
  }

  /// Cost of merging vertex(c) into vertex(next(c)).
  double cost(Corner c) const {
    const std::uint32_t v = table_.vertex(c), u = table_.vertex(CornerTable::next(c));
    const double error = quadrics_[v](positions_[u]) + own_error_[u];
    const double length = squared_norm(positions_[u] - positions_[v]);
    double penalty = valence_penalty(valence_[u] + valence_[v] - 4);
    const std::uint32_t a = table_.vertex(CornerTable::previous(c));
    const std::uint32_t b = table_.vertex(table_.opposite(CornerTable::previous(c)));
    for (const std::uint32_t w : {a, b})
      if (valence_[w] >= 9 && !table_.is_ghost_vertex(w)) penalty *= 0.25;
    if (valence_[a] <= 5 && !table_.is_ghost_vertex(a)) penalty *= valence_penalty(valence_[a] - 1);
    if (valence_[b] <= 5 && !table_.is_ghost_vertex(b)) penalty *= valence_penalty(valence_[b] - 1);
    return (std::max(error, 0.0) + options_.length_weight * length * length) * penalty;
  }

  void protect_extremities() {
    extremities_found_ = true;
    protected_.assign(table_.real_vertex_count(), 0);
    history_.extremities.assign(table_.real_vertex_count(), 0);
    extremities_ = find_extremities(table_, positions_, options_.extremity_prominence);
    std::erase_if(extremities_, [this](std::uint32_t v) { return history_.kinds[v] != VertexKind::kSmooth; });
    protected_count_ = extremities_.size();
    for (const std::uint32_t v : extremities_) {
      protected_[v] = 1;
      history_.extremities[v] = 1;
      queue_.set(v, kInfinity);
    }
  }

  /// What does not depend on geometry and is cheap: may vertex(c) go to vertex(next(c)) at all?
  bool kind_allows(Corner c) const {
    const std::uint32_t v = table_.vertex(c), u = table_.vertex(CornerTable::next(c));
    if (table_.is_ghost_vertex(u)) return false;
    if (history_.kinds[v] == VertexKind::kSmooth) return true;
    return history_.is_chain_edge(table_, CornerTable::previous(c));
  }

  /// The lowest cost over the neighbours, validity not checked: a lower bound.
  double hoped_cost(std::uint32_t v) const {
    double best = kInfinity;
    if (extremities_found_ && protected_[v]) return best;
    const Corner first = table_.corner_at(v);
    Corner c = first;
    do {
      if (kind_allows(c)) best = std::min(best, cost(c));
      c = table_.rotate(c);
    } while (c != first);
    return best;
  }

  struct Candidate {
    double cost;
    Corner corner;
  };

  /// The cheapest valid collapse of v, or a cost of infinity.
  Candidate best_candidate(std::uint32_t v) {
    candidates_.clear();
    if (extremities_found_ && protected_[v]) return {kInfinity, kNone};
    const Corner first = table_.corner_at(v);
    Corner c = first;
    do {
      if (kind_allows(c)) candidates_.push_back({cost(c), c});
      c = table_.rotate(c);
    } while (c != first);
    std::sort(candidates_.begin(), candidates_.end(), [](const Candidate& a, const Candidate& b) {
      return a.cost != b.cost ? a.cost < b.cost : a.corner < b.corner;
    });
    for (const Candidate& candidate : candidates_)
      if (is_valid(candidate.corner)) return candidate;
    return {kInfinity, kNone};
  }

  bool is_valid(Corner c) {
    const std::uint32_t v = table_.vertex(c), u = table_.vertex(CornerTable::next(c));
    const std::uint32_t a = table_.vertex(CornerTable::previous(c));
    const Corner at_b = table_.opposite(CornerTable::previous(c));
    const std::uint32_t b = table_.vertex(at_b);
    return valences_allow(v, u, a, b) && chain_survives(c) && leaves_no_chord(c) && links_.holds(table_, v, u) &&
           faces_turn_little(c);
  }

  bool valences_allow(std::uint32_t v, std::uint32_t u, std::uint32_t a, std::uint32_t b) const {
    const int merged = valence_[v] + valence_[u] - 4;
    if (merged > kMaximumBoundaryValence && merged > valence_[u] && table_.is_boundary_vertex(u))
      return false;
    if (merged > kMaximumValence + (strict_ ? 0 : kLooseValence) && merged > valence_[u]) return false;
    for (const std::uint32_t w : {a, b}) {
      const bool free = table_.is_ghost_vertex(w) || history_.kinds[w] != VertexKind::kSmooth;
      if (valence_[w] - 1 < (strict_ && !free && relaxed_ == 0 ? 4 : 3)) return false;
    }
    const bool u_free = history_.kinds[u] != VertexKind::kSmooth;
    return merged >= (strict_ && !u_free && relaxed_ == 0 ? 4 : 3);
  }

  /// Merging a chain vertex v into u needs, on every real side of the chain, a triangle besides the one at
  /// the edge v - u: a triangle (u, v, x) with x the next vertex of the chain would have no area in the
  /// domain, where the chain is straight.
  bool chain_survives(Corner c) const {
    if (history_.kinds[table_.vertex(c)] == VertexKind::kSmooth) return true;
    const Corner other_u = CornerTable::next(table_.opposite(CornerTable::previous(c)));
    return !history_.is_chain_edge(table_, CornerTable::next(c)) && !history_.is_chain_edge(table_, other_u);
  }

  /// A smooth vertex that touches two places of a chain would, merged into one of them, leave a chord; both
  /// its ends and some vertex between them would then have to stay to the end.
  bool leaves_no_chord(Corner c) const {
    const std::uint32_t v = table_.vertex(c), u = table_.vertex(CornerTable::next(c));
    if (relaxed_ >= 1 || history_.kinds[v] != VertexKind::kSmooth || history_.kinds[u] == VertexKind::kSmooth)
      return true;
    const std::uint32_t a = table_.vertex(CornerTable::previous(c));
    const std::uint32_t b = table_.vertex(table_.opposite(CornerTable::previous(c)));
    for (Corner d = table_.rotate(c); d != c; d = table_.rotate(d)) {
      const std::uint32_t w = table_.vertex(CornerTable::next(d));
      if (w != a && w != b && history_.kinds[w] != VertexKind::kSmooth) return false;
    }
    return true;
  }

  bool faces_turn_little(Corner c) const {
    if (relaxed_ >= 2) return true;
    const Vec3& target = positions_[table_.vertex(CornerTable::next(c))];
    const Vec3& source = positions_[table_.vertex(c)];
    const Corner at_b = table_.opposite(CornerTable::previous(c));
    for (Corner d = table_.rotate(c); CornerTable::face_of(d) != CornerTable::face_of(at_b);
         d = table_.rotate(d)) {
      if (table_.is_ghost_face(CornerTable::face_of(d))) continue;
      const Vec3& p = positions_[table_.vertex(CornerTable::next(d))];
      const Vec3& q = positions_[table_.vertex(CornerTable::previous(d))];
      const Vec3 before = cross(p - source, q - source), after = cross(p - target, q - target);
      const double product = dot(before, after);
      const double lengths = squared_norm(before) * squared_norm(after);
      if (!(product > 0) || product * product < kMinimumTurnCosine * kMinimumTurnCosine * lengths)
        return false;
    }
    return true;
  }

  bool step() {
    for (;;) {
      if (queue_.empty()) return false;
      const std::uint32_t v = queue_.top();
      if (queue_.key(v) == kInfinity) {
        if (relaxed_ == 2) return false;
        ++relaxed_;
        refresh_all();
        continue;
      }
      const Candidate best = best_candidate(v);
      if (best.cost > queue_.key(v)) {
        queue_.set(v, best.cost);
        if (queue_.top() != v) continue;
        if (best.cost == kInfinity) continue;
      }
      apply(best.corner);
      return true;
    }
  }

  void apply(Corner c) {
    const std::uint32_t v = table_.vertex(c), u = table_.vertex(CornerTable::next(c));
    const std::uint32_t a = table_.vertex(CornerTable::previous(c));
    const std::uint32_t b = table_.vertex(table_.opposite(CornerTable::previous(c)));
    table_.collapse(c);
    history_.steps.push_back(c);
    --live_count_;
    valence_[u] += valence_[v] - 4;
    --valence_[a];
    --valence_[b];
    quadrics_[u] += quadrics_[v];
    own_error_[u] = quadrics_[u](positions_[u]);
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
    if (history_.kinds[v] != VertexKind::kLocked) queue_.set(v, hoped_cost(v));
  }

  void refresh_all() {
    for (std::uint32_t v = 0; v < table_.real_vertex_count(); ++v)
      if (table_.corner_at(v) != kNone) refresh(v);
  }

  CollapseHistory& history_;
  CornerTable& table_;
  const CollapseOptions& options_;
  VertexQueue queue_;
  std::vector<Vec3> positions_;
  std::vector<Quadric> quadrics_;
  std::vector<double> own_error_;
  std::vector<int> valence_;
  LinkCondition links_;
  std::size_t live_count_ = 0;
  std::vector<Candidate> candidates_;
  std::vector<std::uint32_t> extremities_;  // most prominent first; the first protected_count_ may not go
  std::vector<std::uint8_t> protected_;
  std::size_t protected_count_ = 0;
  bool extremities_found_ = false;
  bool strict_ = false;  // near a base: valences of at least 4 and at most 9
  int relaxed_ = 0;  // raised when nothing else is left: 1 allows chords and low valences, 2 lets faces turn
};

}  // namespace

CollapseHistory maps_collapse(const TriangleMesh& mesh, const std::vector<int>& base_sizes,
                              const CollapseOptions& options, const Progress& progress) {
  SurfaceChains chains = find_chains(mesh, options.crease_angle_degrees);
  CollapseHistory history{.surface = chains.surface,
                          .input_vertex_count = mesh.vertex_count(),
                          .coarsest = CornerTable(chains.surface->vertex_count(), chains.surface->triangles),
                          .steps = {},
                          .base_step_counts = {},
                          .kinds = std::move(chains.kinds),
                          .extremities = {},
                          .crease_corners = {}};
  const CornerTable& table = history.coarsest;
  if (!chains.crease_edges.empty()) {
    history.crease_corners.assign(3 * table.face_slot_count(), 0);
    for (Corner c = 0; c < 3 * table.real_face_count(); ++c) {
      const std::uint32_t a = table.vertex(CornerTable::next(c)), b = table.vertex(CornerTable::previous(c));
      const std::array<std::uint32_t, 2> edge{std::min(a, b), std::max(a, b)};
      history.crease_corners[c] =
          std::binary_search(chains.crease_edges.begin(), chains.crease_edges.end(), edge);
    }
  }
  history.steps.reserve(table.real_vertex_count());
  Collapser(history, options).run(base_sizes, progress);
  return history;
}

}  // namespace nmc
