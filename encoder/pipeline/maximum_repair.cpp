// SPDX-License-Identifier: Apache-2.0
#include "encoder/pipeline/maximum_repair.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "encoder/core/parallel.h"
#include "encoder/measure/area_samples.h"
#include "libnmc/common/local_frame.h"

namespace nmc {

namespace {

/// The first rounds bring the tips back; later ones settle the contradictions between neighbours.
constexpr int kFirstDampedRound = 2;
constexpr double kDamping = 0.7;

/// Wishes of the places beyond the tolerance: vertex of the mesh -> where it should move. Of several wishes the
/// longest counts. Ordered, so the result does not depend on threads.
using Wishes = std::map<std::uint32_t, Vec3>;

void wish(std::uint32_t vertex, const Vec3& move, Wishes& wishes) {
  const auto [at, is_new] = wishes.emplace(vertex, move);
  if (!is_new && squared_norm(move) > squared_norm(at->second)) at->second = move;
}

/// The shortest joint move of the face's odd corners that brings its point at `barycentric` along by `move`,
/// no corner going farther than `largest_factor` times the move. Where odd corners have no hold on the point
/// the nearest corner moves.
void wish_at(const Triangle& face, const double (&barycentric)[3], const Vec3& move, std::uint32_t even_count,
             double largest_factor, Wishes& wishes) {
  double squares = 0;
  for (std::size_t k = 0; k < 3; ++k)
    if (face[k] >= even_count) squares += barycentric[k] * barycentric[k];
  if (squares > 0.04) {
    for (std::size_t k = 0; k < 3; ++k)
      if (face[k] >= even_count && barycentric[k] > 0.05)
        wish(face[k], std::min(barycentric[k] / squares, largest_factor) * move, wishes);
  } else {
    const auto nearest =
        static_cast<std::size_t>(std::max_element(barycentric, barycentric + 3) - barycentric);
    wish(face[nearest], move, wishes);
  }
}

/// A point of the mesh and where it should go.
struct Place {
  SurfacePoint at;
  Vec3 move;
};

std::size_t collect_wishes(const SurfaceIndex& input, const std::vector<Vec3>& positions,
                           const std::vector<Triangle>& faces, std::uint32_t even_count,
                           const MaximumRepairOptions& options, Wishes& wishes) {
  const double tolerance = options.tolerance;
  const SurfaceIndex surface(positions, faces);
  const double near = options.margin * tolerance;
  std::vector<Place> places;
  std::size_t beyond = 0;
  const auto keep_found = [&](const std::vector<Place>& found) {
    for (const Place& place : found) {
      if (!place.at.found()) continue;
      beyond += norm(place.move) > tolerance;
      places.push_back(place);
    }
  };
  const auto of_input = [&](const Vec3& point) {
    Place place;
    if (surface.is_within(point, near)) return place;
    place.at = surface.closest_point(point);
    place.move = point - place.at.position;
    return place;
  };

  std::vector<std::uint8_t> used(input.positions().size());
  for (const Triangle& t : input.triangles())
    for (const std::uint32_t v : t) used[v] = 1;
  std::vector<Place> found(used.size());
  parallel_for(found.size(), [&](std::size_t v) {
    if (used[v]) found[v] = of_input(input.positions()[v]);
  });
  keep_found(found);

  // Vertices alone would miss what lies between them: large triangles of the input, and the sides of a spike.
  const AreaSamples input_points(input.positions(), input.triangles(), options.sample_count);
  found.assign(input_points.size(), {});
  parallel_for(found.size(), [&](std::size_t i) { found[i] = of_input(input_points[i].position); });
  keep_found(found);

  const AreaSamples mesh_points(positions, faces, options.sample_count);
  found.assign(mesh_points.size(), {});
  parallel_for(found.size(), [&](std::size_t i) {
    const AreaSample sample = mesh_points[i];
    if (input.is_within(sample.position, near)) return;
    Place& place = found[i];
    place.at.triangle = sample.triangle;
    std::copy_n(sample.barycentric, 3, place.at.barycentric);
    place.move = input.closest_point(sample.position).position - sample.position;
  });
  keep_found(found);

  const double largest_factor = options.sample_count > 0 ? 1 : std::numeric_limits<double>::infinity();
  for (const Place& place : places)
    wish_at(faces[place.at.triangle], place.at.barycentric, place.move, even_count, largest_factor, wishes);

  std::vector<Vec3> moves(positions.size());
  parallel_for(positions.size(), [&](std::size_t v) {
    if (!input.is_within(positions[v], near))
      moves[v] = input.closest_point(positions[v]).position - positions[v];
  });
  for (std::uint32_t v = 0; v < moves.size(); ++v) {
    if (moves[v] == Vec3{}) continue;
    beyond += norm(moves[v]) > tolerance;
    wish(v, moves[v], wishes);
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
  const std::size_t considered = hierarchy.level(finest).vertex_count + 2 * options.sample_count;
  QuantizedMesh best = mesh;
  int best_round = 0;
  for (; result.rounds < options.maximum_rounds; ++result.rounds) {
    const std::vector<Vec3> positions = reconstruct(mesh, hierarchy, finest);
    Wishes wishes;
    const std::size_t beyond = collect_wishes(input, positions, faces, even_count, options, wishes);
    if (result.rounds == 0) {
      result.initial_beyond = result.final_beyond = beyond;
    } else if (beyond < result.final_beyond) {
      result.final_beyond = beyond;
      best_round = result.rounds;
      best = mesh;
    }
    if (beyond == 0 || result.rounds - best_round >= options.patience) break;
    if (static_cast<double>(beyond) > options.largest_share * static_cast<double>(considered)) break;
    if (options.sample_count > 0 && result.rounds >= kFirstDampedRound) {
      for (auto& [vertex, move] : wishes) move *= kDamping;
    }
    grant(wishes, hierarchy, positions, options.tolerance, mesh);
  }
  mesh = std::move(best);
  return result;
}

}  // namespace nmc
