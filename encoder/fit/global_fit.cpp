// SPDX-License-Identifier: Apache-2.0
#include "encoder/fit/global_fit.h"

#include <utility>

namespace nmc {

UnknownLayout unknown_layout(const NormalMesh& mesh, int coded_level_count) {
  std::vector<std::vector<std::uint32_t>> tangential(static_cast<std::size_t>(coded_level_count));
  for (int l = 0; l < coded_level_count; ++l) {
    const auto level = static_cast<std::size_t>(l);
    const LevelTopology& topology = mesh.hierarchy.level(l);
    for (std::uint32_t e = 0; e < topology.edge_count; ++e) {
      const bool non_normal =
          level < mesh.non_normal.size() && !mesh.non_normal[level].empty() && mesh.non_normal[level][e];
      const OddVertexDetail& d = mesh.details[level][e];
      if (non_normal || topology.is_curve(e) || d.along != 0 || d.across != 0) tangential[level].push_back(e);
    }
  }
  return UnknownLayout(mesh.hierarchy, coded_level_count, std::move(tangential));
}

std::vector<double> values_of(const NormalMesh& mesh, const UnknownLayout& layout) {
  std::vector<double> values(layout.count, 0.0);
  for (std::size_t v = 0; v < layout.base_vertex_count; ++v)
    for (int k = 0; k < 3; ++k) values[3 * v + static_cast<std::size_t>(k)] = mesh.base_positions[v][k];
  for (std::size_t l = 0; l + 1 < layout.normal_begin.size(); ++l) {
    for (std::size_t e = 0; e < mesh.details[l].size(); ++e)
      values[layout.normal_begin[l] + e] = mesh.details[l][e].normal;
    for (std::size_t i = 0; i < layout.tangential_edges[l].size(); ++i) {
      const OddVertexDetail& d = mesh.details[l][layout.tangential_edges[l][i]];
      values[layout.tangential_begin[l] + 2 * i] = d.along;
      values[layout.tangential_begin[l] + 2 * i + 1] = d.across;
    }
  }
  return values;
}

void store_values(const std::vector<double>& values, const UnknownLayout& layout, NormalMesh& mesh) {
  for (std::size_t v = 0; v < layout.base_vertex_count; ++v)
    mesh.base_positions[v] = {values[3 * v], values[3 * v + 1], values[3 * v + 2]};
  for (std::size_t l = 0; l + 1 < layout.normal_begin.size(); ++l) {
    for (std::size_t e = 0; e < mesh.details[l].size(); ++e)
      mesh.details[l][e].normal = values[layout.normal_begin[l] + e];
    for (std::size_t i = 0; i < layout.tangential_edges[l].size(); ++i) {
      OddVertexDetail& d = mesh.details[l][layout.tangential_edges[l][i]];
      d.along = values[layout.tangential_begin[l] + 2 * i];
      d.across = values[layout.tangential_begin[l] + 2 * i + 1];
    }
  }
}

std::vector<std::uint8_t> free_unknowns(const NormalMesh& mesh, const UnknownLayout& layout,
                                        bool free_tangentials) {
  std::vector<std::uint8_t> active(layout.count, 1);
  for (int l = 0; l < layout.coded_level_count; ++l) {
    const auto level = static_cast<std::size_t>(l);
    for (std::size_t i = 0; i < layout.tangential_edges[level].size(); ++i) {
      const bool curve = mesh.hierarchy.level(l).is_curve(layout.tangential_edges[level][i]);
      const std::size_t unknown = layout.tangential_begin[level] + 2 * i;
      active[unknown] = !curve && free_tangentials;
      active[unknown + 1] = curve || free_tangentials;
    }
  }
  return active;
}

GlobalFitResult global_fit(const GlobalFitOptions& options, const InputSurface* input,
                           std::vector<SurfaceSample>& samples, NormalMesh& mesh) {
  const int coded = options.coded_level_count < 0 ? mesh.level_count() : options.coded_level_count;
  FitSystem system(mesh.hierarchy, unknown_layout(mesh, coded), mesh.tension);
  const std::vector<std::uint8_t> active = free_unknowns(mesh, system.layout(), options.free_tangentials);
  std::vector<double> values = values_of(mesh, system.layout());
  const LevelTopology& finest = mesh.hierarchy.level(mesh.level_count());
  GlobalFitResult result;
  std::vector<Vec3> positions;
  const std::size_t sample_count = samples.size();
  const int rounds = input ? options.reprojection_count + 1 : 1;
  for (int round = 0; round < rounds; ++round) {
    system.synthesis().positions_of(values, positions);
    if (round > 0) reproject_samples(*input, finest, positions, options.reprojection, samples);
    if (round > 0 && round + 1 == rounds && options.reach_multiple > 0) {
      append_input_samples(*input, finest, positions, sample_count / 8, system.energy().total_weight(),
                           options.reach_multiple * result.final_rms, samples);
    }
    system.set_samples(samples, positions, options.energy);
    const MinimizeResult r = system.minimize(active, options.minimize, values);
    if (round == 0) result.initial_rms = system.energy().root_mean_square(r.initial_energy);
    result.final_rms = system.energy().root_mean_square(r.final_energy);
    result.outer += r.outer;
    result.inner += r.inner;
  }
  samples.resize(sample_count);
  store_values(values, system.layout(), mesh);
  return result;
}

}  // namespace nmc
