// SPDX-License-Identifier: Apache-2.0
#include "encoder/fit/synthesis_operator.h"

#include <algorithm>
#include <utility>

#include "encoder/core/parallel.h"
#include "libnmc/common/butterfly.h"
#include "libnmc/common/local_frame.h"

namespace nmc {

UnknownLayout::UnknownLayout(const SubdivisionHierarchy& hierarchy, int coded_levels,
                             std::vector<std::vector<std::uint32_t>> tangential)
    : coded_level_count(coded_levels),
      base_vertex_count(hierarchy.level(0).vertex_count),
      tangential_edges(std::move(tangential)) {
  tangential_edges.resize(static_cast<std::size_t>(coded_levels));
  count = 3 * base_vertex_count;
  for (int l = 0; l < coded_levels; ++l) {
    normal_begin.push_back(count);
    count += hierarchy.level(l).edge_count;
  }
  normal_begin.push_back(count);
  for (const auto& edges : tangential_edges) {
    tangential_begin.push_back(count);
    count += 2 * edges.size();
  }
  tangential_begin.push_back(count);
}

LevelStencils::LevelStencils(const LevelTopology& topology, const RingWeights& ring_weights,
                             Tension tension) {
  const std::uint32_t edge_count = topology.edge_count, vertex_count = topology.vertex_count;
  row_begin.reserve(std::size_t{edge_count} + 1);
  row_begin.push_back(0);
  rows.reserve(std::size_t{8} * edge_count);
  for (std::uint32_t e = 0; e < edge_count; ++e) {
    const std::size_t begin = rows.size();
    visit_stencil(topology, ring_weights, e, tension, [&](std::uint32_t v, double w) {
      for (std::size_t i = begin; i < rows.size(); ++i) {
        if (rows[i].index == v) {
          rows[i].weight += static_cast<float>(w);
          return;
        }
      }
      rows.push_back({v, static_cast<float>(w)});
    });
    rows.erase(std::remove_if(rows.begin() + static_cast<std::ptrdiff_t>(begin), rows.end(),
                              [](const StencilEntry& s) { return s.weight == 0; }),
               rows.end());
    row_begin.push_back(static_cast<std::uint32_t>(rows.size()));
  }
  column_begin.assign(std::size_t{vertex_count} + 1, 0);
  for (const StencilEntry& s : rows) ++column_begin[s.index + 1];
  for (std::uint32_t v = 0; v < vertex_count; ++v) column_begin[v + 1] += column_begin[v];
  columns.resize(rows.size());
  std::vector<std::uint32_t> next(column_begin.begin(), column_begin.end() - 1);
  for (std::uint32_t e = 0; e < edge_count; ++e)
    for (std::uint32_t i = row_begin[e]; i < row_begin[e + 1]; ++i)
      columns[next[rows[i].index]++] = {e, rows[i].weight};
}

SynthesisOperator::SynthesisOperator(const SubdivisionHierarchy& hierarchy, UnknownLayout layout,
                                     std::vector<double> tension)
    : hierarchy_(hierarchy), layout_(std::move(layout)), tension_(std::move(tension)) {
  const int level_count = hierarchy.level_count();
  tension_.resize(static_cast<std::size_t>(level_count), 1.0);
  for (int l = 0; l < level_count; ++l)
    stencils_.emplace_back(hierarchy.level(l), hierarchy.ring_weights(),
                           Tension{tension_[static_cast<std::size_t>(l)]});
  finest_vertex_count_ = hierarchy.level(level_count).vertex_count;
  normals_.resize(layout_.normal_begin.back() - layout_.normal_begin.front());
  frames_.resize(layout_.tangential_begin.back() - layout_.tangential_begin.front());
}

template <bool kFreeze, class Self>
void SynthesisOperator::decode(Self& self, const std::vector<double>& values, std::vector<Vec3>& positions) {
  const UnknownLayout& layout = self.layout_;
  positions.resize(self.finest_vertex_count_);
  for (std::size_t v = 0; v < layout.base_vertex_count; ++v)
    positions[v] = {values[3 * v], values[3 * v + 1], values[3 * v + 2]};
  for (int l = 0; l < self.hierarchy_.level_count(); ++l) {
    const auto level = static_cast<std::size_t>(l);
    const LevelTopology& topology = self.hierarchy_.level(l);
    const Tension tension{self.tension_[level]};
    const bool coded = l < layout.coded_level_count;
    Vec3* odd = positions.data() + topology.vertex_count;
    parallel_for(topology.edge_count, [&](std::size_t i) {
      const auto edge = static_cast<std::uint32_t>(i);
      odd[i] = predict_odd_vertex(topology, self.hierarchy_.ring_weights(), edge, tension, positions.data());
      if (!coded) return;
      const double c = values[layout.normal_begin[level] + i];
      if (!kFreeze && c == 0) return;
      const Vec3 normal = odd_vertex_normal(topology, edge, positions.data());
      if constexpr (kFreeze) self.normals_[layout.normal_begin[level] - layout.normal_begin[0] + i] = normal;
      odd[i] = odd[i] + c * normal;
    });
    if (!coded) continue;
    const std::vector<std::uint32_t>& edges = layout.tangential_edges[level];
    parallel_for(edges.size(), [&](std::size_t i) {
      const LocalFrame frame = odd_vertex_frame(topology, edges[i], positions.data());
      const std::size_t unknown = layout.tangential_begin[level] + 2 * i;
      if constexpr (kFreeze) {
        self.frames_[unknown - layout.tangential_begin[0]] = frame.along;
        self.frames_[unknown - layout.tangential_begin[0] + 1] = frame.across;
      }
      odd[edges[i]] = odd[edges[i]] + values[unknown] * frame.along + values[unknown + 1] * frame.across;
    });
  }
}

void SynthesisOperator::synthesize(const std::vector<double>& values, std::vector<Vec3>& positions) {
  decode<true>(*this, values, positions);
}

void SynthesisOperator::positions_of(const std::vector<double>& values, std::vector<Vec3>& positions) const {
  decode<false>(*this, values, positions);
}

namespace {

Vec3 gather(const std::vector<std::uint32_t>& begin, const std::vector<StencilEntry>& entries, std::size_t i,
            const Vec3* values) {
  double x = 0, y = 0, z = 0;
  for (std::uint32_t k = begin[i]; k < begin[i + 1]; ++k) {
    const Vec3& v = values[entries[k].index];
    const double w = entries[k].weight;
    x += w * v.x;
    y += w * v.y;
    z += w * v.z;
  }
  return {x, y, z};
}

}  // namespace

void SynthesisOperator::forward(const std::vector<double>& change, std::vector<Vec3>& v) const {
  v.resize(finest_vertex_count_);
  for (std::size_t i = 0; i < layout_.base_vertex_count; ++i)
    v[i] = {change[3 * i], change[3 * i + 1], change[3 * i + 2]};
  for (int l = 0; l < hierarchy_.level_count(); ++l) {
    const auto level = static_cast<std::size_t>(l);
    const LevelStencils& stencils = stencils_[level];
    const bool coded = l < layout_.coded_level_count;
    const double* c = coded ? change.data() + layout_.normal_begin[level] : nullptr;
    const Vec3* normals =
        coded ? normals_.data() + (layout_.normal_begin[level] - layout_.normal_begin[0]) : nullptr;
    Vec3* odd = v.data() + hierarchy_.level(l).vertex_count;
    parallel_for(hierarchy_.level(l).edge_count, [&](std::size_t e) {
      Vec3 p = gather(stencils.row_begin, stencils.rows, e, v.data());
      if (coded) p += c[e] * normals[e];
      odd[e] = p;
    });
    if (!coded) continue;
    const std::vector<std::uint32_t>& edges = layout_.tangential_edges[level];
    for (std::size_t i = 0; i < edges.size(); ++i) {
      const Vec3* frame = tangential_frame(l, i);
      const double* t = change.data() + layout_.tangential_begin[level] + 2 * i;
      odd[edges[i]] += t[0] * frame[0] + t[1] * frame[1];
    }
  }
}

void SynthesisOperator::adjoint(std::vector<Vec3>& force, std::vector<double>& dual) const {
  dual.resize(layout_.count);
  for (int l = hierarchy_.level_count() - 1; l >= 0; --l) {
    const auto level = static_cast<std::size_t>(l);
    const LevelStencils& stencils = stencils_[level];
    const LevelTopology& topology = hierarchy_.level(l);
    const Vec3* odd = force.data() + topology.vertex_count;
    if (l < layout_.coded_level_count) {
      double* c = dual.data() + layout_.normal_begin[level];
      const Vec3* normals = normals_.data() + (layout_.normal_begin[level] - layout_.normal_begin[0]);
      parallel_for(topology.edge_count, [&](std::size_t e) { c[e] = dot(normals[e], odd[e]); });
      const std::vector<std::uint32_t>& edges = layout_.tangential_edges[level];
      for (std::size_t i = 0; i < edges.size(); ++i) {
        const Vec3* frame = tangential_frame(l, i);
        double* t = dual.data() + layout_.tangential_begin[level] + 2 * i;
        t[0] = dot(frame[0], odd[edges[i]]);
        t[1] = dot(frame[1], odd[edges[i]]);
      }
    }
    parallel_for(topology.vertex_count,
                 [&](std::size_t i) { force[i] += gather(stencils.column_begin, stencils.columns, i, odd); });
  }
  for (std::size_t i = 0; i < layout_.base_vertex_count; ++i)
    for (int k = 0; k < 3; ++k) dual[3 * i + static_cast<std::size_t>(k)] = force[i][k];
}

void SynthesisOperator::analyze(const std::vector<double>& scalars, std::vector<double>& change) const {
  change.assign(layout_.count, 0.0);
  const int coded = layout_.coded_level_count;
  std::vector<Vec3> v(hierarchy_.level(coded).vertex_count);
  for (std::size_t i = 0; i < layout_.base_vertex_count; ++i) {
    v[i] = {scalars[3 * i], scalars[3 * i + 1], scalars[3 * i + 2]};
    for (std::size_t k = 0; k < 3; ++k) change[3 * i + k] = scalars[3 * i + k];
  }
  for (int l = 0; l < coded; ++l) {
    const auto level = static_cast<std::size_t>(l);
    const LevelStencils& stencils = stencils_[level];
    const std::size_t begin = layout_.normal_begin[level];
    const Vec3* normals = normals_.data() + (begin - layout_.normal_begin[0]);
    Vec3* odd = v.data() + hierarchy_.level(l).vertex_count;
    parallel_for(hierarchy_.level(l).edge_count, [&](std::size_t e) {
      const Vec3 p = gather(stencils.row_begin, stencils.rows, e, v.data());
      const double c = scalars[begin + e] - dot(normals[e], p);
      change[begin + e] = c;
      odd[e] = p + c * normals[e];
    });
  }
}

void SynthesisOperator::analyze_transposed(const std::vector<double>& dual,
                                           std::vector<double>& scalar_dual) const {
  scalar_dual.assign(layout_.count, 0.0);
  const int coded = layout_.coded_level_count;
  std::vector<Vec3> force(hierarchy_.level(coded).vertex_count);
  for (int l = coded - 1; l >= 0; --l) {
    const auto level = static_cast<std::size_t>(l);
    const LevelStencils& stencils = stencils_[level];
    const std::size_t begin = layout_.normal_begin[level];
    const Vec3* normals = normals_.data() + (begin - layout_.normal_begin[0]);
    const LevelTopology& topology = hierarchy_.level(l);
    Vec3* odd = force.data() + topology.vertex_count;
    parallel_for(topology.edge_count, [&](std::size_t e) {
      const double along_normal = dot(normals[e], odd[e]);
      scalar_dual[begin + e] = dual[begin + e] + along_normal;
      odd[e] -= (along_normal + dual[begin + e]) * normals[e];
    });
    parallel_for(topology.vertex_count,
                 [&](std::size_t i) { force[i] += gather(stencils.column_begin, stencils.columns, i, odd); });
  }
  for (std::size_t i = 0; i < layout_.base_vertex_count; ++i)
    for (int k = 0; k < 3; ++k) {
      const std::size_t unknown = 3 * i + static_cast<std::size_t>(k);
      scalar_dual[unknown] = dual[unknown] + force[i][k];
    }
}

}  // namespace nmc
