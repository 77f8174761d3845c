// SPDX-License-Identifier: Apache-2.0
#include "encoder/fit/quantized_mesh.h"

#include <algorithm>
#include <string>

#include "encoder/core/error.h"
#include "encoder/core/parallel.h"

namespace nmc {

std::size_t QuantizedMesh::nonzero_count() const {
  std::size_t count = 0;
  for (const auto& level : normal)
    count += level.size() - static_cast<std::size_t>(std::count(level.begin(), level.end(), 0));
  return count;
}

void change_tangential(std::uint32_t edge, std::int32_t along, std::int32_t across,
                       std::vector<TangentialCoefficient>& list) {
  if (along == 0 && across == 0) return;
  const auto at = std::lower_bound(list.begin(), list.end(), edge,
                                   [](const TangentialCoefficient& t, std::uint32_t e) { return t.edge < e; });
  if (at == list.end() || at->edge != edge) {
    list.insert(at, {edge, along, across});
    return;
  }
  at->along += along;
  at->across += across;
  if (at->along == 0 && at->across == 0) list.erase(at);
}

std::vector<Vec3> reconstruct(const QuantizedMesh& mesh, const SubdivisionHierarchy& hierarchy, int level) {
  if (level > hierarchy.level_count())
    throw Error(ExitCode::kInternal, "the hierarchy has no level " + std::to_string(level));
  std::vector<Vec3> positions(hierarchy.level(level).vertex_count);
  for (std::size_t v = 0; v < mesh.base_coordinates.size(); ++v) {
    const auto& c = mesh.base_coordinates[v];
    positions[v] =
        mesh.base_origin + mesh.base_step * Vec3{static_cast<double>(c[0]), static_cast<double>(c[1]),
                                                 static_cast<double>(c[2])};
  }
  for (int l = 0; l < level; ++l) {
    const auto i = static_cast<std::size_t>(l);
    const LevelTopology& topology = hierarchy.level(l);
    LevelCoefficients coefficients;
    LevelQuantizer quantizer;
    const bool coded = l < mesh.level_count();
    if (coded) {
      quantizer = mesh.quantizers[i];
      if (!coefficients.normal.resize(mesh.normal[i].size()) ||
          !coefficients.tangential.resize(mesh.tangential[i].size()))
        throw Error(ExitCode::kLimit, "out of memory");
      std::copy(mesh.normal[i].begin(), mesh.normal[i].end(), coefficients.normal.data());
      std::copy(mesh.tangential[i].begin(), mesh.tangential[i].end(), coefficients.tangential.data());
    }
    constexpr std::uint32_t kRange = 1024;
    const std::size_t range_count = (topology.edge_count + kRange - 1) / kRange;
    oneapi::tbb::parallel_for(std::size_t{0}, range_count, [&](std::size_t range) {
      const auto first = static_cast<std::uint32_t>(range) * kRange;
      reconstruct_odd_vertices(topology, hierarchy.ring_weights(), quantizer, coded ? &coefficients : nullptr,
                               first, std::min(first + kRange, topology.edge_count), positions.data());
    });
  }
  return positions;
}

}  // namespace nmc
