// SPDX-License-Identifier: Apache-2.0
#include "encoder/sphere/nested_dissection.h"

#include <Eigen/Dense>
#include <algorithm>
#include <numeric>

namespace nmc {

namespace {

class Dissection {
 public:
  Dissection(const VertexGraph& graph, const std::vector<Vec3>& positions, std::uint32_t leaf_vertex_count)
      : graph_(graph), positions_(positions), leaf_vertex_count_(leaf_vertex_count) {
    side_.assign(graph.vertex_count(), kOutside);
  }

  std::vector<DissectionNode> run() {
    std::vector<std::uint32_t> all(graph_.vertex_count());
    std::iota(all.begin(), all.end(), 0u);
    dissect(std::move(all));
    return std::move(nodes_);
  }

 private:
  enum Side : std::uint8_t { kOutside, kBelow, kAbove };

  std::int32_t add_node(std::vector<std::uint32_t> vertices, std::int32_t below, std::int32_t above) {
    const std::int32_t index = static_cast<std::int32_t>(nodes_.size());
    DissectionNode node;
    node.vertices = std::move(vertices);
    node.child[0] = below;
    node.child[1] = above;
    if (below >= 0) nodes_[below].parent = index;
    if (above >= 0) nodes_[above].parent = index;
    nodes_.push_back(std::move(node));
    return index;
  }

  std::int32_t dissect(std::vector<std::uint32_t> vertices) {
    if (vertices.size() <= leaf_vertex_count_) return add_node(std::move(vertices), -1, -1);

    // Cut at the median along each principal axis; the cut with the smallest separator wins.
    Vec3 mean;
    for (const std::uint32_t v : vertices) mean += positions_[v];
    mean *= 1 / static_cast<double>(vertices.size());
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (const std::uint32_t v : vertices) {
      const Vec3 d = positions_[v] - mean;
      const Eigen::Vector3d e(d.x, d.y, d.z);
      covariance += e * e.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance);
    std::vector<std::uint32_t> best_order, best_separator;
    for (int axis = 2; axis >= 1; --axis) {
      const Eigen::Vector3d a = eigen.eigenvectors().col(axis);
      std::vector<std::uint32_t> order = median_split(vertices, {a[0], a[1], a[2]});
      std::vector<std::uint32_t> separator = smaller_boundary(order);
      if (best_order.empty() || separator.size() < best_separator.size()) {
        best_order = std::move(order);
        best_separator = std::move(separator);
      }
    }

    const std::size_t half = best_order.size() / 2;
    std::vector<std::uint32_t> below, above;
    std::sort(best_separator.begin(), best_separator.end());
    for (std::size_t i = 0; i < best_order.size(); ++i) {
      const std::uint32_t v = best_order[i];
      if (std::binary_search(best_separator.begin(), best_separator.end(), v)) continue;
      (i < half ? below : above).push_back(v);
    }
    // A set so dense that one side is all separator is one dense block.
    if (below.empty() || above.empty()) return add_node(std::move(vertices), -1, -1);
    vertices = {};
    best_order = {};
    const std::int32_t first = dissect(std::move(below));
    const std::int32_t second = dissect(std::move(above));
    return add_node(std::move(best_separator), first, second);
  }

  std::vector<std::uint32_t> median_split(const std::vector<std::uint32_t>& vertices,
                                          const Vec3& axis) const {
    std::vector<std::pair<double, std::uint32_t>> keyed(vertices.size());
    for (std::size_t i = 0; i < vertices.size(); ++i)
      keyed[i] = {dot(positions_[vertices[i]], axis), vertices[i]};
    std::nth_element(keyed.begin(), keyed.begin() + keyed.size() / 2, keyed.end());
    std::vector<std::uint32_t> order(vertices.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = keyed[i].second;
    return order;
  }

  std::vector<std::uint32_t> smaller_boundary(const std::vector<std::uint32_t>& order) {
    const std::size_t half = order.size() / 2;
    for (std::size_t i = 0; i < order.size(); ++i) side_[order[i]] = i < half ? kBelow : kAbove;
    std::vector<std::uint32_t> boundary[2];
    for (const std::uint32_t v : order) {
      const Side other = side_[v] == kBelow ? kAbove : kBelow;
      for (std::uint32_t i = graph_.offsets[v]; i < graph_.offsets[v + 1]; ++i) {
        if (side_[graph_.neighbors[i]] != other) continue;
        boundary[side_[v] == kBelow ? 0 : 1].push_back(v);
        break;
      }
    }
    for (const std::uint32_t v : order) side_[v] = kOutside;
    return std::move(boundary[boundary[0].size() <= boundary[1].size() ? 0 : 1]);
  }

  const VertexGraph& graph_;
  const std::vector<Vec3>& positions_;
  const std::uint32_t leaf_vertex_count_;
  std::vector<Side> side_;
  std::vector<DissectionNode> nodes_;
};

}  // namespace

std::vector<DissectionNode> nested_dissection(const VertexGraph& graph, const std::vector<Vec3>& positions,
                                              std::uint32_t leaf_vertex_count) {
  return Dissection(graph, positions, leaf_vertex_count).run();
}

}  // namespace nmc
