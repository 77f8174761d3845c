// SPDX-License-Identifier: Apache-2.0
// The thesis's open problem (3.7, 5.2): what one scalar per vertex can do beside a scalar per vertex and
// level, and beside vectors. Interpolating, variational, fitted and unconstrained meshes over the same base
// and levels.
#include <fmt/format.h>

#include <cmath>

#include "bench/thesis/experiment.h"
#include "bench/thesis/normal_mesh_model.h"
#include "encoder/fit/hierarchy_comparison.h"
#include "encoder/normal_mesh/sample_correspondences.h"

namespace nmc_bench {

using namespace nmc;

void run_hierarchies(const Settings& settings) {
  constexpr int kBaseSize = 250, kLevels = 4;
  Table table({"model", "base (levels)", "vertices", "method", "RMS", "PSNR dB", "max"});
  for (const char* file : {"horse.ply", "igea.ply"}) {
    if (!settings.wants(file)) continue;
    const Model model = on_domain(file, load_mesh(settings, file), kBaseSize, kLevels);
    const SurfaceIndex index(model.surface->surface());
    const SurfaceIndex input_index(*model.input);
    InterpolatingOptions interpolating;
    interpolating.level_count = kLevels;
    InterpolatingResult inm = interpolate(*model.surface, index, model.base, interpolating);
    const std::vector<SurfaceSample> samples = sample_correspondences(
        *model.surface, index, inm.mesh.hierarchy.level(kLevels), kLevels, inm.positions, inm.parameters);
    const std::vector<Vec3> normals = vertex_normals(model.surface->surface());
    const InputSurface input{index, normals};
    const HierarchyComparison meshes = compare_hierarchies({}, &input, samples, inm.mesh);
    const auto add = [&](const char* method, const std::vector<Vec3>& positions) {
      CompareOptions options;
      options.sample_count = 200000;
      options.normals = false;
      options.vertices = false;
      options.original_index = &input_index;
      const CompareResult error =
          compare_meshes(*model.input, mesh_of(inm.mesh.hierarchy, kLevels, positions), options);
      const double rms = error.relative_rms();
      table.add({file, fmt::format("{} ({})", model.base.positions.size(), kLevels),
                 fmt::format("{}", positions.size()), method, fmt::format("{:.2e}", rms),
                 fmt::format("{:.1f}", -20 * std::log10(rms)),
                 fmt::format("{:.1e}", error.maximum * rms / error.rms)});
    };
    add("interpolating (INM)", meshes.interpolating);
    add("variational (VNM)", meshes.variational);
    add("fit", meshes.fit);
    add("unconstrained vectors (VVM)", meshes.vectors);
  }
  table.print();
  table.write_csv(settings.output + "/hierarchies.csv");
}

}  // namespace nmc_bench
