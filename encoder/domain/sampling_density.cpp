// SPDX-License-Identifier: Apache-2.0
#include "encoder/domain/sampling_density.h"

#include <algorithm>
#include <cmath>

#include "encoder/core/parallel.h"

namespace nmc {
namespace {

using Corner = CornerTable::Corner;

/// Calls visit(neighbour) for the ring of v.
template <class Visit>
void for_each_neighbor(const CornerTable& table, std::uint32_t v, const Visit& visit) {
  const Corner first = table.corner_at(v);
  Corner c = first;
  do {
    const std::uint32_t w = table.vertex(CornerTable::next(c));
    if (!table.is_ghost_vertex(w)) visit(w);
    c = table.rotate(c);
  } while (c != first);
}

}  // namespace

std::vector<double> curvature_density(const SurfaceMap& map, double exponent, double maximum) {
  const CornerTable& table = map.table();
  const std::size_t count = table.real_vertex_count();
  std::vector<double> density(count, 1.0);
  std::vector<std::uint32_t> live;
  for (std::uint32_t v = 0; v < count; ++v)
    if (table.corner_at(v) != CornerTable::kNone) live.push_back(v);

  // Mean squared normal curvature over the edges of each vertex.
  std::vector<double> curvature(live.size()), area(live.size());
  parallel_for(live.size(), [&](std::size_t i) {
    const std::uint32_t v = live[i];
    const Vec3& p = map.position(v);
    Vec3 normal;
    const Corner first = table.corner_at(v);
    Corner c = first;
    do {
      if (!table.is_ghost_face(CornerTable::face_of(c)))
        normal += cross(map.position(table.vertex(CornerTable::next(c))) - p,
                        map.position(table.vertex(CornerTable::previous(c))) - p);
      c = table.rotate(c);
    } while (c != first);
    area[i] = norm(normal);
    normal = normalized(normal, {0, 0, 0});
    double sum = 0;
    int edges = 0;
    for_each_neighbor(table, v, [&](std::uint32_t w) {
      const Vec3 edge = map.position(w) - p;
      const double squared = squared_norm(edge);
      if (!(squared > 0)) return;
      const double k = 2 * dot(normal, edge) / squared;
      sum += k * k;
      ++edges;
    });
    curvature[i] = edges > 0 ? sum / edges : 0;
  });

  // The reference is the curvature that half of the area stays below.
  std::vector<std::size_t> order(live.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return curvature[a] != curvature[b] ? curvature[a] < curvature[b] : a < b;
  });
  double total = 0;
  for (const double a : area) total += a;
  double reference = 0, below = 0;
  for (const std::size_t i : order) {
    below += area[i];
    reference = curvature[i];
    if (below >= 0.5 * total) break;
  }
  if (!(reference > 0)) return density;

  std::vector<double> level(count, 0.0), smooth(count, 0.0);
  for (std::size_t i = 0; i < live.size(); ++i)
    level[live[i]] = exponent * std::log((curvature[i] + 0.25 * reference) / (0.25 * reference));
  for (int pass = 0; pass < 2; ++pass) {
    parallel_for(live.size(), [&](std::size_t i) {
      double sum = level[live[i]], weight = 1;
      for_each_neighbor(table, live[i], [&](std::uint32_t w) {
        sum += 0.5 * level[w];
        weight += 0.5;
      });
      smooth[live[i]] = sum / weight;
    });
    level.swap(smooth);
  }
  for (const std::uint32_t v : live) density[v] = std::min(std::exp(level[v]), maximum);
  return density;
}

}  // namespace nmc
