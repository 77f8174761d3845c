// SPDX-License-Identifier: Apache-2.0
#include "encoder/pipeline/maximum_repair.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "encoder/core/parallel.h"
#include "encoder/measure/area_samples.h"
#include "encoder/pipeline/place_settling.h"
#include "libnmc/common/local_frame.h"

namespace nmc {

namespace {

/// Coarser vertices move everything around them, so they go no farther than they must: to this many tolerances, in
/// later rounds to more of them, where neighbours push each other to and fro.
double wished_distance(int round) { return std::min(0.85 + 0.03 * round, 0.97); }

/// More of them are first thinned out without a look at what each move does.
constexpr std::size_t kManyPlaces = 250;
constexpr std::uint32_t kAllVertices = 0xffffffffu;
constexpr double kShareOfSecondStart = 0.4;
/// So many times the best round's places, and more than a few: what is wished for only pushes the surface about.
constexpr std::size_t kDiverged = 3, kFewPlaces = 50;

/// Wishes of the places beyond the tolerance: vertex of the mesh -> where it should move. Of several wishes the
/// longest counts. Ordered, so the result does not depend on threads.
using Wishes = std::map<std::uint32_t, Vec3>;

void wish(std::uint32_t vertex, const Vec3& move, Wishes& wishes) {
  const auto [at, is_new] = wishes.emplace(vertex, move);
  if (!is_new && squared_norm(move) > squared_norm(at->second)) at->second = move;
}

/// The corner that moves is the nearest of those below `even_count`: what settling has left has to do with coarser
/// levels.
void wish_at(const Triangle& face, const double (&barycentric)[3], const Vec3& move, std::uint32_t even_count,
             Wishes& wishes) {
  constexpr double kLeastHold = 0.1;  // a corner with less of it does not move the place
  std::size_t nearest = 3;
  for (std::size_t k = 0; k < 3; ++k)
    if (face[k] < even_count && barycentric[k] > kLeastHold &&
        (nearest == 3 || barycentric[k] > barycentric[nearest]))
      nearest = k;
  if (nearest < 3) wish(face[nearest], move, wishes);
}

std::vector<Vec3> points_of(const SurfaceIndex& input, std::size_t sample_count) {
  std::vector<std::uint8_t> used(input.positions().size());
  for (const Triangle& t : input.triangles())
    for (const std::uint32_t v : t) used[v] = 1;
  std::vector<Vec3> points;
  for (std::size_t v = 0; v < used.size(); ++v)
    if (used[v]) points.push_back(input.positions()[v]);
  // Vertices alone would miss what lies between them: large triangles of the input, and the sides of a spike.
  const AreaSamples samples(input.positions(), input.triangles(), sample_count);
  const std::size_t vertex_count = points.size();
  points.resize(vertex_count + samples.size());
  parallel_for(samples.size(), [&](std::size_t i) { points[vertex_count + i] = samples[i].position; });
  return points;
}

/// Finds the places of a mesh again and again while its integers change. All references must outlive the object.
class PlaceSearch {
 public:
  PlaceSearch(const SurfaceIndex& input, const std::vector<Vec3>& input_points, const std::vector<Triangle>& faces,
              const MaximumRepairOptions& options)
      : input_(input),
        input_points_(input_points),
        faces_(faces),
        tolerance_(options.tolerance),
        near_(options.margin * options.tolerance),
        mesh_sample_count_(options.mesh_sample_count),
        is_far_point_(input_points.size(), 0),
        is_far_face_(faces.size(), 0) {}

  /// Places of the mesh at `positions`, of which `surface` is the index, that are farther than the margin; `beyond`
  /// counts those beyond the tolerance. `everything`: looked at; else what has to do with faces changed since the last
  /// call, and the places of that call. This leaves out only that points between the vertices of other faces slide a
  /// little when areas change.
  std::vector<Place> find(const SurfaceIndex& surface, const std::vector<Vec3>& positions, bool everything,
                          std::size_t& beyond) {
    std::vector<std::uint8_t> is_looked_at(faces_.size(), 1);
    std::unique_ptr<SurfaceIndex> left_behind;  // the changed faces as they were: points near others are held still
    if (!everything) {
      std::vector<Triangle> changed;
      for (std::size_t f = 0; f < faces_.size(); ++f) {
        const bool is_changed = std::any_of(faces_[f].begin(), faces_[f].end(), [&](std::uint32_t v) {
          return positions[v] != last_positions_[v];
        });
        if (is_changed) changed.push_back(faces_[f]);
        is_looked_at[f] = is_changed || is_far_face_[f];
      }
      if (!changed.empty()) left_behind = std::make_unique<SurfaceIndex>(last_positions_, changed);
    }
    std::vector<Place> places;
    beyond = 0;
    std::vector<Place> found;
    const auto keep_found = [&] {
      for (const Place& place : found) {
        if (!place.at.found()) continue;
        beyond += norm(place.move) > tolerance_;
        places.push_back(place);
      }
    };
    found.assign(input_points_.size(), {});
    parallel_for(found.size(), [&](std::size_t i) {
      const Vec3& point = input_points_[i];
      if (!everything && !is_far_point_[i] && !(left_behind && left_behind->is_within(point, near_))) return;
      is_far_point_[i] = !surface.is_within(point, near_);
      if (!is_far_point_[i]) return;
      found[i].at = surface.closest_point(point);
      found[i].move = point - found[i].at.position;
    });
    keep_found();

    const std::size_t first_of_mesh = places.size();
    const AreaSamples mesh_points(positions, faces_, mesh_sample_count_);
    found.assign(mesh_points.size(), {});
    parallel_for(found.size(), [&](std::size_t i) {
      const AreaSample sample = mesh_points[i];
      if (!is_looked_at[sample.triangle] || input_.is_within(sample.position, near_)) return;
      Place& place = found[i];
      place.at.triangle = sample.triangle;
      std::copy_n(sample.barycentric, 3, place.at.barycentric);
      place.move = input_.closest_point(sample.position).position - sample.position;
    });
    keep_found();

    // Each vertex in the first face that has it.
    std::vector<std::uint32_t> face_of(positions.size(), kNoTriangle);
    for (std::size_t f = faces_.size(); f-- > 0;) {
      for (const std::uint32_t v : faces_[f])
        if (is_looked_at[f] || face_of[v] != kNoTriangle) face_of[v] = static_cast<std::uint32_t>(f);
    }
    std::vector<Vec3> moves(positions.size());
    parallel_for(positions.size(), [&](std::size_t v) {
      if (face_of[v] != kNoTriangle && !input_.is_within(positions[v], near_))
        moves[v] = input_.closest_point(positions[v]).position - positions[v];
    });
    for (std::uint32_t f = 0; f < faces_.size(); ++f) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t v = faces_[f][k];
        if (face_of[v] != f || moves[v] == Vec3{}) continue;
        beyond += norm(moves[v]) > tolerance_;
        Place place;
        place.at.triangle = f;
        place.at.barycentric[k] = 1;
        place.move = moves[v];
        places.push_back(place);
      }
    }
    std::fill(is_far_face_.begin(), is_far_face_.end(), std::uint8_t{0});
    for (std::size_t p = first_of_mesh; p < places.size(); ++p) is_far_face_[places[p].at.triangle] = 1;
    last_positions_ = positions;
    return places;
  }

 private:
  const SurfaceIndex& input_;
  const std::vector<Vec3>& input_points_;
  const std::vector<Triangle>& faces_;
  const double tolerance_, near_;
  const std::size_t mesh_sample_count_;
  std::vector<std::uint8_t> is_far_point_, is_far_face_;  // at the last call; a vertex is its face's
  std::vector<Vec3> last_positions_;
};

std::int32_t rounded(double value) { return static_cast<std::int32_t>(std::lround(value)); }

/// Moves the vertices that have wishes. Finer ones around them would be carried along; integers hold those where they
/// are that would go more than half a step.
void grant(const Wishes& wishes, const SubdivisionHierarchy& hierarchy, const std::vector<Vec3>& positions,
           QuantizedMesh& mesh) {
  for (auto at = wishes.begin(); at != wishes.end() && at->first < mesh.base_coordinates.size(); ++at)
    for (std::size_t k = 0; k < 3; ++k)
      mesh.base_coordinates[at->first][k] += rounded(at->second[static_cast<int>(k)] / mesh.base_step);
  for (int level = 0; level < mesh.level_count(); ++level) {
    const auto l = static_cast<std::size_t>(level);
    const LevelTopology& topology = hierarchy.level(level);
    const LevelQuantizer& quantizer = mesh.quantizers[l];
    const std::vector<Vec3> moved = reconstruct(mesh, hierarchy, level + 1);
    parallel_for(topology.edge_count, [&](std::size_t edge) {
      const std::size_t vertex = topology.vertex_count + edge;
      const Vec3 away = positions[vertex] - moved[vertex];
      if (away == Vec3{}) return;
      const Vec3 normal = odd_vertex_normal(topology, static_cast<std::uint32_t>(edge), moved.data());
      mesh.normal[l][edge] += rounded(dot(away, normal) / quantizer.normal_step);
    });
    for (auto at = wishes.lower_bound(topology.vertex_count);
         at != wishes.end() && at->first < topology.vertex_count + topology.edge_count; ++at) {
      const std::uint32_t edge = at->first - topology.vertex_count;
      const Vec3& move = at->second;
      const LocalFrame frame = odd_vertex_frame(topology, edge, moved.data());
      const double parts[3] = {dot(move, frame.normal), dot(move, frame.along), dot(move, frame.across)};
      const double steps[3] = {quantizer.normal_step, quantizer.tangential_step, quantizer.tangential_step};
      std::int32_t change[3] = {rounded(parts[0] / steps[0]), 0, 0};
      if (std::hypot(parts[1], parts[2]) > 0.5 * norm(move)) {
        change[1] = rounded(parts[1] / steps[1]);
        change[2] = rounded(parts[2] / steps[2]);
      }
      if (change[0] == 0 && change[1] == 0 && change[2] == 0) {
        // A move shorter than half a step would be made of nothing, every time.
        std::size_t longest = 0;
        for (std::size_t k = 1; k < 3; ++k)
          if (std::abs(parts[k]) > std::abs(parts[longest])) longest = k;
        change[longest] = parts[longest] < 0 ? -1 : 1;
      }
      mesh.normal[l][edge] += change[0];
      change_tangential(edge, change[1], change[2], mesh.tangential[l]);
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
  const std::size_t considered =
      hierarchy.level(finest).vertex_count + options.input_sample_count + options.mesh_sample_count;
  const std::vector<Vec3> input_points = points_of(input, options.input_sample_count);
  PlaceSearch search(input, input_points, faces, options);
  const double area = AreaSamples(input.positions(), input.triangles(), 1).total_area();
  const double sample_count = static_cast<double>(std::max<std::size_t>(options.mesh_sample_count, 20000));
  const double spacing = 0.7 * std::sqrt(area / sample_count);
  const PlaceSettling settling(input, input_points, hierarchy, faces, options.tolerance, spacing);
  QuantizedMesh best = mesh;
  int start_round = 0;  // of the best, or of the second start there
  bool starts_again = options.starts_again;
  double share = 1;
  for (; result.rounds < options.maximum_rounds; ++result.rounds) {
    std::vector<Vec3> positions = reconstruct(mesh, hierarchy, finest);
    const SurfaceIndex surface(positions, faces);
    std::size_t beyond = 0;
    std::vector<Place> places = search.find(surface, positions, result.rounds == 0, beyond);
    // What has slid into view is seen before all is called done.
    if (beyond == 0 && result.rounds > 0) places = search.find(surface, positions, true, beyond);
    if (result.rounds == 0) {
      result.initial_beyond = result.final_beyond = beyond;
    } else if (beyond < result.final_beyond) {
      result.final_beyond = beyond;
      start_round = result.rounds;
      best = mesh;
      share = 1;
    }
    if (beyond == 0) break;
    const bool has_diverged = beyond > kDiverged * result.final_beyond + kFewPlaces;
    if (has_diverged || result.rounds - start_round >= options.patience) {
      if (!starts_again) break;
      // Neighbours that push each other about may settle where only the farthest of them are moved.
      starts_again = false;
      start_round = result.rounds;
      share = kShareOfSecondStart;
      mesh = best;
      continue;
    }
    if (static_cast<double>(beyond) > options.largest_share * static_cast<double>(considered)) break;
    const bool is_settled = places.size() <= kManyPlaces;
    std::vector<Place> left = is_settled ? settling.settle(places, surface, positions, mesh) : places;
    if (share < 1) {
      std::stable_sort(left.begin(), left.end(), [](const Place& a, const Place& b) {
        return squared_norm(a.move) > squared_norm(b.move);
      });
      left.resize(static_cast<std::size_t>(std::ceil(share * static_cast<double>(left.size()))));
    }
    Wishes wishes;
    for (const Place& place : left) {
      const double part = 1 - wished_distance(result.rounds) * options.tolerance / norm(place.move);
      if (part <= 0) continue;
      wish_at(faces[place.at.triangle], place.at.barycentric, part * place.move, is_settled ? even_count : kAllVertices,
              wishes);
    }
    grant(wishes, hierarchy, positions, mesh);
  }
  mesh = std::move(best);
  return result;
}

}  // namespace nmc
