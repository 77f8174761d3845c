// SPDX-License-Identifier: Apache-2.0
#include "encoder/domain/surface_chains.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace nmc {
namespace {

using Edge = std::array<std::uint32_t, 2>;

struct EdgeSides {
  Edge edge;              // low vertex first
  std::uint32_t face[2];  // kNoFace where there is none
  int face_count = 0;
};

constexpr std::uint32_t kNone = 0xffffffffu;

std::vector<EdgeSides> list_edges(const TriangleMesh& mesh) {
  struct Side {
    Edge edge;
    std::uint32_t face;
  };
  std::vector<Side> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = mesh.triangles[f][k], b = mesh.triangles[f][(k + 1) % 3];
      sides.push_back({{std::min(a, b), std::max(a, b)}, f});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return a.edge != b.edge ? a.edge < b.edge : a.face < b.face;
  });
  std::vector<EdgeSides> edges;
  edges.reserve(sides.size() / 2);
  for (const Side& side : sides) {
    if (edges.empty() || edges.back().edge != side.edge) edges.push_back({side.edge, {kNone, kNone}, 0});
    EdgeSides& last = edges.back();
    if (last.face_count < 2) last.face[last.face_count] = side.face;
    ++last.face_count;
  }
  return edges;
}

class CreaseFinder {
 public:
  CreaseFinder(const TriangleMesh& mesh, const std::vector<EdgeSides>& edges, double angle_degrees)
      : mesh_(mesh), edges_(edges), incident_(mesh.vertex_count()) {
    const double strong = std::cos(angle_degrees * std::numbers::pi / 180);
    const double weak = std::cos(0.625 * angle_degrees * std::numbers::pi / 180);
    std::vector<std::uint8_t> strong_edge(edges.size(), 0);
    for (std::uint32_t e = 0; e < edges.size(); ++e) {
      if (edges[e].face_count != 2) continue;
      const Vec3 n0 = face_normal(edges[e].face[0]), n1 = face_normal(edges[e].face[1]);
      const double cosine = dot(n0, n1);
      if (cosine >= weak || n0 == Vec3{} || n1 == Vec3{}) continue;
      strong_edge[e] = cosine < strong;
      for (const std::uint32_t v : edges[e].edge) incident_[v].push_back(e);
    }
    keep_.assign(edges.size(), 0);
    std::vector<std::uint8_t> seen(edges.size(), 0);
    const double minimum_length = 0.02 * bounding_box(mesh).diagonal();
    for (std::uint32_t seed = 0; seed < edges.size(); ++seed)
      if (strong_edge[seed] && !seen[seed]) keep_chain_from(seed, seen, minimum_length);
  }

  bool is_crease(std::uint32_t e) const { return keep_[e] != 0; }

 private:
  Vec3 face_normal(std::uint32_t f) const {
    const Triangle& t = mesh_.triangles[f];
    const Vec3& a = mesh_.positions[t[0]];
    return normalized(cross(mesh_.positions[t[1]] - a, mesh_.positions[t[2]] - a), {0, 0, 0});
  }

  /// The connected set of weak edges that a strong edge belongs to is kept or dropped as a whole.
  void keep_chain_from(std::uint32_t seed, std::vector<std::uint8_t>& seen, double minimum_length) {
    std::vector<std::uint32_t> chain{seed};
    seen[seed] = 1;
    double length = 0;
    for (std::size_t head = 0; head < chain.size(); ++head) {
      const Edge& edge = edges_[chain[head]].edge;
      length += distance(mesh_.positions[edge[0]], mesh_.positions[edge[1]]);
      for (const std::uint32_t v : edge)
        for (const std::uint32_t e : incident_[v])
          if (!seen[e]) {
            seen[e] = 1;
            chain.push_back(e);
          }
    }
    if (chain.size() < 4 || length < minimum_length) return;
    for (const std::uint32_t e : chain) keep_[e] = 1;
  }

  const TriangleMesh& mesh_;
  const std::vector<EdgeSides>& edges_;
  std::vector<std::vector<std::uint32_t>> incident_;
  std::vector<std::uint8_t> keep_;
};

/// Adds one vertex in the middle of every edge of `chords` and splits the triangles beside them, one chord
/// after the other within a triangle.
std::shared_ptr<TriangleMesh> split_edges(const TriangleMesh& mesh, const std::vector<EdgeSides>& chords) {
  auto result = std::make_shared<TriangleMesh>(mesh);
  const auto first_new = static_cast<std::uint32_t>(mesh.vertex_count());
  for (const EdgeSides& chord : chords) {
    const auto [a, b] = chord.edge;
    result->positions.push_back(0.5 * (mesh.positions[a] + mesh.positions[b]));
    if (!mesh.colors.empty()) {
      std::array<std::uint8_t, 3> color;
      for (std::size_t k = 0; k < 3; ++k)
        color[k] = static_cast<std::uint8_t>((mesh.colors[a][k] + mesh.colors[b][k] + 1) / 2);
      result->colors.push_back(color);
    }
    for (std::size_t i = 0; i < mesh.attributes.size(); ++i) {
      const VertexAttribute& from = mesh.attributes[i];
      const auto width = static_cast<std::size_t>(from.component_count);
      for (std::size_t k = 0; k < width; ++k)
        result->attributes[i].values.push_back(0.5f *
                                               (from.values[a * width + k] + from.values[b * width + k]));
    }
  }
  // Split vertex of each side of each triangle.
  std::vector<std::array<std::uint32_t, 3>> middle(mesh.triangles.size(), {kNone, kNone, kNone});
  for (std::uint32_t i = 0; i < chords.size(); ++i)
    for (const std::uint32_t f : chords[i].face) {
      const Triangle& t = mesh.triangles[f];
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = t[k], b = t[(k + 1) % 3];
        if (std::min(a, b) == chords[i].edge[0] && std::max(a, b) == chords[i].edge[1])
          middle[f][k] = first_new + i;
      }
    }
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    const Triangle t = mesh.triangles[f];
    const auto& m = middle[f];
    const int count = (m[0] != kNone) + (m[1] != kNone) + (m[2] != kNone);
    if (count == 0) continue;
    if (count == 3) {
      result->triangles[f] = {m[0], m[1], m[2]};
      for (std::size_t k = 0; k < 3; ++k) result->triangles.push_back({t[k], m[k], m[(k + 2) % 3]});
      continue;
    }
    std::size_t k = 0;  // a split side; with two of them, the one followed by the other
    while (m[k] == kNone || (count == 2 && m[(k + 1) % 3] == kNone)) ++k;
    const std::uint32_t a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
    const std::uint32_t ab = m[k], bc = m[(k + 1) % 3];
    if (count == 1) {
      result->triangles[f] = {a, ab, c};
      result->triangles.push_back({ab, b, c});
    } else {
      result->triangles[f] = {a, ab, c};
      result->triangles.push_back({ab, b, bc});
      result->triangles.push_back({ab, bc, c});
    }
  }
  return result;
}

}  // namespace

SurfaceChains find_chains(const TriangleMesh& mesh, double crease_angle_degrees) {
  SurfaceChains chains;
  const std::vector<EdgeSides> edges = list_edges(mesh);
  const bool with_creases = crease_angle_degrees > 0;
  std::vector<std::uint8_t> on_chain(edges.size(), 0);
  for (std::size_t e = 0; e < edges.size(); ++e) on_chain[e] = edges[e].face_count == 1;
  if (with_creases) {
    const CreaseFinder finder(mesh, edges, crease_angle_degrees);
    for (std::uint32_t e = 0; e < edges.size(); ++e)
      if (finder.is_crease(e)) {
        on_chain[e] = 1;
        chains.crease_edges.push_back(edges[e].edge);
      }
  }

  // A vertex with two chain edges is on a curve; any other number above zero makes it a corner. With creases,
  // so does a turn of more than 45 degrees.
  std::vector<std::array<std::uint32_t, 2>> along(mesh.vertex_count(), {kNone, kNone});
  std::vector<std::uint32_t> chain_degree(mesh.vertex_count(), 0);
  for (std::size_t e = 0; e < edges.size(); ++e)
    if (on_chain[e])
      for (std::size_t k = 0; k < 2; ++k) {
        const std::uint32_t v = edges[e].edge[k];
        if (chain_degree[v] < 2) along[v][chain_degree[v]] = edges[e].edge[1 - k];
        ++chain_degree[v];
      }
  chains.kinds.assign(mesh.vertex_count(), VertexKind::kSmooth);
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (chain_degree[v] == 0) continue;
    bool corner = chain_degree[v] != 2;
    if (!corner && with_creases) {
      const Vec3 before = normalized(mesh.positions[v] - mesh.positions[along[v][0]], {0, 0, 0});
      const Vec3 after = normalized(mesh.positions[along[v][1]] - mesh.positions[v], {0, 0, 0});
      corner = dot(before, after) < std::numbers::sqrt2 / 2;
    }
    chains.kinds[v] = corner ? VertexKind::kLocked : VertexKind::kChain;
  }

  std::vector<EdgeSides> chords;
  for (std::size_t e = 0; e < edges.size(); ++e)
    if (!on_chain[e] && edges[e].face_count == 2 && chain_degree[edges[e].edge[0]] > 0 &&
        chain_degree[edges[e].edge[1]] > 0)
      chords.push_back(edges[e]);
  chains.surface = chords.empty() ? std::make_shared<TriangleMesh>(mesh) : split_edges(mesh, chords);
  chains.kinds.resize(chains.surface->vertex_count(), VertexKind::kSmooth);
  return chains;
}

}  // namespace nmc
