// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <unordered_map>

#include "corpus/generate/random.h"
#include "corpus/generate/shapes.h"

namespace nmc::corpus {

namespace {

std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) {
  return static_cast<std::uint64_t>(std::min(a, b)) << 32 | std::max(a, b);
}

/// Splits the longest edges, at most one per triangle, until `missing` triangles were added or none is left.
void split_longest_edges(TriangleMesh& mesh, std::size_t missing) {
  struct Edge {
    double squared_length;
    std::uint64_t key;
    std::uint32_t half_edge;
  };
  std::vector<Edge> edges;
  for (std::uint32_t h = 0; h < 3 * mesh.triangle_count(); ++h) {
    const std::uint32_t a = mesh.triangles[h / 3][h % 3], b = mesh.triangles[h / 3][(h + 1) % 3];
    edges.push_back({squared_norm(mesh.positions[a] - mesh.positions[b]), edge_key(a, b), h});
  }
  // Half-edges of one edge are neighbours in this order: equal length, then equal key.
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
    if (a.squared_length != b.squared_length) return a.squared_length > b.squared_length;
    return a.key != b.key ? a.key < b.key : a.half_edge < b.half_edge;
  });
  std::vector<std::uint8_t> used(mesh.triangle_count(), 0);
  std::size_t added = 0;
  for (std::size_t i = 0; i < edges.size() && added < missing;) {
    std::size_t j = i + 1;
    while (j < edges.size() && edges[j].key == edges[i].key) ++j;
    const bool is_free = std::all_of(edges.begin() + static_cast<std::ptrdiff_t>(i),
                                     edges.begin() + static_cast<std::ptrdiff_t>(j),
                                     [&](const Edge& e) { return !used[e.half_edge / 3]; });
    if (is_free) {
      const auto middle = static_cast<std::uint32_t>(mesh.vertex_count());
      const auto a = static_cast<std::uint32_t>(edges[i].key >> 32),
                 b = static_cast<std::uint32_t>(edges[i].key);
      mesh.positions.push_back(0.5 * (mesh.positions[a] + mesh.positions[b]));
      for (std::size_t k = i; k < j; ++k) {
        const std::uint32_t t = edges[k].half_edge / 3, corner = edges[k].half_edge % 3;
        const Triangle old = mesh.triangles[t];
        mesh.triangles[t][(corner + 1) % 3] = middle;
        Triangle other = old;
        other[corner] = middle;
        mesh.triangles.push_back(other);
        used[t] = 1;
        ++added;
      }
    }
    i = j;
  }
}

}  // namespace

void append(TriangleMesh& mesh, const TriangleMesh& part) {
  const auto first = static_cast<std::uint32_t>(mesh.vertex_count());
  mesh.positions.insert(mesh.positions.end(), part.positions.begin(), part.positions.end());
  for (const Triangle& t : part.triangles)
    mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
}

void translate(TriangleMesh& mesh, const Vec3& offset) {
  for (Vec3& p : mesh.positions) p += offset;
}

void turn_around(TriangleMesh& mesh) {
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
}

TriangleMesh split_one_to_four(const TriangleMesh& mesh) {
  TriangleMesh fine;
  fine.positions = mesh.positions;
  fine.triangles.reserve(4 * mesh.triangle_count());
  std::unordered_map<std::uint64_t, std::uint32_t> middles;
  middles.reserve(3 * mesh.triangle_count() / 2 + 16);
  const auto middle = [&](std::uint32_t a, std::uint32_t b) {
    const auto [place, is_new] =
        middles.try_emplace(edge_key(a, b), static_cast<std::uint32_t>(fine.vertex_count()));
    if (is_new) fine.positions.push_back(0.5 * (mesh.positions[a] + mesh.positions[b]));
    return place->second;
  };
  for (const Triangle& t : mesh.triangles) {
    const std::uint32_t ab = middle(t[0], t[1]), bc = middle(t[1], t[2]), ca = middle(t[2], t[0]);
    fine.triangles.push_back({t[0], ab, ca});
    fine.triangles.push_back({t[1], bc, ab});
    fine.triangles.push_back({t[2], ca, bc});
    fine.triangles.push_back({ab, bc, ca});
  }
  return fine;
}

TriangleMesh subdivide(const TriangleMesh& mesh, std::size_t triangle_count, double noise,
                       std::uint64_t seed) {
  TriangleMesh fine;
  fine.positions = mesh.positions;
  fine.triangles = mesh.triangles;
  if (fine.triangles.empty()) return fine;
  while (4 * fine.triangle_count() <= triangle_count) fine = split_one_to_four(fine);
  while (fine.triangle_count() < triangle_count)
    split_longest_edges(fine, triangle_count - fine.triangle_count());
  const std::vector<Vec3> normals = vertex_normals(fine);
  const double deviation = noise * bounding_box(fine).diagonal();
  Random random(seed);
  for (std::size_t v = 0; v < fine.vertex_count(); ++v)
    fine.positions[v] += deviation * random.normal() * normals[v];
  return fine;
}

}  // namespace nmc::corpus
