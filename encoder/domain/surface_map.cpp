// SPDX-License-Identifier: Apache-2.0
#include "encoder/domain/surface_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "encoder/domain/exact_orientation.h"

namespace nmc {
namespace {

using Corner = CornerTable::Corner;

/// Cones at tips may slide by this share of their shortest base edge.
constexpr double kTipSlide = 0.4;

std::size_t slot(Corner c) { return c % 3; }

/// The isometry that takes (p0, p1) to (q0, q1); both are pairs of lattice points at equal distances.
ChartMap aligning_map(const ChartPoint& p0, const ChartPoint& p1, const ChartPoint& q0,
                      const ChartPoint& q1) {
  ChartMap map;
  for (int turns = 0; turns < 6; ++turns) {
    map.turns = static_cast<std::int8_t>(turns);
    if (map.rotate(p1 - p0) == q1 - q0) break;
  }
  const ChartPoint shift = q0 - map.rotate(p0);
  map.tu = static_cast<std::int16_t>(shift.u);
  map.tv = static_cast<std::int16_t>(shift.v);
  return map;
}

/// A point of the polygon that lies to the left of all segments: the kernel's centre of vertices. False when
/// the kernel is empty. O(d^2).
bool kernel_point(const std::vector<SurfaceMap::StarTriangle>& link, ChartPoint& center) {
  ChartPoint low = link[0].q, high = link[0].q;
  for (const auto& t : link)
    for (const ChartPoint& p : {t.q, t.r}) {
      low = {std::min(low.u, p.u), std::min(low.v, p.v)};
      high = {std::max(high.u, p.u), std::max(high.v, p.v)};
    }
  std::vector<ChartPoint> polygon{low, {high.u, low.v}, high, {low.u, high.v}}, clipped;
  for (const auto& t : link) {
    clipped.clear();
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const ChartPoint& a = polygon[i];
      const ChartPoint& b = polygon[(i + 1) % polygon.size()];
      const double sa = face_ratio(t.q, t.r, a), sb = face_ratio(t.q, t.r, b);
      if (sa >= 0) clipped.push_back(a);
      if ((sa > 0 && sb < 0) || (sa < 0 && sb > 0)) clipped.push_back(a + sa / (sa - sb) * (b - a));
    }
    polygon.swap(clipped);
    if (polygon.size() < 3) return false;
  }
  center = {0, 0};
  for (const ChartPoint& p : polygon) center = center + 1.0 / static_cast<double>(polygon.size()) * p;
  return true;
}

}  // namespace

SurfaceMap::SurfaceMap(const CollapseHistory& history, std::size_t step_count)
    : history_(history), table_(history.coarsest), steps_left_(step_count) {
  for (std::size_t i = history.steps.size(); i > steps_left_; --i) table_.undo_collapse(history.steps[i - 1]);
  build_domain();
}

void SurfaceMap::build_domain() {
  const std::size_t vertex_count = table_.real_vertex_count(), face_count = table_.real_face_count();
  std::vector<std::uint32_t> base_index(vertex_count, kNoVertex);
  cone_index_.assign(vertex_count, kNoVertex);
  for (std::uint32_t v = 0; v < vertex_count; ++v)
    if (table_.corner_at(v) != CornerTable::kNone) {
      base_index[v] = static_cast<std::uint32_t>(base_vertices_.size());
      base_vertices_.push_back(v);
      cone_index_[v] = base_index[v];
    }
  live_vertex_count_ = base_vertices_.size();
  std::vector<Triangle> faces;
  std::vector<std::array<std::uint32_t, 2>> creases;
  charts_.assign(face_count, {});
  for (std::uint32_t f = 0; f < face_count; ++f) {
    if (!table_.is_live_face(f)) continue;
    const Triangle t = table_.face(f);
    charts_[f].face = static_cast<std::uint32_t>(faces.size());
    faces.push_back({base_index[t[0]], base_index[t[1]], base_index[t[2]]});
    for (Corner c = 3 * f; c < 3 * f + 3; ++c)
      if (history_.is_chain_edge(table_, c))
        creases.push_back({base_index[table_.vertex(CornerTable::next(c))],
                           base_index[table_.vertex(CornerTable::previous(c))]});
  }
  domain_ = BaseDomain(base_vertices_.size(), std::move(faces), creases);

  limit_slides();
  density_.assign(vertex_count, 1.0);
  points_.assign(vertex_count, {});
  for (const std::uint32_t v : base_vertices_) points_[v] = domain_.cone_point(base_index[v]);
  for (std::uint32_t f = 0; f < face_count; ++f) {
    if (!table_.is_live_face(f)) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      // Walk around the cone from the triangle to the face that names the cone's point.
      const std::uint32_t v = table_.vertex(static_cast<Corner>(3 * f + k));
      std::uint32_t g = charts_[f].face;
      ChartMap map;
      const auto ring = domain_.faces_around(base_index[v]);
      const auto place = static_cast<std::size_t>(std::find(ring.begin(), ring.end(), g) - ring.begin());
      for (std::size_t i = place; i > 0; --i) {
        const int side = (domain_.corner_of(g, base_index[v]) + 2) % 3;
        map = compose(map, domain_.hinge(g, side));
        g = domain_.neighbor(g, side);
      }
      charts_[f].maps[k] = map;
    }
  }
}

/// A cone at the tip of a limb may slide a little, to where the map is smooth, but not down towards the body:
/// that lowers the energy too, and leaves the tip without samples.
bool SurfaceMap::leaves_tip(std::uint32_t cone, std::uint32_t v) const {
  return slide_radius_[cone] >= 0 && distance(position(v), position(homes_[cone])) > slide_radius_[cone];
}

void SurfaceMap::limit_slides() {
  homes_ = base_vertices_;
  slide_radius_.assign(base_vertices_.size(), -1);
  if (history_.extremities.empty()) return;
  for (std::uint32_t i = 0; i < base_vertices_.size(); ++i) {
    const std::uint32_t v = base_vertices_[i];
    if (!history_.extremities[v]) continue;
    double shortest = std::numeric_limits<double>::infinity();
    for (const std::uint32_t f : domain_.faces_around(i))
      for (const std::uint32_t w : domain_.face(f))
        if (w != i) shortest = std::min(shortest, distance(position(v), position(base_vertices_[w])));
    slide_radius_[i] = kTipSlide * shortest;
  }
}

void SurfaceMap::star(std::uint32_t v, std::vector<StarTriangle>& triangles) const {
  triangles.clear();
  const Corner first = table_.corner_at(v);
  Corner c = first;
  do {
    const std::uint32_t f = CornerTable::face_of(c);
    if (!table_.is_ghost_face(f)) {
      const Corner q = CornerTable::next(c), r = CornerTable::previous(c);
      const auto& maps = charts_[f].maps;
      const ChartMap to_own = inverse(maps[slot(c)]);
      triangles.push_back({c, to_own(maps[slot(q)](points_[table_.vertex(q)].at)),
                           to_own(maps[slot(r)](points_[table_.vertex(r)].at))});
    }
    c = table_.rotate(c);
  } while (c != first);
}

bool SurfaceMap::is_positive(const std::vector<StarTriangle>& triangles, const ChartPoint& z) {
  return std::all_of(triangles.begin(), triangles.end(),
                     [&z](const StarTriangle& t) { return orientation(z, t.q, t.r) > 0; });
}

void SurfaceMap::move(std::uint32_t v, const ChartPoint& z, const std::vector<StarTriangle>& triangles) {
  DomainPoint& p = points_[v];
  if (history_.kinds[v] != VertexKind::kSmooth) {
    p.at = z;
    return;
  }
  const std::uint32_t old_face = p.face;
  ChartMap to_old;
  p = domain_.walk(old_face, p.at, z, &to_old);
  if (p.face == old_face && to_old.turns == 0 && to_old.tu == 0 && to_old.tv == 0) return;
  for (const StarTriangle& t : triangles) {
    ChartMap& map = charts_[CornerTable::face_of(t.corner)].maps[slot(t.corner)];
    map = compose(map, to_old);
  }
}

ChartPoint SurfaceMap::chain_direction(std::uint32_t v) const {
  const ChartPoint& at = points_[v].at;
  if (at.v == 0) return {1, 0};
  if (at.u == 0) return {0, 1};
  return {-1, 1};
}

bool SurfaceMap::unfold_link(Corner step) {
  link_.clear();
  const Corner at_b = table_.opposite(CornerTable::previous(step));
  Corner c = step;
  do {
    const std::uint32_t f = CornerTable::face_of(c);
    if (!table_.is_ghost_face(f))
      link_.push_back({c, {}, {}, {}, f == CornerTable::face_of(step) || f == CornerTable::face_of(at_b)});
    c = table_.rotate(c);
  } while (c != step);

  // The work chart is that of a corner that is not a cone: of the vertex u that the new one was merged into,
  // or of one in its link. Where all are cones the triangles are base faces.
  const std::uint32_t u = table_.vertex(CornerTable::next(step));
  std::size_t start = 0;
  while (start < link_.size() && link_[start].is_new) ++start;
  if (start == link_.size()) return false;
  const std::size_t first_old = start;
  const auto map_at = [this](Corner corner) -> const ChartMap& {
    return charts_[CornerTable::face_of(corner)].maps[slot(corner)];
  };
  Corner anchor_corner = CornerTable::kNone;
  if (!is_cone(u)) {
    anchor_corner = link_[start].corner;
    anchor_face_ = points_[u].face;
    anchor_ = points_[u].at;
  } else {
    for (std::size_t i = first_old;
         i < link_.size() && !link_[i].is_new && anchor_corner == CornerTable::kNone; ++i)
      for (const Corner corner : {CornerTable::next(link_[i].corner), CornerTable::previous(link_[i].corner)})
        if (!is_cone(table_.vertex(corner))) {
          anchor_corner = corner;
          start = i;
          anchor_face_ = points_[table_.vertex(corner)].face;
          anchor_ = points_[table_.vertex(corner)].at;
          break;
        }
    if (anchor_corner == CornerTable::kNone) {
      anchor_face_ = charts_[CornerTable::face_of(link_[start].corner)].face;
      anchor_ = {1.0 / 3, 1.0 / 3};
    }
  }
  if (anchor_corner != CornerTable::kNone) link_[start].to_work = inverse(map_at(anchor_corner));

  // Lay the other old triangles beside their neighbours, over the shared edge u - l.
  const auto align = [&](std::size_t placed, std::size_t other, Corner l, Corner l_other) {
    const Corner p = link_[placed].corner, o = link_[other].corner;
    const std::uint32_t shared = table_.vertex(l);
    if (!is_cone(u)) {
      link_[other].to_work = compose(link_[placed].to_work, compose(map_at(p), inverse(map_at(o))));
    } else if (!is_cone(shared)) {
      link_[other].to_work = compose(link_[placed].to_work, compose(map_at(l), inverse(map_at(l_other))));
    } else {
      const ChartMap across = aligning_map(map_at(o)(points_[u].at), map_at(l_other)(points_[shared].at),
                                           map_at(p)(points_[u].at), map_at(l)(points_[shared].at));
      link_[other].to_work = compose(link_[placed].to_work, across);
    }
  };
  std::size_t last_old = start;
  for (std::size_t i = start + 1; i < link_.size() && !link_[i].is_new; ++i) {
    align(i - 1, i, CornerTable::previous(link_[i - 1].corner), CornerTable::next(link_[i].corner));
    last_old = i;
  }
  for (std::size_t i = start; i > first_old; --i)
    align(i, i - 1, CornerTable::next(link_[i].corner), CornerTable::previous(link_[i - 1].corner));

  // The two new triangles take their charts from the old ones beside them.
  const auto lay_new = [&](std::size_t fresh, std::size_t old, Corner l_fresh, Corner l_old, Corner u_fresh) {
    TriangleChart& chart = charts_[CornerTable::face_of(link_[fresh].corner)];
    chart.face = anchor_face_;
    chart.maps[slot(u_fresh)] = compose(link_[old].to_work, map_at(link_[old].corner));
    chart.maps[slot(l_fresh)] = compose(link_[old].to_work, map_at(l_old));
    link_[fresh].to_work = {};
  };
  if (first_old > 0) {
    const Corner fresh = link_[0].corner, old = link_[first_old].corner;
    lay_new(0, first_old, CornerTable::previous(fresh), CornerTable::next(old), CornerTable::next(fresh));
  }
  if (last_old + 1 < link_.size()) {
    const Corner fresh = link_[last_old + 1].corner, old = link_[last_old].corner;
    lay_new(last_old + 1, last_old, CornerTable::next(fresh), CornerTable::previous(old),
            CornerTable::previous(fresh));
  }
  star_.clear();
  for (LinkTriangle& t : link_) {
    const Corner q = CornerTable::next(t.corner), r = CornerTable::previous(t.corner);
    t.q = t.to_work(map_at(q)(points_[table_.vertex(q)].at));
    t.r = t.to_work(map_at(r)(points_[table_.vertex(r)].at));
    star_.push_back({t.corner, t.q, t.r});
  }
  return true;
}

ChartPoint SurfaceMap::interior_start(std::uint32_t v) const {
  // Mean value coordinates of the vertex in its link (Floater 2003).
  ChartPoint sum{0, 0};
  double total = 0;
  const Vec3& p = position(v);
  for (const StarTriangle& t : star_) {
    const Vec3 a = position(table_.vertex(CornerTable::next(t.corner))) - p;
    const Vec3 b = position(table_.vertex(CornerTable::previous(t.corner))) - p;
    const double la = norm(a), lb = norm(b);
    // tan(angle / 2) = |a x b| / (|a||b| + a.b), bounded for nearly straight angles
    const double half_tangent =
        std::min(norm(cross(a, b)) / std::max(la * lb + dot(a, b), 1e-12 * la * lb), 100.0);
    if (!(la > 0) || !(lb > 0) || !std::isfinite(half_tangent)) continue;
    sum = sum + half_tangent / la * t.q + half_tangent / lb * t.r;
    total += half_tangent / la + half_tangent / lb;
  }
  ChartPoint start = star_[0].q;
  if (total > 0) start = snap_to_grid(1 / total * sum);
  if (is_positive(star_, start)) return start;
  if (kernel_point(star_, start)) start = snap_to_grid(start);
  return start;
}

ChartPoint SurfaceMap::chain_start(std::uint32_t v, std::uint32_t u) const {
  ChartPoint at_u, at_x;
  double to_u = 1, to_x = 1;
  for (const StarTriangle& t : star_)
    for (const bool is_q : {true, false}) {
      const Corner w = is_q ? CornerTable::next(t.corner) : CornerTable::previous(t.corner);
      // The edge v - w is opposite the third corner.
      const Corner across = is_q ? CornerTable::previous(t.corner) : CornerTable::next(t.corner);
      if (!history_.is_chain_edge(table_, across)) continue;
      const std::uint32_t neighbor = table_.vertex(w);
      (neighbor == u ? at_u : at_x) = is_q ? t.q : t.r;
      (neighbor == u ? to_u : to_x) = distance(position(v), position(neighbor));
    }
  double low = 0, high = 1;
  for (const StarTriangle& t : star_) {
    const double s0 = face_ratio(at_u, t.q, t.r), s1 = face_ratio(at_x, t.q, t.r);
    if (s0 < s1) low = std::max(low, -s0 / (s1 - s0));
    if (s0 > s1) high = std::min(high, s0 / (s0 - s1));
  }
  double parameter = to_u + to_x > 0 ? to_u / (to_u + to_x) : 0.5;
  if (!(parameter > low + 0.05 * (high - low) && parameter < high - 0.05 * (high - low)))
    parameter = 0.5 * (low + high);
  return at_u + parameter * (at_x - at_u);
}

/// Places vertex(step) beside vertex(next(step)), which stays. False, with nothing but the charts of the two
/// new triangles changed, where there is no room.
bool SurfaceMap::try_place(Corner step) {
  if (!unfold_link(step)) return false;
  const std::uint32_t v = table_.vertex(step), u = table_.vertex(CornerTable::next(step));
  const bool on_chain = history_.kinds[v] != VertexKind::kSmooth;
  const ChartPoint z = on_chain ? chain_start(v, u) : interior_start(v);
  ChartMap to_work;
  DomainPoint p = domain_.walk(anchor_face_, anchor_, z, &to_work);
  if (on_chain) {
    // Exactly onto the base edge: the coordinate that only rounding keeps from zero.
    const auto b = p.barycentric();
    int k = 0;
    for (int i = 1; i < 3; ++i)
      if (std::abs(b[i]) < std::abs(b[k])) k = i;
    if (k == 0) p.at.v = 1.0 - p.at.u;
    if (k == 1) p.at.u = 0;
    if (k == 2) p.at.v = 0;
  }
  const ChartPoint placed = to_work(p.at);
  bool half = false;
  if (on_chain) half = table_.is_boundary_vertex(v);
  if (!is_positive(star_, placed) || !winds_once(placed, half)) return false;
  points_[v] = p;
  for (const LinkTriangle& t : link_)
    charts_[CornerTable::face_of(t.corner)].maps[slot(t.corner)] = compose(inverse(t.to_work), to_work);
  return true;
}

bool SurfaceMap::winds_once(const ChartPoint& z, bool half) const {
  double turn = 0;
  for (const StarTriangle& t : star_) {
    const auto [qx, qy] = to_cartesian(t.q - z);
    const auto [rx, ry] = to_cartesian(t.r - z);
    turn += std::atan2(qx * ry - qy * rx, qx * rx + qy * ry);
  }
  return std::abs(turn - (half ? 1 : 2) * std::numbers::pi) < 0.5;
}

void SurfaceMap::pass_cone(std::uint32_t from, std::uint32_t to) {
  const std::uint32_t cone = cone_index_[from];
  cone_index_[from] = kNoVertex;
  cone_index_[to] = cone;
  base_vertices_[cone] = to;
  points_[to] = points_[from];
}

SurfaceMap::Saved SurfaceMap::save(std::uint32_t u, std::uint32_t v) const {
  Saved saved;
  saved.vertices = {u, v};
  for (std::size_t i = 0; i < 2; ++i) {
    const std::uint32_t w = saved.vertices[i];
    saved.points[i] = points_[w];
    saved.cones[i] = cone_index_[w];
    const Corner first = table_.corner_at(w);
    Corner c = first;
    do {
      if (!table_.is_ghost_face(CornerTable::face_of(c))) saved.faces.push_back(CornerTable::face_of(c));
      c = table_.rotate(c);
    } while (c != first);
  }
  std::sort(saved.faces.begin(), saved.faces.end());
  saved.faces.erase(std::unique(saved.faces.begin(), saved.faces.end()), saved.faces.end());
  for (const std::uint32_t f : saved.faces) saved.charts.push_back(charts_[f]);
  return saved;
}

void SurfaceMap::restore(const Saved& saved) {
  for (std::size_t i = 0; i < 2; ++i) {
    points_[saved.vertices[i]] = saved.points[i];
    cone_index_[saved.vertices[i]] = saved.cones[i];
    if (saved.cones[i] != kNoVertex) base_vertices_[saved.cones[i]] = saved.vertices[i];
  }
  for (std::size_t i = 0; i < saved.faces.size(); ++i) charts_[saved.faces[i]] = saved.charts[i];
}

double SurfaceMap::energy(const std::vector<std::uint32_t>& faces, const EnergyWeights& weights,
                          const std::vector<double>& scale) const {
  double sum = 0;
  for (const std::uint32_t f : faces) {
    const Triangle t = table_.face(f);
    const TriangleShape shape = triangle_shape(position(t[0]), position(t[1]), position(t[2]));
    std::array<ChartPoint, 3> p;
    double density = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      p[k] = charts_[f].maps[k](points_[t[k]].at);
      density += scale[points_[t[k]].face] * density_[t[k]] / 3;
    }
    const double target = std::max(shape.area * density, 1e-12);
    const double area = 0.43301270189221932 * face_ratio(p[0], p[1], p[2]);
    for (std::size_t k = 0; k < 3; ++k)
      sum += 0.25 * weights.dirichlet * shape.cotangents[k] * squared_length(p[(k + 2) % 3] - p[(k + 1) % 3]);
    sum += weights.area * area * area / target;
    if (area > 0) sum += weights.barrier * target * target / area;
  }
  return sum;
}

void SurfaceMap::place_vertex(std::uint32_t v, Corner step, const EnergyWeights& weights,
                              const std::vector<double>& scale) {
  constexpr int kIterations = 2;
  const std::uint32_t u = table_.vertex(CornerTable::next(step));
  points_[v] = points_[u];
  if (!is_cone(u) || history_.kinds[u] != history_.kinds[v]) {
    if (try_place(step))
      descend(v, weights, scale, kIterations);
    else
      ++failed_insertions_;
    return;
  }

  // The new vertex may as well take the cone and u make room: that is how cones slide over the surface, a
  // long way while the mesh is coarse and less and less as it grows finer.
  double beside_energy = std::numeric_limits<double>::infinity();
  const Saved before = save(u, v);
  const bool beside = try_place(step);
  if (beside) {
    descend(v, weights, scale, kIterations);
    if (leaves_tip(cone_index_[u], v)) return;
    beside_energy = energy(before.faces, weights, scale);
  }
  const Saved after = save(u, v);
  restore(before);
  pass_cone(u, v);
  const Corner step_of_u = CornerTable::next(table_.opposite(CornerTable::previous(step)));
  if (try_place(step_of_u)) {
    descend(u, weights, scale, kIterations);
    if (energy(before.faces, weights, scale) < beside_energy) return;
  }
  restore(after);
  failed_insertions_ += !beside;
}

void SurfaceMap::descend(std::uint32_t v, const EnergyWeights& weights, const std::vector<double>& scale,
                         int iterations) {
  for (int iteration = 0; iteration < iterations; ++iteration) {
    star(v, star_);
    const DomainPoint& p = points_[v];
    const auto [zx, zy] = to_cartesian(p.at);
    StarModel model;
    for (const StarTriangle& t : star_) {
      const std::uint32_t q = table_.vertex(CornerTable::next(t.corner));
      const std::uint32_t r = table_.vertex(CornerTable::previous(t.corner));
      const TriangleShape shape = triangle_shape(position(v), position(q), position(r));
      const auto [qx, qy] = to_cartesian(t.q);
      const auto [rx, ry] = to_cartesian(t.r);
      const double target = shape.area *
                            (scale[p.face] * density_[v] + scale[points_[q].face] * density_[q] +
                             scale[points_[r].face] * density_[r]) /
                            3;
      model.add(weights, zx, zy, qx, qy, rx, ry, shape.cotangents[1], shape.cotangents[2],
                std::max(target, 1e-12));
    }
    std::array<double, 2> d;
    ChartPoint direction{};
    const bool on_chain = history_.kinds[v] != VertexKind::kSmooth;
    if (on_chain) {
      direction = chain_direction(v);
      const auto [dx, dy] = to_cartesian(direction);
      d = model.step_along(dx, dy);
    } else {
      d = model.step();
    }
    const ChartPoint full = from_cartesian(d[0], d[1]);
    double length = 1;
    for (int attempt = 0; attempt < 6; ++attempt, length *= 0.5) {
      ChartPoint z = snap_to_grid(p.at + length * full);
      if (on_chain) {
        const double along =
            snap_to_grid({direction.u != 0 ? direction.u * length * full.u : length * full.v, 0}).u;
        z = p.at + along * direction;
      }
      if (!is_positive(star_, z)) continue;
      move(v, z, star_);
      break;
    }
  }
}

std::uint32_t SurfaceMap::undo_step(const EnergyWeights& weights, const std::vector<double>& scale) {
  const Corner step = history_.steps[--steps_left_];
  table_.undo_collapse(step);
  ++live_vertex_count_;
  const std::uint32_t v = table_.vertex(step);
  double sum = 0;
  int neighbors = 0;
  Corner c = step;
  do {
    const std::uint32_t w = table_.vertex(CornerTable::next(c));
    if (!table_.is_ghost_vertex(w)) {
      sum += density_[w];
      ++neighbors;
    }
    c = table_.rotate(c);
  } while (c != step);
  density_[v] = sum / neighbors;
  place_vertex(v, step, weights, scale);
  return v;
}

void SurfaceMap::recenter_charts() {
  for (std::uint32_t f = 0; f < charts_.size(); ++f) {
    if (!table_.is_live_face(f)) continue;
    const Triangle t = table_.face(f);
    std::size_t k = 0;
    while (k < 3 && is_cone(t[k])) ++k;
    if (k == 3) continue;
    const ChartMap back = inverse(charts_[f].maps[k]);
    for (ChartMap& map : charts_[f].maps) map = compose(back, map);
    charts_[f].face = points_[t[k]].face;
  }
}

Parameterization SurfaceMap::release() {
  recenter_charts();
  Parameterization result;
  result.surface = history_.surface;
  result.input_vertex_count = history_.input_vertex_count;
  result.domain = std::move(domain_);
  result.vertex_points = std::move(points_);
  result.triangle_charts = std::move(charts_);
  result.base_vertex_ids = std::move(base_vertices_);
  for (const std::uint32_t v : result.base_vertex_ids) result.base_positions.push_back(position(v));
  return result;
}

}  // namespace nmc
