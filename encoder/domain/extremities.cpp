// SPDX-License-Identifier: Apache-2.0
#include "encoder/domain/extremities.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

namespace nmc {
namespace {

using Corner = CornerTable::Corner;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kMaximumSources = 64;
constexpr std::size_t kVerticesPerSource = 16;
constexpr std::uint32_t kNone = CornerTable::kNone;

/// Edge graph of the live vertices, renumbered.
struct Graph {
  std::vector<std::uint32_t> vertices;  // graph node -> surface vertex
  std::vector<std::uint32_t> first, target;
  std::vector<double> length;
};

Graph edge_graph(const CornerTable& table, const std::vector<Vec3>& positions) {
  Graph graph;
  std::vector<std::uint32_t> node(table.real_vertex_count(), kNone);
  for (std::uint32_t v = 0; v < table.real_vertex_count(); ++v)
    if (table.corner_at(v) != kNone) {
      node[v] = static_cast<std::uint32_t>(graph.vertices.size());
      graph.vertices.push_back(v);
    }
  graph.first.push_back(0);
  for (const std::uint32_t v : graph.vertices) {
    const Corner start = table.corner_at(v);
    Corner c = start;
    do {
      const std::uint32_t w = table.vertex(CornerTable::next(c));
      if (!table.is_ghost_vertex(w)) {
        graph.target.push_back(node[w]);
        graph.length.push_back(distance(positions[v], positions[w]));
      }
      c = table.rotate(c);
    } while (c != start);
    graph.first.push_back(static_cast<std::uint32_t>(graph.target.size()));
  }
  return graph;
}

/// Distances from `source` into `result`, which holds infinity on the source's component before.
void dijkstra(const Graph& graph, std::uint32_t source, std::vector<double>& result) {
  using Entry = std::pair<double, std::uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  result[source] = 0;
  queue.push({0, source});
  while (!queue.empty()) {
    const auto [d, v] = queue.top();
    queue.pop();
    if (d > result[v]) continue;
    for (std::uint32_t e = graph.first[v]; e < graph.first[v + 1]; ++e) {
      const double through = d + graph.length[e];
      if (through < result[graph.target[e]]) {
        result[graph.target[e]] = through;
        queue.push({through, graph.target[e]});
      }
    }
  }
}

class Finder {
 public:
  Finder(const Graph& graph, double least_prominence)
      : graph_(graph),
        least_prominence_(least_prominence),
        average_(graph.vertices.size(), 0),
        parent_(graph.vertices.size(), kNone) {}

  void add_component(const std::vector<std::uint32_t>& nodes, double area) {
    if (nodes.size() < 2 * kVerticesPerSource || !(area > 0)) return;
    average_distances(nodes);
    rank_maxima(nodes, std::sqrt(area));
  }

  std::vector<std::uint32_t> result() {
    std::sort(tips_.begin(), tips_.end(), [](const Tip& a, const Tip& b) {
      return a.prominence != b.prominence ? a.prominence > b.prominence : a.node < b.node;
    });
    std::vector<std::uint32_t> vertices;
    for (const Tip& tip : tips_) vertices.push_back(graph_.vertices[tip.node]);
    return vertices;
  }

 private:
  struct Tip {
    double prominence;
    std::uint32_t node;
  };

  /// Mean distance to sources spread by farthest point sampling.
  void average_distances(const std::vector<std::uint32_t>& nodes) {
    const std::size_t count = std::min(kMaximumSources, nodes.size() / kVerticesPerSource);
    std::vector<double> from_source(graph_.vertices.size(), kInfinity),
        nearest(graph_.vertices.size(), kInfinity);
    std::uint32_t source = nodes.front();
    for (std::size_t i = 0; i < count; ++i) {
      for (const std::uint32_t v : nodes) from_source[v] = kInfinity;
      dijkstra(graph_, source, from_source);
      for (const std::uint32_t v : nodes) {
        average_[v] += from_source[v] / static_cast<double>(count);
        nearest[v] = std::min(nearest[v], from_source[v]);
      }
      for (const std::uint32_t v : nodes)
        if (nearest[v] > nearest[source]) source = v;
    }
  }

  std::uint32_t find(std::uint32_t v) {
    while (parent_[v] != v) v = parent_[v] = parent_[parent_[v]];
    return v;
  }

  /// Floods from above; where two hills meet, the lower one's prominence is known.
  void rank_maxima(const std::vector<std::uint32_t>& nodes, double scale) {
    std::vector<std::uint32_t> order = nodes;
    const auto above = [this](std::uint32_t a, std::uint32_t b) {
      return average_[a] != average_[b] ? average_[a] > average_[b] : a < b;
    };
    std::sort(order.begin(), order.end(), above);
    for (const std::uint32_t v : order) {
      parent_[v] = v;
      for (std::uint32_t e = graph_.first[v]; e < graph_.first[v + 1]; ++e) {
        const std::uint32_t w = graph_.target[e];
        if (parent_[w] == kNone) continue;
        std::uint32_t high = find(w), low = find(v);
        if (high == low) continue;
        if (above(low, high)) std::swap(low, high);
        keep(low, average_[low] - average_[v], scale);
        parent_[low] = high;
      }
    }
    keep(order.front(), average_[order.front()] - average_[order.back()], scale);
  }

  void keep(std::uint32_t node, double height, double scale) {
    if (height > least_prominence_ * scale) tips_.push_back({height / scale, node});
  }

  const Graph& graph_;
  double least_prominence_;
  std::vector<double> average_;
  std::vector<std::uint32_t> parent_;
  std::vector<Tip> tips_;
};

}  // namespace

std::vector<std::uint32_t> find_extremities(const CornerTable& table, const std::vector<Vec3>& positions,
                                            double least_prominence) {
  const Graph graph = edge_graph(table, positions);
  Finder finder(graph, least_prominence);
  std::vector<std::uint8_t> seen(graph.vertices.size(), 0);
  for (std::uint32_t seed = 0; seed < graph.vertices.size(); ++seed) {
    if (seen[seed]) continue;
    std::vector<std::uint32_t> nodes{seed};
    seen[seed] = 1;
    double area = 0;
    for (std::size_t head = 0; head < nodes.size(); ++head) {
      const std::uint32_t v = nodes[head];
      for (std::uint32_t e = graph.first[v]; e < graph.first[v + 1]; ++e)
        if (!seen[graph.target[e]]) {
          seen[graph.target[e]] = 1;
          nodes.push_back(graph.target[e]);
        }
      const Corner start = table.corner_at(graph.vertices[v]);
      Corner c = start;
      do {
        if (!table.is_ghost_face(CornerTable::face_of(c))) {
          const Vec3& p = positions[graph.vertices[v]];
          area += norm(cross(positions[table.vertex(CornerTable::next(c))] - p,
                             positions[table.vertex(CornerTable::previous(c))] - p)) /
                  6;
        }
        c = table.rotate(c);
      } while (c != start);
    }
    finder.add_component(nodes, area);
  }
  return finder.result();
}

}  // namespace nmc
