// SPDX-License-Identifier: Apache-2.0
#include "encoder/normal_mesh/normal_mesh.h"

#include "encoder/core/parallel.h"
#include "libnmc/common/local_frame.h"

namespace nmc {

void reconstruct_level(const NormalMesh& mesh, int level, std::vector<Vec3>& positions) {
  const LevelTopology& topology = mesh.hierarchy.level(level);
  const auto l = static_cast<std::size_t>(level);
  const Tension tension{mesh.tension.empty() ? 1.0 : mesh.tension[l]};
  positions.resize(std::size_t{topology.vertex_count} + topology.edge_count);
  parallel_for(topology.edge_count, [&](std::size_t i) {
    const auto edge = static_cast<std::uint32_t>(i);
    Vec3 p = predict_odd_vertex(topology, mesh.hierarchy.ring_weights(), edge, tension, positions.data());
    const OddVertexDetail& d = mesh.details[l][i];
    if (d.across != 0 || d.along != 0) {
      const LocalFrame frame = odd_vertex_frame(topology, edge, positions.data());
      p = p + d.normal * frame.normal;
      p = p + d.along * frame.along;
      p = p + d.across * frame.across;
    } else if (d.normal != 0) {
      p = p + d.normal * odd_vertex_normal(topology, edge, positions.data());
    }
    positions[topology.vertex_count + i] = p;
  });
}

std::vector<Vec3> reconstruct(const NormalMesh& mesh, int level) {
  std::vector<Vec3> positions = mesh.base_positions;
  for (int l = 0; l < level; ++l) reconstruct_level(mesh, l, positions);
  return positions;
}

}  // namespace nmc
