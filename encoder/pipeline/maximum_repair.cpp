// SPDX-License-Identifier: Apache-2.0
#include "encoder/pipeline/maximum_repair.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "encoder/core/parallel.h"
#include "libnmc/common/local_frame.h"

namespace nmc {

namespace {

/// Places are brought a little inside the tolerance, so that rounding does not push them out again.
constexpr double kMargin = 0.9;

/// Wishes of the places beyond the tolerance: vertex of the mesh -> where it should move. Of several wishes the
/// longest counts. Ordered, so the result does not depend on threads.
using Wishes = std::map<std::uint32_t, Vec3>;

void wish(std::uint32_t vertex, const Vec3& move, Wishes& wishes) {
  const auto [at, is_new] = wishes.emplace(vertex, move);
  if (!is_new && squared_norm(move) > squared_norm(at->second)) at->second = move;
}

std::size_t collect_wishes(const SurfaceIndex& input, const std::vector<Vec3>& positions,
                           const std::vector<Triangle>& faces, std::uint32_t even_count, double tolerance,
                           Wishes& wishes) {
  const SurfaceIndex surface(positions, faces);
  std::vector<std::uint8_t> used(input.positions().size());
  for (const Triangle& t : input.triangles())
    for (const std::uint32_t v : t) used[v] = 1;
  std::vector<SurfacePoint> from_input(used.size()), from_mesh(positions.size());
  const double near = kMargin * tolerance;
  parallel_for(used.size(), [&](std::size_t v) {
    if (used[v] && !surface.is_within(input.positions()[v], near))
      from_input[v] = surface.closest_point(input.positions()[v]);
  });
  parallel_for(positions.size(), [&](std::size_t v) {
    if (!input.is_within(positions[v], near)) from_mesh[v] = input.closest_point(positions[v]);
  });

  std::size_t beyond = 0;
  for (std::size_t v = 0; v < used.size(); ++v) {
    const SurfacePoint& at = from_input[v];
    if (!at.found() || at.t <= near) continue;
    beyond += at.t > tolerance;
    // The shortest joint move of the odd corners that brings the point of the face to the place.
    const Vec3 move = input.positions()[v] - at.position;
    const Triangle& face = faces[at.triangle];
    double squares = 0;
    for (std::size_t k = 0; k < 3; ++k)
      if (face[k] >= even_count) squares += at.barycentric[k] * at.barycentric[k];
    if (squares > 0.04) {
      for (std::size_t k = 0; k < 3; ++k)
        if (face[k] >= even_count && at.barycentric[k] > 0.05)
          wish(face[k], (at.barycentric[k] / squares) * move, wishes);
    } else {
      const auto nearest = static_cast<std::size_t>(std::max_element(at.barycentric, at.barycentric + 3) -
                                                    at.barycentric);
      wish(face[nearest], move, wishes);
    }
  }
  for (std::size_t v = 0; v < positions.size(); ++v) {
    const SurfacePoint& at = from_mesh[v];
    if (!at.found() || at.t <= near) continue;
    beyond += at.t > tolerance;
    wish(static_cast<std::uint32_t>(v), at.position - positions[v], wishes);
  }
  return beyond;
}

std::int32_t rounded(double value) { return static_cast<std::int32_t>(std::lround(value)); }

void grant(const Wishes& wishes, const SubdivisionHierarchy& hierarchy, const std::vector<Vec3>& positions,
           double tolerance, QuantizedMesh& mesh) {
  for (const auto& [vertex, move] : wishes) {
    int level = 0;
    while (level < mesh.level_count() && vertex >= hierarchy.level(level + 1).vertex_count) ++level;
    if (level >= mesh.level_count()) continue;  // of a level without coefficients
    const LevelTopology& topology = hierarchy.level(level);
    if (vertex < topology.vertex_count) {  // of the base
      for (std::size_t k = 0; k < 3; ++k)
        mesh.base_coordinates[vertex][k] += rounded(move[static_cast<int>(k)] / mesh.base_step);
      continue;
    }
    const auto l = static_cast<std::size_t>(level);
    const std::uint32_t edge = vertex - topology.vertex_count;
    const LevelQuantizer& quantizer = mesh.quantizers[l];
    const LocalFrame frame = odd_vertex_frame(topology, edge, positions.data());
    const std::int32_t steps = rounded(dot(move, frame.normal) / quantizer.normal_step);
    mesh.normal[l][edge] += steps;
    const Vec3 rest = move - (steps * quantizer.normal_step) * frame.normal;
    if (norm(rest) < 0.5 * tolerance) continue;
    const std::int32_t along = rounded(dot(rest, frame.along) / quantizer.tangential_step);
    const std::int32_t across = rounded(dot(rest, frame.across) / quantizer.tangential_step);
    if (along == 0 && across == 0) continue;
    auto& list = mesh.tangential[l];
    const auto at = std::lower_bound(list.begin(), list.end(), edge,
                                     [](const TangentialCoefficient& t, std::uint32_t e) { return t.edge < e; });
    if (at != list.end() && at->edge == edge) {
      at->along += along;
      at->across += across;
      if (at->along == 0 && at->across == 0) list.erase(at);
    } else {
      list.insert(at, {edge, along, across});
    }
  }
}

}  // namespace

std::size_t count_beyond(const SurfaceIndex& input, const std::vector<Vec3>& positions,
                         const std::vector<Triangle>& faces, double tolerance) {
  const SurfaceIndex surface(positions, faces);
  std::vector<std::uint8_t> beyond(input.positions().size(), 0);
  for (const Triangle& t : input.triangles())
    for (const std::uint32_t v : t) beyond[v] = 1;
  parallel_for(beyond.size(), [&](std::size_t v) {
    if (beyond[v]) beyond[v] = !surface.is_within(input.positions()[v], tolerance);
  });
  const std::size_t of_mesh = parallel_sum<std::size_t>(positions.size(), [&](std::size_t v) {
    return static_cast<std::size_t>(!input.is_within(positions[v], tolerance));
  });
  return of_mesh + static_cast<std::size_t>(std::count(beyond.begin(), beyond.end(), 1));
}

MaximumRepairResult repair_maximum(const SurfaceIndex& input, const SubdivisionHierarchy& hierarchy,
                                   const MaximumRepairOptions& options, QuantizedMesh& mesh) {
  MaximumRepairResult result;
  const int finest = hierarchy.level_count();
  const std::vector<Triangle> faces = level_triangles(hierarchy.level(finest));
  const std::uint32_t even_count = finest > 0 ? hierarchy.level(finest - 1).vertex_count : 0;
  QuantizedMesh best = mesh;
  for (; result.rounds < options.maximum_rounds; ++result.rounds) {
    const std::vector<Vec3> positions = reconstruct(mesh, hierarchy, finest);
    Wishes wishes;
    const std::size_t beyond = collect_wishes(input, positions, faces, even_count, options.tolerance, wishes);
    if (result.rounds == 0) {
      result.initial_beyond = result.final_beyond = beyond;
    } else if (beyond < result.final_beyond) {
      result.final_beyond = beyond;
      best = mesh;
    }
    if (beyond == 0) break;
    if (static_cast<double>(beyond) > options.largest_share * static_cast<double>(positions.size())) break;
    grant(wishes, hierarchy, positions, options.tolerance, mesh);
  }
  mesh = std::move(best);
  return result;
}

}  // namespace nmc
