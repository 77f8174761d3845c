// SPDX-License-Identifier: Apache-2.0
#include "encoder/fit/galerkin_hierarchy.h"

#include <algorithm>

#include "encoder/core/parallel.h"

namespace nmc {

namespace {

GalerkinMatrix matrix_of(const QuadraticEnergy& energy) {
  const std::size_t vertex_count = energy.diagonal_blocks().size();
  GalerkinMatrix m;
  m.row_begin.resize(vertex_count + 1);
  m.column.reserve(vertex_count + energy.neighbors().size());
  m.block.reserve(vertex_count + energy.neighbors().size());
  for (std::size_t v = 0; v < vertex_count; ++v) {
    m.row_begin[v] = m.column.size();
    m.column.push_back(static_cast<std::uint32_t>(v));
    m.block.push_back(energy.diagonal_blocks()[v]);
    for (std::uint32_t k = energy.neighbor_begin()[v]; k < energy.neighbor_begin()[v + 1]; ++k) {
      m.column.push_back(energy.neighbors()[k].vertex);
      m.block.push_back(energy.neighbor_blocks()[k]);
    }
  }
  m.row_begin[vertex_count] = m.column.size();
  return m;
}

/// Collects one row: a dense map from column to slot that is wiped by the columns it holds.
class RowAccumulator {
 public:
  void begin(std::size_t column_count) {
    if (slot_.size() < column_count) slot_.assign(column_count, kNone);
    columns_.clear();
    blocks_.clear();
  }
  void add(std::uint32_t column, float weight, const SymmetricMatrix3& block) {
    std::uint32_t& slot = slot_[column];
    if (slot == kNone) {
      slot = static_cast<std::uint32_t>(columns_.size());
      columns_.push_back(column);
      blocks_.emplace_back();
    }
    blocks_[slot].add(weight, block);
  }
  void end() {
    for (const std::uint32_t column : columns_) slot_[column] = kNone;
  }
  const std::vector<std::uint32_t>& columns() const { return columns_; }
  const std::vector<SymmetricMatrix3>& blocks() const { return blocks_; }

 private:
  std::vector<std::uint32_t> slot_, columns_;
  std::vector<SymmetricMatrix3> blocks_;
};

GalerkinMatrix coarsen(const LevelStencils& stencils, std::size_t coarse_count, const GalerkinMatrix& fine) {
  // Rows of a block are computed concurrently and then appended in order.
  struct Row {
    std::vector<std::uint32_t> columns;
    std::vector<SymmetricMatrix3> blocks;
  };
  GalerkinMatrix coarse;
  coarse.row_begin.resize(coarse_count + 1);
  constexpr std::size_t kBlock = std::size_t{1} << 13;
  std::vector<Row> rows(std::min(kBlock, coarse_count));
  for (std::size_t first = 0; first < coarse_count; first += kBlock) {
    const std::size_t count = std::min(kBlock, coarse_count - first);
    parallel_for(count, [&](std::size_t i) {
      thread_local RowAccumulator fine_row, accumulator;
      const std::size_t row = first + i;
      // First the row of P^T A: many of its products meet in the same column, and only their sums go through P.
      fine_row.begin(fine.row_begin.size() - 1);
      const auto add_row_of = [&](std::size_t fine_vertex, float weight) {
        for (std::size_t k = fine.row_begin[fine_vertex]; k < fine.row_begin[fine_vertex + 1]; ++k)
          fine_row.add(fine.column[k], weight, fine.block[k]);
      };
      add_row_of(row, 1);
      for (std::uint32_t s = stencils.column_begin[row]; s < stencils.column_begin[row + 1]; ++s)
        add_row_of(coarse_count + stencils.columns[s].index, stencils.columns[s].weight);
      fine_row.end();
      accumulator.begin(coarse_count);
      // The diagonal takes the first slot.
      accumulator.add(static_cast<std::uint32_t>(row), 0, {});
      for (std::size_t k = 0; k < fine_row.columns().size(); ++k) {
        const std::uint32_t column = fine_row.columns()[k];
        if (column < coarse_count) {
          accumulator.add(column, 1, fine_row.blocks()[k]);
          continue;
        }
        const std::size_t edge = column - coarse_count;
        for (std::uint32_t s = stencils.row_begin[edge]; s < stencils.row_begin[edge + 1]; ++s)
          accumulator.add(stencils.rows[s].index, stencils.rows[s].weight, fine_row.blocks()[k]);
      }
      rows[i].columns = accumulator.columns();
      rows[i].blocks = accumulator.blocks();
      accumulator.end();
    });
    for (std::size_t i = 0; i < count; ++i) {
      coarse.row_begin[first + i] = coarse.column.size();
      coarse.column.insert(coarse.column.end(), rows[i].columns.begin(), rows[i].columns.end());
      coarse.block.insert(coarse.block.end(), rows[i].blocks.begin(), rows[i].blocks.end());
    }
  }
  coarse.row_begin[coarse_count] = coarse.column.size();
  return coarse;
}

}  // namespace

void GalerkinHierarchy::build(const SynthesisOperator& synthesis, const QuadraticEnergy& energy) {
  const int finest = synthesis.hierarchy().level_count();
  matrices_.assign(static_cast<std::size_t>(finest) + 1, {});
  matrices_.back() = matrix_of(energy);
  for (int l = finest - 1; l >= 0; --l) {
    const auto level = static_cast<std::size_t>(l);
    matrices_[level] =
        coarsen(synthesis.stencils(l), synthesis.hierarchy().level(l).vertex_count, matrices_[level + 1]);
  }
}

}  // namespace nmc
