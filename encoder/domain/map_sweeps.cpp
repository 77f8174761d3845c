// SPDX-License-Identifier: Apache-2.0
#include "encoder/domain/map_sweeps.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "encoder/core/parallel.h"

namespace nmc {
namespace {

using Corner = CornerTable::Corner;

constexpr double kFaceArea = 0.43301270189221932;  // of a unit equilateral triangle

/// Vertices that may move, grouped so that no two of a group are neighbours: greedy colouring in index order.
std::vector<std::vector<std::uint32_t>> color_groups(const SurfaceMap& map) {
  const CornerTable& table = map.table();
  std::vector<std::uint8_t> color(table.vertex_slot_count(), 0xff);
  std::vector<std::vector<std::uint32_t>> groups;
  for (std::uint32_t v = 0; v < table.real_vertex_count(); ++v) {
    if (table.corner_at(v) == CornerTable::kNone || map.is_cone(v)) continue;
    std::uint64_t used = 0;
    const Corner first = table.corner_at(v);
    Corner c = first;
    do {
      const std::uint8_t neighbor = color[table.vertex(CornerTable::next(c))];
      if (neighbor < 64) used |= std::uint64_t{1} << neighbor;
      c = table.rotate(c);
    } while (c != first);
    // Greedy colours exceed 63 only where one vertex has 63 neighbours of different colours; such a vertex
    // rests.
    const int lowest = std::countr_one(used);
    if (lowest >= 64) continue;
    color[v] = static_cast<std::uint8_t>(lowest);
    if (static_cast<std::size_t>(lowest) >= groups.size())
      groups.resize(static_cast<std::size_t>(lowest) + 1);
    groups[static_cast<std::size_t>(lowest)].push_back(v);
  }
  return groups;
}

struct Targets {
  std::vector<TriangleShape> shapes;  // per face slot; area replaced by the target area in the domain
  double minimum = 0;
};

Targets triangle_targets(const SurfaceMap& map, const std::vector<double>& scale) {
  const CornerTable& table = map.table();
  Targets targets;
  targets.shapes.resize(table.real_face_count());
  parallel_for(table.real_face_count(), [&](std::size_t i) {
    const auto f = static_cast<std::uint32_t>(i);
    if (!table.is_live_face(f)) return;
    const Triangle t = table.face(f);
    TriangleShape shape = triangle_shape(map.position(t[0]), map.position(t[1]), map.position(t[2]));
    double sum = 0;
    for (const std::uint32_t v : t) sum += scale[map.point(v).face] * map.density(v);
    shape.area *= sum / 3;
    targets.shapes[i] = shape;
  });
  const double total = parallel_sum<double>(table.real_face_count(), [&](std::size_t f) {
    return table.is_live_face(static_cast<std::uint32_t>(f)) ? targets.shapes[f].area : 0.0;
  });
  double count = 0;
  for (std::uint32_t f = 0; f < table.real_face_count(); ++f) count += table.is_live_face(f);
  // Degenerate surface triangles get a small target instead of an infinite stiffness.
  targets.minimum = count > 0 ? 1e-4 * total / count : 1;
  return targets;
}

void relax_vertex(SurfaceMap& map, const EnergyWeights& weights, const Targets& targets, std::uint32_t v,
                  std::vector<SurfaceMap::StarTriangle>& star) {
  map.star(v, star);
  const ChartPoint at = map.point(v).at;
  const auto [zx, zy] = to_cartesian(at);
  StarModel model;
  for (const auto& t : star) {
    const TriangleShape& shape = targets.shapes[CornerTable::face_of(t.corner)];
    const auto [qx, qy] = to_cartesian(t.q);
    const auto [rx, ry] = to_cartesian(t.r);
    model.add(weights, zx, zy, qx, qy, rx, ry, shape.cotangents[CornerTable::next(t.corner) % 3],
              shape.cotangents[CornerTable::previous(t.corner) % 3], std::max(shape.area, targets.minimum));
  }
  const bool on_chain = map.history().kinds[v] != VertexKind::kSmooth;
  const ChartPoint along = on_chain ? map.chain_direction(v) : ChartPoint{};
  std::array<double, 2> d;
  if (on_chain) {
    const auto [dx, dy] = to_cartesian(along);
    d = model.step_along(dx, dy);
  } else {
    d = model.step();
  }
  const ChartPoint full = from_cartesian(d[0], d[1]);
  const bool was_positive = SurfaceMap::is_positive(star, at);
  double length = 1;
  for (int attempt = 0; attempt < 6; ++attempt, length *= 0.5) {
    ChartPoint z = snap_to_grid(at + length * full);
    if (on_chain) {
      const double distance = along.u != 0 ? along.u * length * full.u : length * full.v;
      z = at + snap_to_grid({distance, 0}).u * along;
    }
    if (was_positive && !SurfaceMap::is_positive(star, z)) continue;
    map.move(v, z, star);
    return;
  }
}

}  // namespace

std::vector<double> domain_scale(const SurfaceMap& map, int smoothing) {
  const CornerTable& table = map.table();
  const BaseDomain& domain = map.domain();
  std::vector<double> area(domain.face_count(), 0), total(domain.component_count(), 0);
  std::vector<double> count(domain.component_count(), 0);
  for (std::uint32_t f = 0; f < table.real_face_count(); ++f) {
    if (!table.is_live_face(f)) continue;
    const Triangle t = table.face(f);
    const Vec3& a = map.position(t[0]);
    const double third = norm(cross(map.position(t[1]) - a, map.position(t[2]) - a)) / 6;
    for (const std::uint32_t v : t) area[map.point(v).face] += third * map.density(v);
  }
  for (std::uint32_t f = 0; f < domain.face_count(); ++f) {
    total[domain.component(f)] += area[f];
    count[domain.component(f)] += 1;
  }
  for (std::uint32_t f = 0; f < domain.face_count(); ++f) {
    const double mean = total[domain.component(f)] / count[domain.component(f)];
    area[f] = std::log(mean > 0 ? std::max(area[f], 0.05 * mean) : 1.0);
  }
  for (int pass = 0; pass < smoothing; ++pass) {
    std::vector<double> smooth(area.size());
    for (std::uint32_t f = 0; f < domain.face_count(); ++f) {
      double sum = 2 * area[f], weight = 2;
      for (int k = 0; k < 3; ++k)
        if (domain.neighbor(f, k) != kNoFace) {
          sum += area[domain.neighbor(f, k)];
          weight += 1;
        }
      smooth[f] = sum / weight;
    }
    area.swap(smooth);
  }
  for (double& x : area) x = kFaceArea / std::exp(x);
  return area;
}

void sweep(SurfaceMap& map, const EnergyWeights& weights, const std::vector<double>& scale, int count) {
  map.recenter_charts();
  const Targets targets = triangle_targets(map, scale);
  const auto groups = color_groups(map);
  for (int i = 0; i < count; ++i)
    for (const auto& group : groups)
      oneapi::tbb::parallel_for(oneapi::tbb::blocked_range<std::size_t>(0, group.size(), 512),
                                [&](const oneapi::tbb::blocked_range<std::size_t>& range) {
                                  std::vector<SurfaceMap::StarTriangle> star;
                                  for (std::size_t j = range.begin(); j != range.end(); ++j)
                                    relax_vertex(map, weights, targets, group[j], star);
                                });
}

}  // namespace nmc
