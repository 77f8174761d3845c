// SPDX-License-Identifier: Apache-2.0
// Figs. 3.7 and 3.9 as pictures: the first levels of interpolating and variational normal meshes and of the
// fit.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "bench/thesis/experiment.h"
#include "bench/thesis/normal_mesh_model.h"
#include "bench/thesis/shaded_panel.h"
#include "encoder/normal_mesh/variational_normal_mesh.h"

namespace nmc_bench {

namespace {

// Rows: INM, VNM, fit. Columns: levels `first` to the model's last, then the input.
void draw(const Settings& settings, const Model& model, int first, const Vec3& from, const Vec3& up,
          const std::string& figure) {
  const SurfaceIndex index(model.surface->surface());
  const InterpolatingOptions options = thesis_options(model.level_count, ApertureRule::kParametric);
  const InterpolatingResult inm = interpolate(*model.surface, index, model.base, options);
  const VariationalOptions variational = thesis_options(options);
  const VariationalResult vnm = variational_normal_mesh(*model.surface, index, model.base, variational);

  std::vector<std::array<TriangleMesh, 3>> meshes;
  // One scale for all panels. Coarse levels reach beyond the input, where variational ones have few vertices
  // to be right in the mean with.
  TriangleMesh frame = *model.input;
  for (int l = first; l <= model.level_count; ++l) {
    meshes.push_back({mesh_of(inm.mesh.hierarchy, l, inm.positions),
                      mesh_of(vnm.hierarchy, l, vnm.positions[static_cast<std::size_t>(l)]),
                      fitted(model, index, options, l)});
    for (const TriangleMesh& mesh : meshes.back()) {
      const auto offset = static_cast<std::uint32_t>(frame.vertex_count());
      frame.positions.insert(frame.positions.end(), mesh.positions.begin(), mesh.positions.end());
      for (const Triangle& t : mesh.triangles)
        frame.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
    }
  }

  constexpr int kSize = 170, kTextHeight = 14;
  const char* names[3] = {"INM", "VNM", "FIT"};
  const int columns = model.level_count - first + 2;
  Image picture(columns * kSize, 3 * (kSize + kTextHeight), RgbColor{255, 255, 255});
  const auto place = [&](int row, int column, const TriangleMesh& mesh, const std::string& title) {
    picture.draw_text(column * kSize + 8, row * (kSize + kTextHeight) + 4, 1, title, RgbColor{0, 0, 0});
    picture.paste(shaded_panel(mesh, vertex_normals(mesh), nullptr, from, up, kSize, &frame), column * kSize,
                  row * (kSize + kTextHeight) + kTextHeight);
  };
  for (int l = first; l <= model.level_count; ++l)
    for (std::size_t row = 0; row < 3; ++row) {
      const TriangleMesh& mesh = meshes[static_cast<std::size_t>(l - first)][row];
      place(static_cast<int>(row), l - first, mesh,
            fmt::format("{} {}: {}", names[row], l, mesh.vertex_count()));
    }
  place(0, columns - 1, *model.input, "input");
  write_png(settings.output + "/" + figure + ".png", picture);
}

}  // namespace

void run_pictures(const Settings& settings) {
  // The eye looks at longitude 0, where frequencies end and begin: high ones on one side, low ones on the
  // other.
  if (settings.wants("zone_sphere"))
    draw(settings, on_sphere("zone sphere", zone_sphere(7), {}, 4), 1, {-1, 0, 0.25}, {0, 0, 1},
         "fig_3_7_zone_sphere_levels");
  SphereBaseOptions tetrahedron;
  tetrahedron.kind = SphereBaseKind::kTetrahedron;
  if (settings.wants("bimba_tetrahedron"))
    draw(settings, on_sphere("bimba", load_mesh(settings, "bimba.off"), tetrahedron, 5), 1, {0.3, 0.1, 1},
         {0, 1, 0}, "fig_3_9_bimba_levels");
}

}  // namespace nmc_bench
