// SPDX-License-Identifier: Apache-2.0
#include "encoder/domain/base_domain.h"

#include <algorithm>
#include <limits>
#include <string>

#include "encoder/core/error.h"
#include "encoder/core/parallel.h"

namespace nmc {
namespace {

/// One directed side of a face, keyed by its undirected edge.
struct Side {
  std::uint64_t edge;
  std::uint32_t face;
  std::uint8_t k;
};

constexpr int kMaximumWalk = 64;

std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) {
  return (static_cast<std::uint64_t>(std::min(a, b)) << 32) | std::max(a, b);
}

ChartMap hinge_between(int k, int j) {
  // Side k of the face runs from corner k+1 to k+2; side j of the neighbour is the same edge run backwards.
  // Edge directions of a face are at 60 * {2, 4, 0} degrees for k = 0, 1, 2.
  constexpr int kDirection[3] = {2, 4, 0};
  ChartMap map;
  map.turns = static_cast<std::int8_t>((kDirection[k] + 3 - kDirection[j] + 6) % 6);
  map.hops = 1;
  const ChartPoint target = kFaceCorners[(k + 1) % 3];
  const ChartPoint source = map.rotate(kFaceCorners[(j + 2) % 3]);
  map.tu = static_cast<std::int16_t>(target.u - source.u);
  map.tv = static_cast<std::int16_t>(target.v - source.v);
  return map;
}

}  // namespace

ChartMap compose(const ChartMap& a, const ChartMap& b) {
  const ChartPoint moved = a(ChartPoint{static_cast<double>(b.tu), static_cast<double>(b.tv)});
  ChartMap result;
  result.turns = static_cast<std::int8_t>(a.turns + b.turns >= 6 ? a.turns + b.turns - 6 : a.turns + b.turns);
  result.hops = static_cast<std::int8_t>(std::min(100, a.hops + b.hops));
  result.tu = static_cast<std::int16_t>(moved.u);
  result.tv = static_cast<std::int16_t>(moved.v);
  return result;
}

ChartMap inverse(const ChartMap& a) {
  ChartMap result;
  result.turns = static_cast<std::int8_t>(a.turns == 0 ? 0 : 6 - a.turns);
  result.hops = a.hops;
  const ChartPoint back = result.rotate({static_cast<double>(a.tu), static_cast<double>(a.tv)});
  result.tu = static_cast<std::int16_t>(-back.u);
  result.tv = static_cast<std::int16_t>(-back.v);
  return result;
}

BaseDomain::BaseDomain(std::size_t vertex_count, std::vector<Triangle> faces,
                       const std::vector<std::array<std::uint32_t, 2>>& crease_edges)
    : faces_(std::move(faces)) {
  connect(vertex_count, crease_edges);
  build_rings(vertex_count);
  label_components();
  build_neighborhoods();
}

void BaseDomain::connect(std::size_t vertex_count,
                         const std::vector<std::array<std::uint32_t, 2>>& crease_edges) {
  std::vector<Side> sides;
  sides.reserve(3 * faces_.size());
  for (std::uint32_t f = 0; f < faces_.size(); ++f)
    for (std::uint8_t k = 0; k < 3; ++k) {
      const std::uint32_t a = faces_[f][(k + 1) % 3], b = faces_[f][(k + 2) % 3];
      if (a >= vertex_count || a == b)
        throw Error(ExitCode::kInternal, "base mesh: face " + std::to_string(f) + " is degenerate");
      sides.push_back({edge_key(a, b), f, k});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return a.edge != b.edge ? a.edge < b.edge : a.face < b.face;
  });
  std::vector<std::uint64_t> creases;
  for (const auto& edge : crease_edges) creases.push_back(edge_key(edge[0], edge[1]));
  std::sort(creases.begin(), creases.end());

  neighbors_.assign(faces_.size(), {kNoFace, kNoFace, kNoFace});
  hinges_.assign(faces_.size(), {});
  tags_.assign(faces_.size(), {EdgeTag::kBoundary, EdgeTag::kBoundary, EdgeTag::kBoundary});
  boundary_vertex_.assign(vertex_count, 0);
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i + 1;
    while (end < sides.size() && sides[end].edge == sides[i].edge) ++end;
    if (end - i > 2) throw Error(ExitCode::kInternal, "base mesh: an edge has more than two faces");
    const Side& a = sides[i];
    if (end - i == 2) {
      const Side& b = sides[i + 1];
      if (faces_[a.face][(a.k + 1) % 3] == faces_[b.face][(b.k + 1) % 3])
        throw Error(ExitCode::kInternal, "base mesh: faces are not oriented consistently");
      neighbors_[a.face][a.k] = b.face;
      neighbors_[b.face][b.k] = a.face;
      hinges_[a.face][a.k] = hinge_between(a.k, b.k);
      hinges_[b.face][b.k] = hinge_between(b.k, a.k);
      const EdgeTag tag =
          std::binary_search(creases.begin(), creases.end(), a.edge) ? EdgeTag::kCrease : EdgeTag::kSmooth;
      tags_[a.face][a.k] = tags_[b.face][b.k] = tag;
    } else {
      boundary_vertex_[faces_[a.face][(a.k + 1) % 3]] = 1;
      boundary_vertex_[faces_[a.face][(a.k + 2) % 3]] = 1;
    }
    i = end;
  }
}

void BaseDomain::build_rings(std::size_t vertex_count) {
  vertex_first_.assign(vertex_count + 1, 0);
  for (const Triangle& face : faces_)
    for (const std::uint32_t v : face) ++vertex_first_[v + 1];
  for (std::size_t v = 0; v < vertex_count; ++v) vertex_first_[v + 1] += vertex_first_[v];
  ring_.assign(3 * faces_.size(), kNoFace);

  // The start of a ring: the lowest face, or on a boundary the face that nothing precedes clockwise.
  std::vector<std::uint32_t> start(vertex_count, kNoFace);
  for (std::uint32_t f = 0; f < faces_.size(); ++f)
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t v = faces_[f][k];
      if (start[v] == kNoFace || neighbors_[f][(k + 2) % 3] == kNoFace) start[v] = f;
    }
  for (std::uint32_t v = 0; v < vertex_count; ++v) {
    const std::uint32_t degree = vertex_first_[v + 1] - vertex_first_[v];
    std::uint32_t f = start[v];
    for (std::uint32_t i = 0; i < degree; ++i) {
      if (f == kNoFace || (i > 0 && f == start[v]))
        throw Error(ExitCode::kInternal,
                    "base mesh: vertex " + std::to_string(v) + " is not a manifold point");
      ring_[vertex_first_[v] + i] = f;
      f = neighbors_[f][(corner_of(f, v) + 1) % 3];
    }
  }
}

void BaseDomain::label_components() {
  component_.assign(faces_.size(), kNoFace);
  component_count_ = 0;
  std::vector<std::uint32_t> stack;
  for (std::uint32_t seed = 0; seed < faces_.size(); ++seed) {
    if (component_[seed] != kNoFace) continue;
    component_[seed] = static_cast<std::uint32_t>(component_count_);
    stack.push_back(seed);
    while (!stack.empty()) {
      const std::uint32_t f = stack.back();
      stack.pop_back();
      for (const std::uint32_t g : neighbors_[f])
        if (g != kNoFace && component_[g] == kNoFace) {
          component_[g] = component_[f];
          stack.push_back(g);
        }
    }
    ++component_count_;
  }
}

void BaseDomain::build_neighborhoods() {
  std::vector<std::vector<std::pair<std::uint32_t, ChartMap>>> near(faces_.size());
  parallel_for(faces_.size(), [&](std::size_t f) {
    auto& found = near[f];
    found.push_back({static_cast<std::uint32_t>(f), ChartMap{}});
    for (std::size_t head = 0; head < found.size(); ++head) {
      const auto [g, map] = found[head];
      if (map.hops == kUnfoldHops) break;
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t h = neighbors_[g][k];
        if (h == kNoFace) continue;
        if (std::any_of(found.begin(), found.end(), [h](const auto& entry) { return entry.first == h; }))
          continue;
        found.push_back({h, compose(map, hinges_[g][k])});
      }
    }
    std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  });
  near_first_.assign(faces_.size() + 1, 0);
  for (std::size_t f = 0; f < faces_.size(); ++f) near_first_[f + 1] = near_first_[f] + near[f].size();
  near_face_.resize(near_first_.back());
  near_map_.resize(near_first_.back());
  for (std::size_t f = 0; f < faces_.size(); ++f)
    for (std::size_t i = 0; i < near[f].size(); ++i) {
      near_face_[near_first_[f] + i] = near[f][i].first;
      near_map_[near_first_[f] + i] = near[f][i].second;
    }
}

std::uint32_t BaseDomain::cone_at(const DomainPoint& p) const {
  for (int k = 0; k < 3; ++k)
    if (p.at == kFaceCorners[k]) return faces_[p.face][k];
  return kNoVertex;
}

DomainPoint BaseDomain::cone_point(std::uint32_t vertex) const {
  const std::uint32_t f = faces_around(vertex).front();
  return {f, kFaceCorners[corner_of(f, vertex)]};
}

const ChartMap* BaseDomain::find_map(std::uint32_t from, std::uint32_t to) const {
  const auto faces = nearby_faces(to);
  const auto it = std::lower_bound(faces.begin(), faces.end(), from);
  if (it == faces.end() || *it != from) return nullptr;
  return &near_map_[near_first_[to] + static_cast<std::size_t>(it - faces.begin())];
}

std::optional<ChartPoint> BaseDomain::unfold(const DomainPoint& p, std::uint32_t f, int* hops) const {
  if (p.face == f) {
    if (hops) *hops = 0;
    return p.at;
  }
  const std::uint32_t cone = cone_at(p);
  if (cone == kNoVertex) {
    const ChartMap* map = find_map(p.face, f);
    if (!map) return std::nullopt;
    if (hops) *hops = map->hops;
    return (*map)(p.at);
  }
  const ChartMap* best = nullptr;
  std::uint32_t best_face = kNoFace;
  for (const std::uint32_t g : faces_around(cone)) {
    const ChartMap* map = find_map(g, f);
    if (map && (!best || map->hops < best->hops)) {
      best = map;
      best_face = g;
    }
  }
  if (!best) return std::nullopt;
  if (hops) *hops = best->hops;
  return (*best)(kFaceCorners[corner_of(best_face, cone)]);
}

DomainPoint BaseDomain::normalize(std::uint32_t f, const ChartPoint& p) const {
  ChartPoint at = snap_to_grid(p);
  // A point of the surface moves by less than a few faces at a time; the bound only guards against a walk
  // that circles a cone for ever.
  for (int step = 0; step < kMaximumWalk; ++step) {
    const double b[3] = {(1.0 - at.u) - at.v, at.u, at.v};
    int exit = -1;
    for (int k = 0; k < 3; ++k)
      if (b[k] < 0 && neighbors_[f][k] != kNoFace && (exit < 0 || b[k] < b[exit])) exit = k;
    if (exit < 0) break;
    const int entry = side_towards(neighbors_[f][exit], f, exit);
    const std::uint32_t next = neighbors_[f][exit];
    at = hinges_[next][entry](at);
    f = next;
  }
  return clamp_to_face(f, at);
}

DomainPoint BaseDomain::walk(std::uint32_t f, const ChartPoint& start, const ChartPoint& target,
                             ChartMap* to_start) const {
  ChartPoint from = start, at = snap_to_grid(target);
  ChartMap back;
  int entry = -1;
  for (int step = 0; step < kMaximumWalk; ++step) {
    const double b[3] = {(1.0 - at.u) - at.v, at.u, at.v};
    const double a[3] = {(1.0 - from.u) - from.v, from.u, from.v};
    int exit = -1;
    double first = 0;
    for (int k = 0; k < 3; ++k) {
      if (k == entry || b[k] >= 0) continue;
      const double crossing = a[k] / (a[k] - b[k]);
      if (exit < 0 || crossing < first) {
        exit = k;
        first = crossing;
      }
    }
    if (exit < 0 || neighbors_[f][exit] == kNoFace) break;
    const std::uint32_t next = neighbors_[f][exit];
    back = compose(back, hinges_[f][exit]);
    entry = side_towards(next, f, exit);
    at = hinges_[next][entry](at);
    from = hinges_[next][entry](from);
    f = next;
  }
  back.hops = 0;
  if (to_start) *to_start = back;
  return clamp_to_face(f, at);
}

int BaseDomain::side_towards(std::uint32_t from, std::uint32_t to, int side) const {
  for (int j = 0; j < 3; ++j)
    if (neighbors_[from][j] == to && faces_[from][(j + 1) % 3] == faces_[to][(side + 2) % 3]) return j;
  return 0;
}

DomainPoint BaseDomain::clamp_to_face(std::uint32_t f, ChartPoint at) {
  double b[3] = {(1.0 - at.u) - at.v, at.u, at.v};
  if (b[0] >= 0 && b[1] >= 0 && b[2] >= 0) return {f, at};
  for (double& x : b) x = std::max(0.0, x);
  const double sum = b[0] + b[1] + b[2];
  at = snap_to_grid({b[1] / sum, b[2] / sum});
  if (b[0] == 0) at.v = 1.0 - at.u;
  return {f, at};
}

std::uint32_t BaseDomain::common_chart(std::span<const DomainPoint> points) const {
  std::uint32_t best_face = kNoFace;
  int best_hops = std::numeric_limits<int>::max();
  const auto consider = [&](std::uint32_t f) {
    int total = 0;
    for (const DomainPoint& p : points) {
      int hops = 0;
      if (!unfold(p, f, &hops)) return;
      total += hops;
      if (total >= best_hops) return;
    }
    best_hops = total;
    best_face = f;
  };
  bool only_cones = true;
  for (const DomainPoint& p : points)
    if (cone_at(p) == kNoVertex) {
      only_cones = false;
      consider(p.face);
    }
  if (only_cones)
    for (const DomainPoint& p : points)
      for (const std::uint32_t f : faces_around(cone_at(p))) consider(f);
  return best_face;
}

std::optional<ChartTriangle> BaseDomain::unfold_triangle(const DomainPoint& a, const DomainPoint& b,
                                                         const DomainPoint& c) const {
  const DomainPoint points[3] = {a, b, c};
  const std::uint32_t f = common_chart(points);
  if (f == kNoFace) return std::nullopt;
  return ChartTriangle{f, {*unfold(a, f), *unfold(b, f), *unfold(c, f)}};
}

}  // namespace nmc
