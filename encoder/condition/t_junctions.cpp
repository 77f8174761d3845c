// SPDX-License-Identifier: Apache-2.0
#include "encoder/condition/t_junctions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "encoder/core/parallel.h"

namespace nmc::conditioning {

namespace {

/// Points in a uniform grid with about one point per occupied cell row.
class PointGrid {
 public:
  PointGrid(const std::vector<Vec3>& positions, const std::vector<std::uint32_t>& points,
            double typical_length) {
    minimum_ = maximum_ = positions[points[0]];
    for (const std::uint32_t v : points)
      for (int k = 0; k < 3; ++k) {
        minimum_[k] = std::min(minimum_[k], positions[v][k]);
        maximum_[k] = std::max(maximum_[k], positions[v][k]);
      }
    // As fine as a typical edge, as coarse as four cells per point over the box allow.
    cell_ = typical_length;
    const auto cells_along = [&](int k) { return std::floor((maximum_[k] - minimum_[k]) / cell_) + 1; };
    while (cells_along(0) * cells_along(1) * cells_along(2) > 4.0 * static_cast<double>(points.size()) + 64)
      cell_ *= 1.25;
    for (int k = 0; k < 3; ++k) size_[k] = static_cast<std::int64_t>(cells_along(k));
    first_.assign(static_cast<std::size_t>(size_[0] * size_[1] * size_[2]) + 2, 0);
    for (const std::uint32_t v : points) ++first_[index_of(positions[v]) + 2];
    for (std::size_t i = 2; i < first_.size(); ++i) first_[i] += first_[i - 1];
    entries_.resize(points.size());
    for (const std::uint32_t v : points) entries_[first_[index_of(positions[v]) + 1]++] = v;
    first_.pop_back();
  }

  /// Calls visit(point) at least once for every point within `radius` of the segment. A segment that covers
  /// many cells is halved until its parts cover few, so a long diagonal costs its length, not its box.
  template <class Visit>
  void near_segment(const Vec3& a, const Vec3& b, double radius, const Visit& visit) const {
    std::int64_t low[3], high[3];
    std::int64_t cell_count = 1;
    for (int k = 0; k < 3; ++k) {
      low[k] = clamped_cell(std::min(a[k], b[k]) - radius, k);
      high[k] = clamped_cell(std::max(a[k], b[k]) + radius, k);
      cell_count *= high[k] - low[k] + 1;
    }
    if (cell_count > 12 && squared_norm(b - a) > cell_ * cell_) {
      const Vec3 middle = 0.5 * (a + b);
      near_segment(a, middle, radius, visit);
      near_segment(middle, b, radius, visit);
      return;
    }
    for (std::int64_t x = low[0]; x <= high[0]; ++x)
      for (std::int64_t y = low[1]; y <= high[1]; ++y)
        for (std::int64_t z = low[2]; z <= high[2]; ++z) {
          const auto cell = static_cast<std::size_t>((x * size_[1] + y) * size_[2] + z);
          for (std::uint32_t i = first_[cell]; i < first_[cell + 1]; ++i) visit(entries_[i]);
        }
  }

 private:
  std::int64_t clamped_cell(double x, int k) const {
    return std::clamp(static_cast<std::int64_t>(std::floor((x - minimum_[k]) / cell_)), std::int64_t{0},
                      size_[k] - 1);
  }
  std::size_t index_of(const Vec3& p) const {
    return static_cast<std::size_t>((clamped_cell(p.x, 0) * size_[1] + clamped_cell(p.y, 1)) * size_[2] +
                                    clamped_cell(p.z, 2));
  }
  Vec3 minimum_, maximum_;
  double cell_ = 0;
  std::int64_t size_[3] = {1, 1, 1};
  std::vector<std::uint32_t> first_, entries_;
};

struct Split {
  std::uint32_t open_edge;  // index in the list of open half-edges
  double parameter;         // along the half-edge, in (0, 1)
  std::uint32_t vertex;
};

using UndirectedEdge = std::uint64_t;
UndirectedEdge undirected(std::uint32_t a, std::uint32_t b) {
  return static_cast<std::uint64_t>(std::min(a, b)) << 32 | std::max(a, b);
}

/// The vertices to insert into each of a triangle's three edges, in the direction of its half-edges.
using EdgePoints = std::array<std::span<const Split>, 3>;

/// Cuts a triangle into parts that use all inserted points; every part has a side on an edge of the whole and
/// its apex off that edge, so no part is degenerate.
void subdivide(const Triangle& corners, const Triangle& stored, const EdgePoints& points,
               std::vector<std::pair<Triangle, Triangle>>& parts) {
  for (int k = 0; k < 3; ++k) {
    if (points[k].empty()) continue;
    // Edge k = (a, b) with apex c becomes a fan at c. Its first part inherits the points of (c, a), its last
    // part those of (b, c).
    const int next = (k + 1) % 3, previous = (k + 2) % 3;
    std::uint32_t from = corners[k], from_stored = stored[k];
    for (std::size_t i = 0; i <= points[k].size(); ++i) {
      const bool last = i == points[k].size();
      const std::uint32_t to = last ? corners[next] : points[k][i].vertex;
      const std::uint32_t to_stored = last ? stored[next] : points[k][i].vertex;
      EdgePoints inherited;
      if (last) inherited[1] = points[next];
      if (i == 0) inherited[2] = points[previous];
      subdivide({from, to, corners[previous]}, {from_stored, to_stored, stored[previous]}, inherited, parts);
      from = to;
      from_stored = to_stored;
    }
    return;
  }
  parts.push_back({corners, stored});
}

}  // namespace

std::size_t close_t_junctions(WorkingMesh& mesh, const EdgeGroups& edges, double radius) {
  if (!(radius > 0)) return 0;
  std::vector<std::uint32_t> open_edges;
  edges.for_each([&](std::span<const GroupedHalfEdge> group) {
    if (group.size() == 1) open_edges.push_back(group[0].half_edge());
  });
  if (open_edges.empty()) return 0;
  std::sort(open_edges.begin(), open_edges.end());
  const auto tail = [&](std::uint32_t h) -> const Vec3& {
    return mesh.positions[tail_of(mesh.triangles, h)];
  };
  const auto head = [&](std::uint32_t h) -> const Vec3& {
    return mesh.positions[head_of(mesh.triangles, h)];
  };

  std::vector<std::uint32_t> points;
  double length_sum = 0;
  {
    std::vector<std::uint8_t> is_open(mesh.positions.size(), 0);
    for (const std::uint32_t h : open_edges) {
      is_open[tail_of(mesh.triangles, h)] = is_open[head_of(mesh.triangles, h)] = 1;
      length_sum += distance(tail(h), head(h));
    }
    for (std::uint32_t v = 0; v < is_open.size(); ++v)
      if (is_open[v]) points.push_back(v);
  }
  const PointGrid grid(mesh.positions, points, length_sum / static_cast<double>(open_edges.size()));

  constexpr std::size_t kBlock = 1024;
  std::vector<std::vector<Split>> found((open_edges.size() + kBlock - 1) / kBlock);
  parallel_for(found.size(), [&](std::size_t block) {
    std::vector<Split>& splits = found[block];
    for (std::size_t i = block * kBlock; i < std::min(open_edges.size(), (block + 1) * kBlock); ++i) {
      const std::uint32_t h = open_edges[i];
      const Vec3 a = tail(h), direction = head(h) - a;
      const double squared_length = squared_norm(direction);
      const std::size_t start = splits.size();
      grid.near_segment(a, head(h), radius, [&](std::uint32_t v) {
        const Vec3 offset = mesh.positions[v] - a;
        const double along = dot(offset, direction) / squared_length;
        if (!(along > 0 && along < 1) || squared_norm(offset - along * direction) > radius * radius) return;
        // Near an end the point is a matter for welding; the apex can be this close only in a sliver.
        if (squared_norm(offset) <= radius * radius || distance(mesh.positions[v], head(h)) <= radius) return;
        if (v == apex_of(mesh.triangles, h)) return;
        splits.push_back({static_cast<std::uint32_t>(i), along, v});
      });
      std::sort(splits.begin() + static_cast<std::ptrdiff_t>(start), splits.end(),
                [](const Split& x, const Split& y) {
                  return x.parameter != y.parameter ? x.parameter < y.parameter : x.vertex < y.vertex;
                });
      // A cell may have been visited twice; points that project to the same place would give an edge of no
      // length.
      splits.erase(std::unique(splits.begin() + static_cast<std::ptrdiff_t>(start), splits.end(),
                               [&](const Split& x, const Split& y) {
                                 return (y.parameter - x.parameter) * std::sqrt(squared_length) <= radius;
                               }),
                   splits.end());
    }
  });
  std::vector<Split> splits;
  for (const std::vector<Split>& block : found) splits.insert(splits.end(), block.begin(), block.end());
  if (splits.empty()) return 0;

  // An edge is split only where one of its parts meets another open edge or a part of one.
  const auto for_each_part = [&](std::size_t first, std::size_t last, const auto& body) {
    const std::uint32_t h = open_edges[splits[first].open_edge];
    std::uint32_t from = tail_of(mesh.triangles, h);
    for (std::size_t i = first; i < last; ++i) {
      body(undirected(from, splits[i].vertex));
      from = splits[i].vertex;
    }
    body(undirected(from, head_of(mesh.triangles, h)));
  };
  const auto end_of_edge = [&](std::size_t first) {
    std::size_t last = first + 1;
    while (last < splits.size() && splits[last].open_edge == splits[first].open_edge) ++last;
    return last;
  };
  std::vector<UndirectedEdge> parts;
  for (const std::uint32_t h : open_edges)
    parts.push_back(undirected(tail_of(mesh.triangles, h), head_of(mesh.triangles, h)));
  for (std::size_t i = 0; i < splits.size(); i = end_of_edge(i))
    for_each_part(i, end_of_edge(i), [&](UndirectedEdge e) { parts.push_back(e); });
  std::sort(parts.begin(), parts.end());

  std::vector<Split> accepted;
  for (std::size_t i = 0; i < splits.size(); i = end_of_edge(i)) {
    bool meets = false;
    for_each_part(i, end_of_edge(i), [&](UndirectedEdge e) {
      const auto range = std::equal_range(parts.begin(), parts.end(), e);
      meets = meets || range.second - range.first > 1;
    });
    if (meets)
      accepted.insert(accepted.end(), splits.begin() + static_cast<std::ptrdiff_t>(i),
                      splits.begin() + static_cast<std::ptrdiff_t>(end_of_edge(i)));
  }
  if (accepted.empty()) return 0;
  mesh.note(Defect::kTJunction, [&] {
    return fmt::format("vertex {} lies inside an edge of triangle {}", accepted[0].vertex,
                       mesh.source[open_edges[accepted[0].open_edge] / 3]);
  });

  std::vector<std::pair<Triangle, Triangle>> pieces;
  for (std::size_t i = 0; i < accepted.size();) {
    const std::uint32_t t = open_edges[accepted[i].open_edge] / 3;
    EdgePoints points_of_edge;
    while (i < accepted.size() && open_edges[accepted[i].open_edge] / 3 == t) {
      std::size_t j = i;
      while (j < accepted.size() && accepted[j].open_edge == accepted[i].open_edge) ++j;
      points_of_edge[open_edges[accepted[i].open_edge] % 3] = std::span<const Split>(&accepted[i], j - i);
      i = j;
    }
    pieces.clear();
    subdivide(mesh.triangles[t], mesh.stored[t], points_of_edge, pieces);
    mesh.fate[mesh.source[t]] = TriangleFate::kSplit;
    std::tie(mesh.triangles[t], mesh.stored[t]) = pieces[0];
    for (std::size_t k = 1; k < pieces.size(); ++k) {
      mesh.triangles.push_back(pieces[k].first);
      mesh.stored.push_back(pieces[k].second);
      mesh.source.push_back(mesh.source[t]);
      mesh.is_turned.push_back(0);
    }
  }
  mesh.report.t_junctions_closed += accepted.size();
  return accepted.size();
}

}  // namespace nmc::conditioning
