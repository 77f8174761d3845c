// SPDX-License-Identifier: Apache-2.0
#include "encoder/sphere/collapse_hierarchy.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "encoder/core/error.h"

namespace nmc {

CollapseHierarchy::Quadric& CollapseHierarchy::Quadric::operator+=(const Quadric& other) {
  for (int i = 0; i < 10; ++i) a[i] += other.a[i];
  return *this;
}

double CollapseHierarchy::Quadric::value(const Vec3& p) const {
  return a[0] * p.x * p.x + 2 * a[1] * p.x * p.y + 2 * a[2] * p.x * p.z + 2 * a[3] * p.x + a[4] * p.y * p.y +
         2 * a[5] * p.y * p.z + 2 * a[6] * p.y + a[7] * p.z * p.z + 2 * a[8] * p.z + a[9];
}

// std::push_heap keeps the greatest on top, so the cheapest is the greatest. Ties by index: deterministic.
bool CollapseHierarchy::Candidate::operator<(const Candidate& other) const {
  if (cost != other.cost) return cost > other.cost;
  if (from != other.from) return from > other.from;
  return to > other.to;
}

CollapseHierarchy::CollapseHierarchy(const std::vector<Vec3>& positions,
                                     const std::vector<Triangle>& triangles,
                                     const CollapseHierarchyOptions& options)
    : options_(options), positions_(positions) {
  const std::uint32_t vertex_count = static_cast<std::uint32_t>(positions.size());
  Vec3 minimum, maximum;
  if (!positions.empty()) minimum = maximum = positions[0];
  for (const Vec3& p : positions) {
    if (!is_finite(p)) throw Error(ExitCode::kInvalidInput, "a vertex of the surface is not finite");
    for (int k = 0; k < 3; ++k) {
      minimum[k] = std::min(minimum[k], p[k]);
      maximum[k] = std::max(maximum[k], p[k]);
    }
  }
  const double diagonal = distance(minimum, maximum);
  if (!(diagonal > 0))
    throw Error(ExitCode::kUnsupported, "a sphere cannot be mapped to a surface without extent");
  for (Vec3& p : positions_) p = (p - minimum) / diagonal;

  half_edge_.assign(vertex_count, kDead);
  connect(triangles);
  live_count_ = vertex_count;
  face_is_dead_.assign(triangles.size(), false);
  stamps_.assign(vertex_count, 0);
  marks_.assign(vertex_count, 0);

  quadrics_.resize(vertex_count);
  for (std::size_t f = 0; f < triangles.size(); ++f) {
    const Vec3& p = positions_[triangles[f][0]];
    const Vec3 n = cross(positions_[triangles[f][1]] - p, positions_[triangles[f][2]] - p);
    const double area = norm(n);
    if (!(area > 0)) continue;
    const double plane[4] = {n.x / area, n.y / area, n.z / area, -dot(n, p) / area};
    Quadric quadric;
    int index = 0;
    for (int i = 0; i < 4; ++i)
      for (int j = i; j < 4; ++j) quadric.a[index++] = area * plane[i] * plane[j];
    for (const std::uint32_t v : triangles[f]) quadrics_[v] += quadric;
  }
  for (std::uint32_t v = 0; v < vertex_count; ++v) push_best(v, false, true);
}

void CollapseHierarchy::connect(const std::vector<Triangle>& triangles) {
  const auto refuse = [](const char* why) {
    throw Error(ExitCode::kUnsupported,
                std::string("only a closed surface of genus 0 maps to the sphere: ") + why);
  };
  const std::uint64_t vertex_count = half_edge_.size();
  if (vertex_count < 4) refuse("it has fewer than 4 vertices");
  const std::uint32_t half_edge_count = static_cast<std::uint32_t>(3 * triangles.size());
  origin_.resize(half_edge_count);
  opposite_.assign(half_edge_count, kDead);
  std::vector<std::uint32_t> degree(vertex_count, 0);
  for (std::uint32_t f = 0; f < triangles.size(); ++f) {
    const Triangle& t = triangles[f];
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) refuse("a triangle uses a vertex twice");
    for (int k = 0; k < 3; ++k) {
      if (t[k] >= vertex_count) refuse("a triangle refers to a vertex that does not exist");
      origin_[3 * f + k] = t[k];
      half_edge_[t[k]] = 3 * f + k;
      ++degree[t[k]];
    }
  }
  // Half-edges sorted by their unordered pair of vertices: exactly two of each, in opposite directions.
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keyed(half_edge_count);
  for (std::uint32_t h = 0; h < half_edge_count; ++h) {
    const std::uint64_t a = origin_[h], b = target(h);
    keyed[h] = {std::min(a, b) * vertex_count + std::max(a, b), h};
  }
  std::sort(keyed.begin(), keyed.end());
  for (std::size_t i = 0; i < keyed.size(); i += 2) {
    if (i + 1 == keyed.size() || keyed[i].first != keyed[i + 1].first) refuse("it has a boundary");
    if (i + 2 < keyed.size() && keyed[i].first == keyed[i + 2].first)
      refuse("more than two triangles meet at an edge");
    const std::uint32_t g = keyed[i].second, h = keyed[i + 1].second;
    if (origin_[g] == origin_[h]) refuse("its triangles are not oriented consistently");
    opposite_[g] = h;
    opposite_[h] = g;
  }
  for (std::uint32_t v = 0; v < vertex_count; ++v) {
    if (half_edge_[v] == kDead) refuse("a vertex belongs to no triangle");
    std::uint32_t count = 0;
    std::uint32_t h = half_edge_[v];
    do {
      ++count;
      h = rotate(h);
    } while (h != half_edge_[v] && count <= degree[v]);
    if (count != degree[v]) refuse("the triangles around a vertex form more than one fan");
  }
  // V - E + F = 2 with E = 3 F / 2; two components would have 4, unless handles make up for them, so flood
  // too.
  if (2 * vertex_count != triangles.size() + 4) refuse("its Euler characteristic is not 2");
  std::vector<bool> seen(triangles.size(), false);
  std::vector<std::uint32_t> stack{0};
  seen[0] = true;
  std::size_t seen_count = 1;
  while (!stack.empty()) {
    const std::uint32_t f = stack.back();
    stack.pop_back();
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t g = opposite_[3 * f + k] / 3;
      if (seen[g]) continue;
      seen[g] = true;
      ++seen_count;
      stack.push_back(g);
    }
  }
  if (seen_count != triangles.size()) refuse("it has more than one component");
}

double CollapseHierarchy::cost(std::uint32_t from, std::uint32_t to) const {
  Quadric sum = quadrics_[from];
  sum += quadrics_[to];
  const double squared_length = squared_norm(positions_[from] - positions_[to]);
  return std::max(0.0, sum.value(positions_[to])) +
         options_.edge_length_weight * squared_length * squared_length;
}

std::uint32_t CollapseHierarchy::valence(std::uint32_t vertex) const {
  std::uint32_t count = 0;
  std::uint32_t h = half_edge_[vertex];
  do {
    ++count;
    h = rotate(h);
  } while (h != half_edge_[vertex]);
  return count;
}

void CollapseHierarchy::link(std::uint32_t vertex, std::vector<std::uint32_t>& neighbors) const {
  neighbors.clear();
  std::uint32_t h = half_edge_[vertex];
  do {
    neighbors.push_back(target(h));
    h = rotate(h);
  } while (h != half_edge_[vertex]);
}

std::uint32_t CollapseHierarchy::find_half_edge(std::uint32_t from, std::uint32_t to) const {
  std::uint32_t h = half_edge_[from];
  do {
    if (target(h) == to) return h;
    h = rotate(h);
  } while (h != half_edge_[from]);
  return kDead;
}

bool CollapseHierarchy::is_allowed(std::uint32_t half_edge, bool check_normals) const {
  const std::uint32_t from = origin_[half_edge], to = target(half_edge);
  // The link condition: exactly two common neighbors. It keeps the mesh a triangulated sphere.
  ++mark_;
  std::uint32_t h = half_edge_[from];
  do {
    marks_[target(h)] = mark_;
    h = rotate(h);
  } while (h != half_edge_[from]);
  int common = 0;
  h = half_edge_[to];
  do {
    if (marks_[target(h)] == mark_) ++common;
    h = rotate(h);
  } while (h != half_edge_[to]);
  if (common != 2) return false;
  if (!check_normals && !options_.sphere_positions) return true;

  constexpr double kMinimumCosine = 0.2;
  const std::uint32_t in_dying_face = next(opposite_[half_edge]);
  for (h = rotate(half_edge); h != half_edge; h = rotate(h)) {
    if (h == in_dying_face) continue;
    const Vec3 &p = positions_[target(h)], &q = positions_[origin_[previous(h)]];
    if (check_normals) {
      const Vec3 before = cross(p - positions_[from], q - positions_[from]);
      const Vec3 after = cross(p - positions_[to], q - positions_[to]);
      if (dot(before, after) < kMinimumCosine * norm(before) * norm(after)) return false;
    }
    if (!options_.sphere_positions) continue;
    const std::vector<Vec3>& x = *options_.sphere_positions;
    const Vec3 &a = x[to], &b = x[target(h)], &c = x[origin_[previous(h)]];
    const double longest = std::max({squared_norm(a - b), squared_norm(b - c), squared_norm(c - a)});
    // Twice the area over the square of the longest edge: 0.87 for an equilateral triangle.
    constexpr double kMinimumShape = 0.05;
    if (dot(a, cross(b - a, c - a)) < kMinimumShape * longest) return false;
  }
  return true;
}

void CollapseHierarchy::push_best(std::uint32_t vertex, bool only_allowed, bool check_normals) {
  double best_cost = std::numeric_limits<double>::infinity();
  std::uint32_t best = kDead;
  const int own_valence = static_cast<int>(valence(vertex));
  std::uint32_t h = half_edge_[vertex];
  do {
    const std::uint32_t to = target(h);
    if (!only_allowed || is_allowed(h, check_normals)) {
      double c = cost(vertex, to);
      if (own_valence + static_cast<int>(valence(to)) - 4 > options_.preferred_maximum_valence)
        c = 16 * c + 1e-9;
      if (c < best_cost || (c == best_cost && to < best)) {
        best_cost = c;
        best = to;
      }
    }
    h = rotate(h);
  } while (h != half_edge_[vertex]);
  if (best == kDead) return;
  heap_.push_back({best_cost, vertex, best, stamps_[vertex]});
  std::push_heap(heap_.begin(), heap_.end());
}

void CollapseHierarchy::collapse(std::uint32_t half_edge) {
  const std::uint32_t from = origin_[half_edge], to = target(half_edge), twin = opposite_[half_edge];
  quadrics_[to] += quadrics_[from];
  for (std::uint32_t h = rotate(half_edge); h != half_edge; h = rotate(h)) origin_[h] = to;
  origin_[half_edge] = from;
  for (const std::uint32_t side : {half_edge, twin}) {
    const std::uint32_t a = opposite_[next(side)], b = opposite_[previous(side)];
    opposite_[a] = b;
    opposite_[b] = a;
    face_is_dead_[side / 3] = true;
    half_edge_[origin_[previous(side)]] = a;  // a runs from the third corner
  }
  // Any surviving half-edge of `to`: opposite to the first glued pair.
  half_edge_[to] = opposite_[half_edge_[origin_[previous(half_edge)]]];
  half_edge_[from] = kDead;
  --live_count_;
  collapses_.push_back(half_edge);
}

std::uint32_t CollapseHierarchy::undo() {
  const std::uint32_t half_edge = collapses_.back();
  collapses_.pop_back();
  const std::uint32_t twin = opposite_[half_edge];
  const std::uint32_t vertex = origin_[half_edge];
  // The dead faces were never touched after their collapse: they still know their neighbors.
  for (const std::uint32_t side : {half_edge, twin}) {
    face_is_dead_[side / 3] = false;
    opposite_[opposite_[next(side)]] = next(side);
    opposite_[opposite_[previous(side)]] = previous(side);
  }
  for (std::uint32_t h = rotate(half_edge); h != half_edge; h = rotate(h)) origin_[h] = vertex;
  half_edge_[vertex] = half_edge;
  half_edge_[target(half_edge)] = twin;
  ++live_count_;
  return vertex;
}

void CollapseHierarchy::collapse_to(std::uint32_t vertex_count) {
  vertex_count = std::max(vertex_count, 4u);
  bool check_normals = true;
  std::vector<std::uint32_t> neighbors;
  while (live_count_ > vertex_count) {
    if (heap_.empty()) {
      // Every candidate was refused: look at all edges, first with and then without the test of normals. On a
      // triangulated sphere of more than 4 vertices the link condition always leaves an edge to collapse.
      for (std::uint32_t v = 0; v < half_edge_.size(); ++v)
        if (is_live(v)) push_best(v, true, check_normals);
      if (heap_.empty()) {
        if (!check_normals)
          throw Error(ExitCode::kInternal, "no edge of a triangulated sphere can be collapsed");
        check_normals = false;
        continue;
      }
    }
    const Candidate candidate = heap_.front();
    std::pop_heap(heap_.begin(), heap_.end());
    heap_.pop_back();
    if (!is_live(candidate.from) || !is_live(candidate.to) || candidate.stamp != stamps_[candidate.from])
      continue;
    const std::uint32_t h = find_half_edge(candidate.from, candidate.to);
    if (h == kDead) continue;
    if (!is_allowed(h, check_normals)) {
      // Queue the best of the other edges; a changed stamp makes sure that this one does not come back.
      ++stamps_[candidate.from];
      push_best(candidate.from, true, check_normals);
      continue;
    }
    link(candidate.from, neighbors);
    collapse(h);
    for (const std::uint32_t v : neighbors) {
      ++stamps_[v];
      push_best(v, false, check_normals);
    }
  }
}

HierarchyLevel CollapseHierarchy::level() const {
  HierarchyLevel level;
  std::vector<std::uint32_t> index(half_edge_.size(), kDead);
  level.vertices.reserve(live_count_);
  for (std::uint32_t v = 0; v < half_edge_.size(); ++v) {
    if (!is_live(v)) continue;
    index[v] = static_cast<std::uint32_t>(level.vertices.size());
    level.vertices.push_back(v);
  }
  level.triangles.reserve(2 * live_count_);
  for (std::size_t f = 0; f < face_is_dead_.size(); ++f)
    if (!face_is_dead_[f])
      level.triangles.push_back(
          {index[origin_[3 * f]], index[origin_[3 * f + 1]], index[origin_[3 * f + 2]]});
  return level;
}

}  // namespace nmc
