// SPDX-License-Identifier: Apache-2.0
#include "encoder/condition/weld.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

namespace nmc::conditioning {

namespace {

std::uint64_t mix(std::uint64_t x) {  // the finalizer of splitmix64
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
  x = (x ^ x >> 27) * 0x94d049bb133111ebu;
  return x ^ x >> 31;
}

std::uint64_t hash_bits(std::uint64_t x, std::uint64_t y, std::uint64_t z) {
  return mix(mix(mix(x + 0x9e3779b97f4a7c15u) + y) + z);
}

std::uint64_t hash_position(const Vec3& p) {
  // Adding +0 turns -0 into +0 and changes no other value.
  return hash_bits(std::bit_cast<std::uint64_t>(p.x + 0.0), std::bit_cast<std::uint64_t>(p.y + 0.0),
                   std::bit_cast<std::uint64_t>(p.z + 0.0));
}

/// Open addressing at a load of at most one half.
class VertexTable {
 public:
  explicit VertexTable(std::size_t count) : slots_(std::bit_ceil(2 * count + 2), kNone) {}
  /// Calls visit(vertex) for the vertices stored under `hash` (and, rarely, others) until it returns true.
  template <class Visit>
  bool find(std::uint64_t hash, const Visit& visit) const {
    for (std::size_t i = hash & mask(); slots_[i] != kNone; i = (i + 1) & mask())
      if (visit(slots_[i])) return true;
    return false;
  }
  void insert(std::uint64_t hash, std::uint32_t vertex) {
    std::size_t i = hash & mask();
    while (slots_[i] != kNone) i = (i + 1) & mask();
    slots_[i] = vertex;
  }

 private:
  std::size_t mask() const { return slots_.size() - 1; }
  std::vector<std::uint32_t> slots_;
};

}  // namespace

std::vector<std::uint32_t> equal_vertices(const std::vector<Vec3>& positions,
                                          const std::vector<std::uint8_t>& used) {
  std::vector<std::uint32_t> representative(positions.size());
  std::iota(representative.begin(), representative.end(), 0u);
  VertexTable table(positions.size());
  for (std::uint32_t v = 0; v < positions.size(); ++v) {
    if (!used[v]) continue;
    const std::uint64_t hash = hash_position(positions[v]);
    const bool found = table.find(hash, [&](std::uint32_t other) {
      if (!(positions[other] == positions[v])) return false;
      representative[v] = other;
      return true;
    });
    if (!found) table.insert(hash, v);
  }
  return representative;
}

double limited_weld_radius(const WorkingMesh& mesh, const EdgeGroups& edges, double radius) {
  std::vector<float> lengths;
  lengths.reserve(mesh.triangles.size() * 3 / 2);
  edges.for_each([&](std::span<const GroupedHalfEdge> group) {
    const std::uint32_t h = group[0].half_edge();
    lengths.push_back(static_cast<float>(
        distance(mesh.positions[tail_of(mesh.triangles, h)], mesh.positions[head_of(mesh.triangles, h)])));
  });
  if (lengths.empty()) return 0;
  const auto quantile = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 1000);
  std::nth_element(lengths.begin(), quantile, lengths.end());
  return std::min(radius, 0.1 * static_cast<double>(*quantile));
}

std::vector<std::uint32_t> weld_nearby(WorkingMesh& mesh, const EdgeGroups& edges, double radius) {
  if (!(radius > 0)) return {};
  std::vector<std::uint8_t> is_open(mesh.positions.size(), 0);
  edges.for_each([&](std::span<const GroupedHalfEdge> group) {
    if (group.size() != 1) return;
    is_open[tail_of(mesh.triangles, group[0].half_edge())] = 1;
    is_open[head_of(mesh.triangles, group[0].half_edge())] = 1;
  });
  const std::size_t open_count = static_cast<std::size_t>(std::count(is_open.begin(), is_open.end(), 1));
  if (open_count == 0) return {};

  // A cell is 16 radii wide, so a ball of one radius touches on average 1.4 cells and at most 8.
  const double cell = 16 * radius;
  const auto cell_of = [&](double x) { return static_cast<std::int64_t>(std::floor(x / cell)); };
  const auto hash_cell = [](std::int64_t x, std::int64_t y, std::int64_t z) {
    return hash_bits(static_cast<std::uint64_t>(x), static_cast<std::uint64_t>(y),
                     static_cast<std::uint64_t>(z));
  };
  VertexTable representatives(open_count);
  std::vector<std::uint32_t> target(mesh.positions.size());
  std::iota(target.begin(), target.end(), 0u);
  std::size_t welded = 0;
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
    if (!is_open[v]) continue;
    const Vec3& p = mesh.positions[v];
    double best = radius;
    std::uint32_t nearest = kNone;
    for (std::int64_t x = cell_of(p.x - radius); x <= cell_of(p.x + radius); ++x)
      for (std::int64_t y = cell_of(p.y - radius); y <= cell_of(p.y + radius); ++y)
        for (std::int64_t z = cell_of(p.z - radius); z <= cell_of(p.z + radius); ++z)
          representatives.find(hash_cell(x, y, z), [&](std::uint32_t other) {
            const double d = distance(p, mesh.positions[other]);
            // Ties go to the lowest index, whatever order the table holds them in.
            if (d < best || (d == best && other < nearest)) {
              best = d;
              nearest = other;
            }
            return false;
          });
    if (nearest == kNone) {
      representatives.insert(hash_cell(cell_of(p.x), cell_of(p.y), cell_of(p.z)), v);
    } else {
      target[v] = nearest;
      ++welded;
    }
  }
  if (welded == 0) return {};

  // Targets are never welded themselves, so undoing one weld cannot create another coincidence: one pass is
  // enough.
  for (const Triangle& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
      if (target[a] != target[b]) continue;
      const double longest = std::max({distance(mesh.positions[a], mesh.positions[b]),
                                       distance(mesh.positions[b], mesh.positions[c]),
                                       distance(mesh.positions[c], mesh.positions[a])});
      if (longest < 4 * radius) continue;
      const std::uint32_t later = std::max(a, b);
      welded -= target[later] != later;
      target[later] = later;
    }
  for (Triangle& t : mesh.triangles)
    for (std::uint32_t& v : t) v = target[v];
  if (welded == 0) return {};
  return target;
}

}  // namespace nmc::conditioning
