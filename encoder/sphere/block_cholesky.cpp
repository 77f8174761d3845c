// SPDX-License-Identifier: Apache-2.0
#include "encoder/sphere/block_cholesky.h"

#include <oneapi/tbb/parallel_invoke.h>

#include <algorithm>

namespace nmc {

BlockCholesky::BlockCholesky(const VertexGraph& graph, const std::vector<Vec3>& positions)
    : graph_(graph), nodes_(nested_dissection(graph, positions)) {
  const std::size_t node_count = nodes_.size();
  fronts_.resize(node_count);
  subtree_size_.assign(node_count, 0);
  failed_.assign(node_count, 0);
  std::vector<std::uint32_t> elimination(graph.vertex_count());
  std::uint32_t next = 0;
  for (const DissectionNode& node : nodes_)
    for (const std::uint32_t v : node.vertices) elimination[v] = next++;
  const auto eliminated_before = [&](std::uint32_t a, std::uint32_t b) {
    return elimination[a] < elimination[b];
  };

  std::vector<std::uint32_t> place(graph.vertex_count(), 0);
  for (std::size_t i = 0; i < node_count; ++i) {
    const DissectionNode& node = nodes_[i];
    Front& front = fronts_[i];
    front.own_count = static_cast<std::uint32_t>(node.vertices.size());
    subtree_size_[i] = front.own_count;
    const std::uint32_t first_later = node.vertices.empty() ? 0 : elimination[node.vertices.back()] + 1;
    std::vector<std::uint32_t> border;
    for (const std::uint32_t v : node.vertices)
      for (std::uint32_t k = graph.offsets[v]; k < graph.offsets[v + 1]; ++k)
        if (elimination[graph.neighbors[k]] >= first_later) border.push_back(graph.neighbors[k]);
    for (const std::int32_t child : node.child) {
      if (child < 0) continue;
      subtree_size_[i] += subtree_size_[child];
      const Front& below = fronts_[child];
      for (std::size_t k = below.own_count; k < below.vertices.size(); ++k)
        if (elimination[below.vertices[k]] >= first_later) border.push_back(below.vertices[k]);
    }
    std::sort(border.begin(), border.end(), eliminated_before);
    border.erase(std::unique(border.begin(), border.end()), border.end());
    front.vertices = node.vertices;
    front.vertices.insert(front.vertices.end(), border.begin(), border.end());

    for (std::uint32_t k = 0; k < front.vertices.size(); ++k) place[front.vertices[k]] = k;
    for (std::uint32_t column = 0; column < front.own_count; ++column) {
      const std::uint32_t v = front.vertices[column];
      for (std::uint32_t k = graph.offsets[v]; k < graph.offsets[v + 1]; ++k) {
        const std::uint32_t w = graph.neighbors[k];
        // Edges to vertices eliminated earlier belong to the fronts of those.
        if (elimination[w] < elimination[v]) continue;
        front.entries.push_back({place[w], column, graph.edge_slots[k], w > v});
      }
    }
    for (int c = 0; c < 2; ++c) {
      if (node.child[c] < 0) continue;
      const Front& below = fronts_[node.child[c]];
      for (std::size_t k = below.own_count; k < below.vertices.size(); ++k)
        front.child_border[c].push_back(place[below.vertices[k]]);
    }
  }
}

void BlockCholesky::eliminate(std::size_t node, const BlockMatrix& matrix, double shift) {
  Front& front = fronts_[node];
  const Eigen::Index own = 2 * static_cast<Eigen::Index>(front.own_count);
  const Eigen::Index all = 2 * static_cast<Eigen::Index>(front.vertices.size());
  const Eigen::Index border = all - own;
  // Columns of the own vertices and the square of the border are kept apart: the first stays as the factor,
  // the second goes to the parent.
  front.factor.setZero(all, own);
  front.update.setZero(border, border);
  for (std::uint32_t k = 0; k < front.own_count; ++k) {
    const auto& block = matrix.diagonal[front.vertices[k]];
    front.factor(2 * k, 2 * k) = block[0] + shift;
    front.factor(2 * k + 1, 2 * k) = block[1];
    front.factor(2 * k + 1, 2 * k + 1) = block[2] + shift;
  }
  for (const Entry& entry : front.entries) {
    const auto& b = matrix.off_diagonal[entry.edge_slot];
    const Eigen::Index r = 2 * entry.row, c = 2 * entry.column;
    front.factor(r, c) = b[0];
    front.factor(r, c + 1) = entry.transposed ? b[2] : b[1];
    front.factor(r + 1, c) = entry.transposed ? b[1] : b[2];
    front.factor(r + 1, c + 1) = b[3];
  }
  for (int side = 0; side < 2; ++side) {
    const std::int32_t child = nodes_[node].child[side];
    if (child < 0) continue;
    Eigen::MatrixXd& update = fronts_[child].update;
    const std::vector<std::uint32_t>& map = front.child_border[side];
    // A child's border is ascending by elimination, and so is a front: rows stay below columns.
    for (std::size_t j = 0; j < map.size(); ++j) {
      const bool is_own = map[j] < front.own_count;
      for (int s = 0; s < 2; ++s) {
        double* column =
            is_own ? front.factor.col(2 * map[j] + s).data() : front.update.col(2 * map[j] - own + s).data();
        const Eigen::Index first_row = is_own ? 0 : own;
        for (std::size_t i = j; i < map.size(); ++i) {
          column[2 * map[i] - first_row] += update(2 * i, 2 * j + s);
          column[2 * map[i] + 1 - first_row] += update(2 * i + 1, 2 * j + s);
        }
      }
    }
    update.resize(0, 0);
  }

  if (own > 0) {
    auto pivot = front.factor.topRows(own);
    Eigen::Ref<Eigen::MatrixXd> pivot_block(pivot);
    const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>, Eigen::Lower> dense(pivot_block);
    if (dense.info() != Eigen::Success) {
      failed_[node] = 1;
      return;
    }
    if (border > 0) {
      auto below = front.factor.bottomRows(border);
      pivot.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(below);
      front.update.selfadjointView<Eigen::Lower>().rankUpdate(below, -1.0);
    }
  }
}

void BlockCholesky::eliminate_subtree(std::size_t node, const BlockMatrix& matrix, double shift) {
  const std::int32_t left = nodes_[node].child[0], right = nodes_[node].child[1];
  constexpr std::uint32_t kSerialVertexCount = 500;
  if (left >= 0 && right >= 0 && subtree_size_[node] > kSerialVertexCount) {
    // The children write to their own fronts only, and the parent adds them in fixed order.
    oneapi::tbb::parallel_invoke([&] { eliminate_subtree(left, matrix, shift); },
                                 [&] { eliminate_subtree(right, matrix, shift); });
  } else {
    if (left >= 0) eliminate_subtree(left, matrix, shift);
    if (right >= 0) eliminate_subtree(right, matrix, shift);
  }
  if ((left >= 0 && failed_[left]) || (right >= 0 && failed_[right])) {
    failed_[node] = 1;
    return;
  }
  eliminate(node, matrix, shift);
}

bool BlockCholesky::factorize(const BlockMatrix& matrix, double shift) {
  std::fill(failed_.begin(), failed_.end(), 0);
  eliminate_subtree(nodes_.size() - 1, matrix, shift);
  return !failed_.back();
}

std::vector<Tangent2> BlockCholesky::solve(const std::vector<Tangent2>& right_hand_side) const {
  std::vector<Tangent2> x = right_hand_side;
  Eigen::VectorXd local;
  const auto gather = [&](const Front& front) {
    local.resize(2 * static_cast<Eigen::Index>(front.vertices.size()));
    for (std::size_t k = 0; k < front.vertices.size(); ++k) {
      local[2 * k] = x[front.vertices[k]][0];
      local[2 * k + 1] = x[front.vertices[k]][1];
    }
  };
  const auto scatter = [&](const Front& front, std::size_t count) {
    for (std::size_t k = 0; k < count; ++k) x[front.vertices[k]] = {local[2 * k], local[2 * k + 1]};
  };
  for (const Front& front : fronts_) {
    const Eigen::Index own = 2 * static_cast<Eigen::Index>(front.own_count);
    if (own == 0) continue;
    gather(front);
    const Eigen::Index border = local.size() - own;
    auto head = local.head(own);
    front.factor.topRows(own).triangularView<Eigen::Lower>().solveInPlace(head);
    if (border > 0) local.tail(border).noalias() -= front.factor.bottomRows(border) * head;
    scatter(front, front.vertices.size());
  }
  for (std::size_t i = fronts_.size(); i-- > 0;) {
    const Front& front = fronts_[i];
    const Eigen::Index own = 2 * static_cast<Eigen::Index>(front.own_count);
    if (own == 0) continue;
    gather(front);
    const Eigen::Index border = local.size() - own;
    auto head = local.head(own);
    if (border > 0) head.noalias() -= front.factor.bottomRows(border).transpose() * local.tail(border);
    front.factor.topRows(own).triangularView<Eigen::Lower>().transpose().solveInPlace(head);
    scatter(front, front.own_count);
  }
  return x;
}

}  // namespace nmc
