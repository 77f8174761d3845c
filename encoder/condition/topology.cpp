// SPDX-License-Identifier: Apache-2.0
#include "encoder/condition/topology.h"

#include <algorithm>
#include <array>

#include "encoder/condition/disjoint_sets.h"
#include "encoder/condition/half_edges.h"

namespace nmc {

using conditioning::DisjointSets;
using conditioning::EdgeGroups;
using conditioning::GroupedHalfEdge;
using conditioning::head_of;
using conditioning::kNone;
using conditioning::next_half_edge;
using conditioning::tail_of;

namespace {

/// The corner of half-edge h's edge that lies at `vertex`, which is one of its two ends.
std::uint32_t corner_at(const std::vector<Triangle>& triangles, std::uint32_t h, std::uint32_t vertex) {
  return tail_of(triangles, h) == vertex ? h : next_half_edge(h);
}

/// Marks the components whose triangles cannot all be turned to agree: walks each one once and compares the
/// parity that every manifold edge asks for.
void find_non_orientable(const std::vector<Triangle>& triangles, const std::vector<std::uint32_t>& opposite,
                         Topology& topology) {
  constexpr std::uint8_t kAsStored = 0, kTurned = 1, kUnseen = 2;
  std::vector<std::uint8_t> side(triangles.size(), kUnseen);
  std::vector<std::uint32_t> stack;
  for (const ComponentTopology& component : topology.components) {
    // A component may be several pieces once its non-manifold edges, which carry no orientation, are left
    // out; the seeds of those pieces are found by the loop below.
    side[component.first_triangle] = kAsStored;
    stack.push_back(component.first_triangle);
  }
  for (std::uint32_t seed = 0; seed <= triangles.size(); ++seed) {
    while (!stack.empty()) {
      const std::uint32_t t = stack.back();
      stack.pop_back();
      for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
        const std::uint32_t other = opposite[h];
        if (other == kNone) continue;
        const bool same_way = tail_of(triangles, h) == tail_of(triangles, other);
        const std::uint8_t wanted = static_cast<std::uint8_t>(same_way ? side[t] ^ kTurned : side[t]);
        if (side[other / 3] == kUnseen) {
          side[other / 3] = wanted;
          stack.push_back(other / 3);
        } else if (side[other / 3] != wanted) {
          topology.components[topology.component_of_triangle[t]].orientable = false;
        }
      }
    }
    if (seed < triangles.size() && side[seed] == kUnseen) {
      side[seed] = kAsStored;
      stack.push_back(seed);
    }
  }
}

/// Open edges that end in the same umbrella belong to the same loop: an umbrella has exactly two open ends.
void find_boundary_loops(const std::vector<Vec3>& positions, const std::vector<Triangle>& triangles,
                         const std::vector<std::uint32_t>& open_half_edges, DisjointSets& umbrellas,
                         Topology& topology) {
  if (open_half_edges.empty()) return;
  struct End {
    std::uint32_t umbrella, open_index;
    bool operator<(const End& other) const {
      return umbrella != other.umbrella ? umbrella < other.umbrella : open_index < other.open_index;
    }
  };
  std::vector<End> ends;
  ends.reserve(2 * open_half_edges.size());
  for (std::uint32_t i = 0; i < open_half_edges.size(); ++i) {
    ends.push_back({umbrellas.find(open_half_edges[i]), i});
    ends.push_back({umbrellas.find(next_half_edge(open_half_edges[i])), i});
  }
  std::sort(ends.begin(), ends.end());
  DisjointSets chains(open_half_edges.size());
  for (std::size_t i = 1; i < ends.size(); ++i)
    if (ends[i].umbrella == ends[i - 1].umbrella) chains.unite(ends[i].open_index, ends[i - 1].open_index);

  std::vector<std::uint32_t> loop_of_root(open_half_edges.size(), kNone);
  for (std::uint32_t i = 0; i < open_half_edges.size(); ++i) {
    const std::uint32_t h = open_half_edges[i];
    std::uint32_t& loop = loop_of_root[chains.find(i)];
    if (loop == kNone) {
      loop = static_cast<std::uint32_t>(topology.boundary_loops.size());
      BoundaryLoop fresh;
      fresh.component = topology.component_of_triangle[h / 3];
      fresh.first_half_edge = h;
      topology.boundary_loops.push_back(fresh);
      ++topology.components[fresh.component].boundary_loop_count;
    }
    ++topology.boundary_loops[loop].edge_count;
    topology.boundary_loops[loop].length +=
        distance(positions[tail_of(triangles, h)], positions[head_of(triangles, h)]);
  }
}

void add_geometry(const std::vector<Vec3>& positions, const std::vector<Triangle>& triangles,
                  Topology& topology) {
  std::vector<std::uint8_t> seen(topology.components.size(), 0);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    ComponentTopology& component = topology.components[topology.component_of_triangle[t]];
    // The first corner of the component is the origin of its volume: far from the world's origin the products
    // below would cancel.
    const Vec3& origin = positions[triangles[component.first_triangle][0]];
    if (!seen[topology.component_of_triangle[t]]) {
      seen[topology.component_of_triangle[t]] = 1;
      component.box = {origin, origin};
    }
    const std::array<Vec3, 3> corner = {positions[triangles[t][0]] - origin,
                                        positions[triangles[t][1]] - origin,
                                        positions[triangles[t][2]] - origin};
    component.area += 0.5 * norm(cross(corner[1] - corner[0], corner[2] - corner[0]));
    component.volume += dot(corner[0], cross(corner[1], corner[2])) / 6;
    for (const std::uint32_t v : triangles[t])
      for (int k = 0; k < 3; ++k) {
        component.box.minimum[k] = std::min(component.box.minimum[k], positions[v][k]);
        component.box.maximum[k] = std::max(component.box.maximum[k], positions[v][k]);
      }
  }
}

}  // namespace

long Topology::total_genus() const {
  long sum = 0;
  for (const ComponentTopology& component : components)
    if (component.genus != kNoGenus) sum += component.genus;
  return sum;
}

Topology analyze_topology(const std::vector<Vec3>& positions, const std::vector<Triangle>& triangles) {
  Topology topology;
  const std::size_t half_edge_count = 3 * triangles.size();
  DisjointSets pieces(triangles.size());    // triangles joined by edges
  DisjointSets umbrellas(half_edge_count);  // corners joined around their vertex
  std::vector<std::uint32_t> opposite(half_edge_count, kNone);
  std::vector<std::uint32_t> open_half_edges, crowded_half_edges, misoriented_half_edges;
  EdgeGroups(triangles, positions.size()).for_each([&](std::span<const GroupedHalfEdge> group) {
    ++topology.edge_count;
    const std::uint32_t first = group[0].half_edge();
    const std::uint32_t a = tail_of(triangles, first), b = head_of(triangles, first);
    for (std::size_t i = 1; i < group.size(); ++i) {
      const std::uint32_t h = group[i].half_edge();
      pieces.unite(first / 3, h / 3);
      umbrellas.unite(corner_at(triangles, first, a), corner_at(triangles, h, a));
      umbrellas.unite(corner_at(triangles, first, b), corner_at(triangles, h, b));
    }
    if (group.size() == 1) open_half_edges.push_back(first);
    if (group.size() > 2) crowded_half_edges.push_back(first);
    if (group.size() != 2) return;
    opposite[first] = group[1].half_edge();
    opposite[group[1].half_edge()] = first;
    if (tail_of(triangles, group[1].half_edge()) == a) misoriented_half_edges.push_back(first);
  });
  topology.boundary_edge_count = open_half_edges.size();
  topology.non_manifold_edge_count = crowded_half_edges.size();
  topology.misoriented_edge_count = misoriented_half_edges.size();
  std::sort(open_half_edges.begin(), open_half_edges.end());

  topology.component_of_triangle.resize(triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const std::uint32_t root = pieces.find(t);  // root <= t, so its number is already known unless root == t
    if (root == t) {
      topology.component_of_triangle[t] = static_cast<std::uint32_t>(topology.components.size());
      topology.components.emplace_back();
      topology.components.back().first_triangle = t;
    } else {
      topology.component_of_triangle[t] = topology.component_of_triangle[root];
    }
    ++topology.components[topology.component_of_triangle[t]].triangle_count;
  }

  const auto component_of_half_edge = [&](std::uint32_t h) -> ComponentTopology& {
    return topology.components[topology.component_of_triangle[h / 3]];
  };
  std::vector<std::uint8_t> umbrella_count(positions.size(), 0);  // saturates at 2
  for (std::uint32_t corner = 0; corner < half_edge_count; ++corner) {
    if (umbrellas.find(corner) != corner) continue;
    ++component_of_half_edge(corner).vertex_count;
    std::uint8_t& count = umbrella_count[tail_of(triangles, corner)];
    if (count < 2) ++count;
  }
  for (const std::uint8_t count : umbrella_count) {
    topology.vertex_count += count > 0;
    topology.non_manifold_vertex_count += count > 1;
  }
  // Each half-edge is half an edge, but for open ones (a whole) and crowded ones (counted apart).
  for (std::uint32_t h = 0; h < half_edge_count; ++h)
    if (opposite[h] != kNone && h < opposite[h]) ++component_of_half_edge(h).edge_count;
  for (const std::uint32_t h : open_half_edges) ++component_of_half_edge(h).edge_count;
  for (const std::uint32_t h : crowded_half_edges) {
    ++component_of_half_edge(h).edge_count;
    ++component_of_half_edge(h).non_manifold_edge_count;
  }

  find_boundary_loops(positions, triangles, open_half_edges, umbrellas, topology);
  if (!misoriented_half_edges.empty()) find_non_orientable(triangles, opposite, topology);
  add_geometry(positions, triangles, topology);

  for (const std::uint32_t h : misoriented_half_edges) component_of_half_edge(h).volume = 0;
  for (ComponentTopology& component : topology.components) {
    if (!component.is_closed()) component.volume = 0;
    const long twice_genus =
        2 - static_cast<long>(component.boundary_loop_count) - component.euler_characteristic();
    component.genus =
        component.non_manifold_edge_count == 0 && component.orientable ? twice_genus / 2 : kNoGenus;
  }
  return topology;
}

Topology analyze_topology(const TriangleMesh& mesh) {
  return analyze_topology(mesh.positions, mesh.triangles);
}

}  // namespace nmc
