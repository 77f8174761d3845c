// SPDX-License-Identifier: Apache-2.0
#include "encoder/fit/closed_loop.h"

#include <utility>

#include "encoder/core/parallel.h"
#include "encoder/fit/round_mesh.h"

namespace nmc {

NormalMesh quantize_closed_loop(const ParameterizedSurface& map, const SurfaceIndex& index,
                                const ParameterizedBase& base, const ClosedLoopOptions& options) {
  const int level_count = options.interpolating.level_count;
  const ScalarQuantizer quantizer(options.quantize, level_count);
  NormalMesh mesh;
  for (const Vec3& p : base.positions)
    mesh.base_positions.push_back(quantizer.base_position(quantizer.base_coordinates(p)));
  mesh.hierarchy = SubdivisionHierarchy(base.faces, static_cast<std::uint32_t>(base.positions.size()),
                                        level_count, base.creases);
  mesh.tension.assign(static_cast<std::size_t>(level_count), options.interpolating.tension);
  mesh.details.resize(static_cast<std::size_t>(level_count));
  mesh.non_normal.resize(static_cast<std::size_t>(level_count));
  std::vector<Vec3> positions = mesh.base_positions;
  std::vector<SurfaceParameter> parameters = base.parameters;
  for (int l = 0; l < level_count; ++l) {
    LevelInsertion insertion =
        insert_level(map, index, mesh.hierarchy, l, positions, parameters, options.interpolating);
    parallel_for(insertion.details.size(), [&](std::size_t e) {
      OddVertexDetail& detail = insertion.details[e];
      std::int32_t along = 0, across = 0;
      quantizer.tangential(detail.along, detail.across, l, along, across);
      detail.normal = quantizer.normal(detail.normal, l) * quantizer.normal_step(l);
      detail.along = along * quantizer.tangential_step(l);
      detail.across = across * quantizer.tangential_step(l);
    });
    mesh.details[static_cast<std::size_t>(l)] = std::move(insertion.details);
    mesh.non_normal[static_cast<std::size_t>(l)] = std::move(insertion.non_normal);
    reconstruct_level(mesh, l, positions);
    parameters.insert(parameters.end(), insertion.parameters.begin(), insertion.parameters.end());
  }
  return mesh;
}

}  // namespace nmc
