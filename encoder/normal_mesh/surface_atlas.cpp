// SPDX-License-Identifier: Apache-2.0
#include "encoder/normal_mesh/surface_atlas.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "encoder/core/parallel.h"

namespace nmc {

namespace {

constexpr std::uint32_t kLeafSize = 4;
// Rounding of a barycentric coordinate of a well-shaped triangle is near 1e-16; the neighbour on the other
// side of the edge disagrees about the surface point by this share of a triangle at most.
constexpr double kInsideTolerance = 1e-12;

/// The part of the segment from p to q that lies in the counter-clockwise triangle has positive length.
bool crosses(const std::array<ChartPoint, 3>& triangle, const ChartPoint& p, const ChartPoint& q) {
  double enter = 0, leave = 1;
  for (int i = 0; i < 3; ++i) {
    const ChartPoint& a = triangle[i];
    const ChartPoint& b = triangle[(i + 1) % 3];
    const double at_p = face_ratio(a, b, p), at_q = face_ratio(a, b, q);
    if (at_p < 0 && at_q < 0) return false;
    if (at_p < 0) {
      enter = std::max(enter, at_p / (at_p - at_q));
    } else if (at_q < 0) {
      leave = std::min(leave, at_p / (at_p - at_q));
    }
  }
  return leave > enter;
}

struct Barycentric {
  double value[3] = {0, 0, 0};
  double smallest() const { return std::min({value[0], value[1], value[2]}); }
};

/// Of `p` in a triangle of any orientation; false where the triangle has no area.
bool barycentric_of(const std::array<ChartPoint, 3>& c, const ChartPoint& p, Barycentric& result) {
  const double area = face_ratio(c[0], c[1], c[2]);
  if (area == 0) return false;
  result.value[0] = face_ratio(p, c[1], c[2]) / area;
  result.value[1] = face_ratio(c[0], p, c[2]) / area;
  result.value[2] = (1.0 - result.value[0]) - result.value[1];
  return true;
}

SurfaceLocation location_of(std::uint32_t triangle, const Barycentric& b) {
  SurfaceLocation location{triangle, {}};
  double sum = 0;
  for (int k = 0; k < 3; ++k) sum += location.barycentric[k] = std::max(0.0, b.value[k]);
  for (double& value : location.barycentric) value /= sum;
  return location;
}

double inner_product(const ChartPoint& a, const ChartPoint& b) {
  return a.u * b.u + 0.5 * (a.u * b.v + a.v * b.u) + a.v * b.v;
}

/// The nearest point of a triangle's border, as barycentric coordinates; returns its squared distance.
double nearest_on_border(const std::array<ChartPoint, 3>& c, const ChartPoint& p, Barycentric& result) {
  double best = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const ChartPoint direction = c[j] - c[i];
    const double length = squared_length(direction);
    const double t = length > 0 ? std::clamp(inner_product(p - c[i], direction) / length, 0.0, 1.0) : 0.0;
    const double d = squared_length(p - (c[i] + t * direction));
    if (d < best) {
      best = d;
      result = {};
      result.value[i] = 1 - t;
      result.value[j] = t;
    }
  }
  return best;
}

/// Which of the neighbour's edges leads back.
int returning_edge(const BaseDomain& domain, std::uint32_t from, int k, std::uint32_t to) {
  for (int j = 0; j < 3; ++j) {
    if (domain.neighbor(to, j) == from && domain.face(to)[(j + 1) % 3] == domain.face(from)[(k + 2) % 3])
      return j;
  }
  return 0;
}

}  // namespace

SurfaceAtlas::SurfaceAtlas(const Parameterization& parameterization) : parameterization_(&parameterization) {
  const BaseDomain& domain = parameterization.domain;
  const auto triangle_count = static_cast<std::uint32_t>(parameterization.surface->triangle_count());
  const auto face_count = static_cast<std::uint32_t>(domain.face_count());

  struct Overlap {
    std::uint32_t face;
    Entry entry;
  };
  constexpr std::uint32_t kBlock = 4096;
  const std::size_t block_count = (triangle_count + kBlock - 1) / kBlock;
  std::vector<std::vector<Overlap>> overlaps(block_count);
  std::vector<std::size_t> folded(block_count, 0);
  oneapi::tbb::parallel_for(std::size_t{0}, block_count, [&](std::size_t block) {
    std::vector<std::uint32_t> faces;
    std::vector<ChartMap> maps;
    const auto end = static_cast<std::uint32_t>(std::min<std::size_t>(triangle_count, (block + 1) * kBlock));
    for (auto triangle = static_cast<std::uint32_t>(block * kBlock); triangle < end; ++triangle) {
      overlapped_faces(triangle, faces, maps);
      for (std::size_t i = 0; i < faces.size(); ++i)
        overlaps[block].push_back({faces[i], {triangle, maps[i]}});
      const auto c = parameterization.unfold(triangle).corners;
      if (face_ratio(c[0], c[1], c[2]) <= 0) ++folded[block];
    }
  });
  folded_triangle_count_ = std::accumulate(folded.begin(), folded.end(), std::size_t{0});

  face_entries_.assign(face_count + 1, 0);
  for (const auto& block : overlaps)
    for (const Overlap& overlap : block) ++face_entries_[overlap.face + 1];
  std::partial_sum(face_entries_.begin(), face_entries_.end(), face_entries_.begin());
  entries_.resize(face_entries_.back());
  std::vector<std::uint32_t> next(face_entries_.begin(), face_entries_.end() - 1);
  for (auto& block : overlaps) {
    for (const Overlap& overlap : block) entries_[next[overlap.face]++] = overlap.entry;
    std::vector<Overlap>().swap(block);
  }

  std::vector<std::vector<Node>> trees(face_count);
  oneapi::tbb::parallel_for(0u, face_count, [&](std::uint32_t face) { build_tree(face, trees[face]); });
  face_nodes_.assign(face_count + 1, 0);
  for (std::uint32_t f = 0; f < face_count; ++f)
    face_nodes_[f + 1] = face_nodes_[f] + static_cast<std::uint32_t>(trees[f].size());
  nodes_.reserve(face_nodes_.back());
  for (const auto& tree : trees) nodes_.insert(nodes_.end(), tree.begin(), tree.end());

  std::vector<std::uint32_t> base_vertex_of(parameterization.surface->vertex_count(), kNoVertex);
  for (std::size_t i = 0; i < parameterization.base_vertex_ids.size(); ++i)
    base_vertex_of[parameterization.base_vertex_ids[i]] = static_cast<std::uint32_t>(i);
  cones_.resize(domain.vertex_count());
  for (std::uint32_t t = triangle_count; t-- > 0;) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t cone = base_vertex_of[parameterization.surface->triangles[t][k]];
      if (cone == kNoVertex) continue;
      cones_[cone] = {t, {0, 0, 0}};
      cones_[cone].barycentric[k] = 1;
    }
  }
  gather_curves();
}

std::array<ChartPoint, 3> SurfaceAtlas::corners(const Entry& entry) const {
  std::array<ChartPoint, 3> c = parameterization_->unfold(entry.triangle).corners;
  for (ChartPoint& p : c) p = entry.map(p);
  return c;
}

void SurfaceAtlas::overlapped_faces(std::uint32_t triangle, std::vector<std::uint32_t>& faces,
                                    std::vector<ChartMap>& maps) const {
  const BaseDomain& domain = parameterization_->domain;
  faces.clear();
  maps.clear();
  const ChartTriangle home = parameterization_->unfold(triangle);
  const auto laid_out = [&home](const ChartMap& map) {
    std::array<ChartPoint, 3> c = {map(home.corners[0]), map(home.corners[1]), map(home.corners[2])};
    if (face_ratio(c[0], c[1], c[2]) < 0) std::swap(c[1], c[2]);
    return c;
  };
  const auto step = [&domain](std::uint32_t& face, ChartMap& map, int k) {
    const std::uint32_t next = domain.neighbor(face, k);
    map = compose(domain.hinge(next, returning_edge(domain, face, k, next)), map);
    face = next;
  };

  std::uint32_t face = home.face;
  ChartMap map;
  const ChartPoint center = (1.0 / 3) * (home.corners[0] + home.corners[1] + home.corners[2]);
  for (int hop = 0; hop < 64; ++hop) {
    const ChartPoint p = map(center);
    const double b[3] = {(1.0 - p.u) - p.v, p.u, p.v};
    const int k = static_cast<int>(std::min_element(b, b + 3) - b);
    if (b[k] >= 0 || domain.neighbor(face, k) == kNoFace) break;
    step(face, map, k);
  }

  faces.push_back(face);
  maps.push_back(map);
  for (std::size_t i = 0; i < faces.size() && faces.size() < 64; ++i) {
    const auto c = laid_out(maps[i]);
    for (int k = 0; k < 3; ++k) {
      if (domain.neighbor(faces[i], k) == kNoFace) continue;
      if (!crosses(c, kFaceCorners[(k + 1) % 3], kFaceCorners[(k + 2) % 3])) continue;
      std::uint32_t next = faces[i];
      ChartMap next_map = maps[i];
      step(next, next_map, k);
      bool known = false;
      for (std::size_t j = 0; j < faces.size() && !known; ++j) {
        known = faces[j] == next && maps[j].turns == next_map.turns && maps[j].tu == next_map.tu &&
                maps[j].tv == next_map.tv;
      }
      if (known) continue;
      faces.push_back(next);
      maps.push_back(next_map);
    }
  }
}

void SurfaceAtlas::build_tree(std::uint32_t face, std::vector<Node>& nodes) {
  struct Item {
    Entry entry;
    float low[2], high[2];
    float center(int axis) const { return low[axis] + high[axis]; }
  };
  const std::uint32_t first = face_entries_[face], last = face_entries_[face + 1];
  if (first == last) return;
  std::vector<Item> items(last - first);
  for (std::uint32_t i = first; i < last; ++i) {
    Item& item = items[i - first];
    item.entry = entries_[i];
    const auto c = corners(entries_[i]);
    // One float step outward covers the rounding of the conversion.
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    item.low[0] = std::nextafter(static_cast<float>(std::min({c[0].u, c[1].u, c[2].u})), -kInfinity);
    item.low[1] = std::nextafter(static_cast<float>(std::min({c[0].v, c[1].v, c[2].v})), -kInfinity);
    item.high[0] = std::nextafter(static_cast<float>(std::max({c[0].u, c[1].u, c[2].u})), kInfinity);
    item.high[1] = std::nextafter(static_cast<float>(std::max({c[0].v, c[1].v, c[2].v})), kInfinity);
  }
  struct Task {
    std::uint32_t begin, end, parent;  // parent: node whose link is this node, or kNoFace
  };
  std::vector<Task> stack = {{0, last - first, kNoFace}};
  while (!stack.empty()) {
    const Task task = stack.back();
    stack.pop_back();
    const auto index = static_cast<std::uint32_t>(nodes.size());
    if (task.parent != kNoFace) nodes[task.parent].link = index;
    Node node{items[task.begin].low[0],
              items[task.begin].low[1],
              items[task.begin].high[0],
              items[task.begin].high[1],
              0,
              0};
    for (std::uint32_t i = task.begin; i < task.end; ++i) {
      node.low_u = std::min(node.low_u, items[i].low[0]);
      node.low_v = std::min(node.low_v, items[i].low[1]);
      node.high_u = std::max(node.high_u, items[i].high[0]);
      node.high_v = std::max(node.high_v, items[i].high[1]);
    }
    if (task.end - task.begin <= kLeafSize) {
      node.link = first + task.begin;
      node.count = task.end - task.begin;
      nodes.push_back(node);
      continue;
    }
    nodes.push_back(node);
    const int axis = node.high_u - node.low_u >= node.high_v - node.low_v ? 0 : 1;
    const std::uint32_t middle = (task.begin + task.end) / 2;
    std::nth_element(items.begin() + task.begin, items.begin() + middle, items.begin() + task.end,
                     [axis](const Item& a, const Item& b) {
                       if (a.center(axis) != b.center(axis)) return a.center(axis) < b.center(axis);
                       return a.entry.triangle < b.entry.triangle;
                     });
    stack.push_back({middle, task.end, index});
    stack.push_back({task.begin, middle, kNoFace});  // on top: becomes the next node
  }
  for (std::uint32_t i = first; i < last; ++i) entries_[i] = items[i - first].entry;
}

struct SurfaceAtlas::Best {
  SurfaceLocation location;
  bool inside = false;
  double squared_distance = std::numeric_limits<double>::infinity();
};

SurfaceLocation SurfaceAtlas::locate(const DomainPoint& point) const {
  const std::uint32_t cone = parameterization_->domain.cone_at(point);
  if (cone != kNoVertex) return cones_[cone];
  const Node* nodes = nodes_.data() + face_nodes_[point.face];
  if (face_nodes_[point.face] == face_nodes_[point.face + 1]) return {};
  const ChartPoint& p = point.at;

  // A path of the tree is at most log2 of the entries of one face long, and each step leaves one sibling
  // behind.
  std::uint32_t stack[64];
  int depth = 0;
  stack[depth++] = 0;
  Best folded;
  while (depth > 0) {
    const std::uint32_t index = stack[--depth];
    const Node& node = nodes[index];
    if (p.u < node.low_u || p.u > node.high_u || p.v < node.low_v || p.v > node.high_v) continue;
    if (node.count == 0) {
      stack[depth++] = node.link;
      stack[depth++] = index + 1;
      continue;
    }
    for (std::uint32_t i = node.link; i < node.link + node.count; ++i) {
      const auto c = corners(entries_[i]);
      Barycentric b;
      if (!barycentric_of(c, p, b) || b.smallest() < -kInsideTolerance) continue;
      if (face_ratio(c[0], c[1], c[2]) > 0) return location_of(entries_[i].triangle, b);
      if (!folded.inside) folded = {location_of(entries_[i].triangle, b), true, 0};
    }
  }
  if (folded.inside) return folded.location;

  Best best;
  depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const std::uint32_t index = stack[--depth];
    const Node& node = nodes[index];
    const double du = std::max({node.low_u - p.u, p.u - node.high_u, 0.0});
    const double dv = std::max({node.low_v - p.v, p.v - node.high_v, 0.0});
    // In lattice coordinates |(u, v)|^2 >= 3/4 max(u, v)^2.
    if (0.75 * std::max(du * du, dv * dv) > best.squared_distance) continue;
    if (node.count == 0) {
      stack[depth++] = node.link;
      stack[depth++] = index + 1;
      continue;
    }
    for (std::uint32_t i = node.link; i < node.link + node.count; ++i) {
      Barycentric b;
      const double d = nearest_on_border(corners(entries_[i]), p, b);
      if (d > best.squared_distance) continue;
      if (d == best.squared_distance && entries_[i].triangle > best.location.triangle) continue;
      best.squared_distance = d;
      best.location = location_of(entries_[i].triangle, b);
    }
  }
  if (best.squared_distance > 1e-18) nearest_triangle_count_.fetch_add(1, std::memory_order_relaxed);
  return best.location;
}

DomainPoint SurfaceAtlas::domain_point(const SurfaceLocation& location) const {
  return parameterization_->domain_point(location.triangle, location.barycentric);
}

std::optional<ChartPoint> SurfaceAtlas::chart_point(const SurfaceLocation& location,
                                                    std::uint32_t face) const {
  const ChartTriangle triangle = parameterization_->unfold(location.triangle);
  ChartPoint at;
  for (int k = 0; k < 3; ++k) at = at + location.barycentric[k] * triangle.corners[k];
  if (triangle.face == face) return at;
  const ChartMap* map = parameterization_->domain.find_map(triangle.face, face);
  if (!map) return std::nullopt;
  return (*map)(at);
}

void SurfaceAtlas::gather_curves() {
  const BaseDomain& domain = parameterization_->domain;
  const auto face_count = static_cast<std::uint32_t>(domain.face_count());
  slot_knots_.assign(std::size_t{3} * face_count + 1, 0);
  bool any = false;
  for (std::uint32_t f = 0; f < face_count && !any; ++f)
    for (int k = 0; k < 3; ++k) any = any || domain.edge_tag(f, k) != EdgeTag::kSmooth;
  if (!any) return;

  struct Found {
    std::uint32_t slot;
    CurveKnot knot;
  };
  std::vector<Found> found;
  const auto add = [&](std::uint32_t f, int k, double share, std::uint32_t vertex) {
    const std::uint32_t other = domain.neighbor(f, k);
    if (other != kNoFace && other < f) {
      k = returning_edge(domain, f, k, other);
      f = other;
      share = 1 - share;
    }
    found.push_back({3 * f + static_cast<std::uint32_t>(k), {share, vertex}});
  };
  const auto& points = parameterization_->vertex_points;
  for (std::uint32_t v = 0; v < points.size(); ++v) {
    if (domain.cone_at(points[v]) != kNoVertex) continue;
    const auto b = points[v].barycentric();
    for (int k = 0; k < 3; ++k) {
      if (b[k] == 0 && domain.edge_tag(points[v].face, k) != EdgeTag::kSmooth) {
        add(points[v].face, k, b[(k + 2) % 3], v);
      }
    }
  }
  for (std::uint32_t f = 0; f < face_count; ++f) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t other = domain.neighbor(f, k);
      if (domain.edge_tag(f, k) == EdgeTag::kSmooth || (other != kNoFace && other < f)) continue;
      add(f, k, 0, parameterization_->base_vertex_ids[domain.face(f)[(k + 1) % 3]]);
      add(f, k, 1, parameterization_->base_vertex_ids[domain.face(f)[(k + 2) % 3]]);
    }
  }
  std::sort(found.begin(), found.end(), [](const Found& a, const Found& b) {
    if (a.slot != b.slot) return a.slot < b.slot;
    if (a.knot.share != b.knot.share) return a.knot.share < b.knot.share;
    return a.knot.vertex < b.knot.vertex;
  });
  knots_.reserve(found.size());
  for (const Found& item : found) {
    ++slot_knots_[item.slot + 1];
    knots_.push_back(item.knot);
  }
  std::partial_sum(slot_knots_.begin(), slot_knots_.end(), slot_knots_.begin());
}

std::vector<CurveKnot> SurfaceAtlas::curve(std::uint32_t f, int k) const {
  const BaseDomain& domain = parameterization_->domain;
  const std::uint32_t other = domain.neighbor(f, k);
  const bool reversed = other != kNoFace && other < f;
  const std::uint32_t slot = reversed
                                 ? 3 * other + static_cast<std::uint32_t>(returning_edge(domain, f, k, other))
                                 : 3 * f + static_cast<std::uint32_t>(k);
  std::vector<CurveKnot> result(knots_.begin() + slot_knots_[slot], knots_.begin() + slot_knots_[slot + 1]);
  if (reversed) {
    std::reverse(result.begin(), result.end());
    for (CurveKnot& knot : result) knot.share = 1 - knot.share;
  }
  return result;
}

}  // namespace nmc
