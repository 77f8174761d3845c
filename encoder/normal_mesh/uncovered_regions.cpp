// SPDX-License-Identifier: Apache-2.0
#include "encoder/normal_mesh/uncovered_regions.h"

#include <algorithm>
#include <numeric>

#include "encoder/core/parallel.h"

namespace nmc {

namespace {

constexpr std::uint32_t kNoRegion = 0xffffffffu;

std::uint32_t find_root(std::vector<std::uint32_t>& parent, std::uint32_t v) {
  while (parent[v] != v) v = parent[v] = parent[parent[v]];
  return v;
}

}  // namespace

std::vector<UncoveredRegion> uncovered_regions(const TriangleMesh& input, const SurfaceIndex& mesh_index,
                                               double tolerance) {
  const std::size_t n = input.vertex_count();
  std::vector<double> distances(n, 0);
  parallel_for(n, [&](std::size_t v) {
    if (mesh_index.closest_point(input.positions[v], tolerance).found()) return;
    const SurfacePoint closest = mesh_index.closest_point(input.positions[v]);
    if (closest.found() && closest.t > tolerance) distances[v] = closest.t;
  });

  std::vector<double> area(n, 0);
  std::vector<std::uint32_t> parent(n);
  std::iota(parent.begin(), parent.end(), 0u);
  std::vector<std::uint8_t> used(n, 0);
  for (const Triangle& t : input.triangles) {
    const Vec3& a = input.positions[t[0]];
    const double third = norm(cross(input.positions[t[1]] - a, input.positions[t[2]] - a)) / 6;
    for (int k = 0; k < 3; ++k) {
      used[t[k]] = 1;
      area[t[k]] += third;
      const std::uint32_t p = t[k], q = t[(k + 1) % 3];
      if (distances[p] == 0 || distances[q] == 0) continue;
      const std::uint32_t i = find_root(parent, p), j = find_root(parent, q);
      parent[std::max(i, j)] = std::min(i, j);
    }
  }

  std::vector<UncoveredRegion> regions;
  std::vector<std::uint32_t> region_of(n, kNoRegion);
  for (std::uint32_t v = 0; v < n; ++v) {
    if (distances[v] == 0 || !used[v]) continue;
    const std::uint32_t root = find_root(parent, v);
    if (region_of[root] == kNoRegion) {
      region_of[root] = static_cast<std::uint32_t>(regions.size());
      regions.emplace_back();
    }
    UncoveredRegion& region = regions[region_of[root]];
    region.vertices.push_back(v);
    region.area += area[v];
    region.squared_error += area[v] * distances[v] * distances[v];
    if (distances[v] > region.farthest_distance) {
      region.farthest_distance = distances[v];
      region.farthest_vertex = v;
    }
  }
  std::sort(regions.begin(), regions.end(), [](const UncoveredRegion& a, const UncoveredRegion& b) {
    if (a.squared_error != b.squared_error) return a.squared_error > b.squared_error;
    return a.farthest_vertex < b.farthest_vertex;
  });
  return regions;
}

}  // namespace nmc
