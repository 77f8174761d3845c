// SPDX-License-Identifier: Apache-2.0
#include "encoder/normal_mesh/interpolating_normal_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "encoder/core/parallel.h"
#include "encoder/normal_mesh/curve_piercing.h"
#include "encoder/normal_mesh/flip_test.h"
#include "libnmc/common/local_frame.h"

namespace nmc {

namespace {

/// A line or plane may meet the input far away in the domain; beyond this share of half the edge a vertex
/// would come close to the edge's ends.
constexpr double kLargestDeviation = 0.9;

/// More intersections than this within a few edge lengths do not occur on a surface that can be remeshed.
constexpr int kHitLimit = 64;

double aperture_at(const InterpolatingOptions& options, int level) {
  const double t = std::min(1.0, level / 4.0);
  return options.coarse_aperture + t * (options.fine_aperture - options.coarse_aperture);
}

bool ratio_is_balanced(const Vec3& x, const Vec3& a, const Vec3& b, double aperture) {
  const double r_a = distance(x, a), r_b = distance(x, b);
  return std::abs(r_a / (r_a + r_b) - 0.5) <= 0.5 * aperture;
}

/// Everything that is the same for all edges of a level.
struct Level {
  const ParameterizedSurface& map;
  const SurfaceIndex& index;
  const SubdivisionHierarchy& hierarchy;
  const LevelTopology& topology;
  int number;
  const Vec3* positions;
  std::span<const SurfaceParameter> parameters;
  const InterpolatingOptions& options;
  double aperture;
  std::vector<BaseCurve> curves;
  /// The input's points at the vertices' parameters: what the vertices of an interpolating mesh are, and what
  /// those of a variational or a quantized one stand for.
  std::vector<Vec3> anchors;

  bool on_curve(std::uint32_t edge) const { return topology.is_curve(edge); }
  /// Both halves of an edge follow it in the numbering, so the edges of a base edge are those with its number
  /// in their upper bits.
  const BaseCurve& curve_of(std::uint32_t edge) const { return curves[edge >> number]; }
};

/// Where the surface bulges between the ends, an uneven division leaves the bulge to one side of the vertex,
/// and level by level an extremity slips through between the samples. So distances are taken along the
/// surface, by way of its points at the middles of both parts, and the more these ways bend the more evenly
/// they have to divide.
bool divides_evenly(const Level& level, std::uint32_t edge, const EdgeChart& e, const ChartPoint& at,
                    const Vec3& x) {
  const Vec3& a = level.anchors[level.topology.edge_vertices[2 * edge]];
  const Vec3& b = level.anchors[level.topology.edge_vertices[2 * edge + 1]];
  const auto way = [&](const ChartPoint& end, const Vec3& from) {
    const Vec3 middle = level.map.position(level.map.locate(level.map.from_chart(e.chart, 0.5 * (end + at))));
    return distance(from, middle) + distance(middle, x);
  };
  const double way_a = way(e.a, a), way_b = way(e.b, b);
  const double bulge = (way_a + way_b) / (distance(a, x) + distance(x, b)) - 1;
  const double aperture =
      std::max(level.options.least_aperture, level.aperture / (1 + bulge / level.options.bulge_tolerance));
  return std::abs(way_a / (way_a + way_b) - 0.5) <= 0.5 * aperture;
}

/// Chooses among the intersections of the normal line with the input: Figure 2.5, steps 2 and 3.
OddVertexChoice pierce_surface(const Level& level, std::uint32_t edge, const Vec3& prediction,
                               const Vec3& normal, Vec3& position) {
  const Vec3& a = level.positions[level.topology.edge_vertices[2 * edge]];
  const Vec3& b = level.positions[level.topology.edge_vertices[2 * edge + 1]];
  OddVertexChoice choice;
  const EdgeChart e = predict_parameter(level.map, level.topology, level.number, edge, level.parameters,
                                        level.options.parameter_prediction);
  if (!e.valid) {
    choice.predicted = choice.midpoint = choice.parameter =
        level.parameters[level.topology.edge_vertices[2 * edge]];
    return choice;
  }
  choice.midpoint = level.map.from_chart(e.chart, e.midpoint);
  choice.predicted = e.predicted == e.midpoint ? choice.midpoint : level.map.from_chart(e.chart, e.predicted);
  choice.parameter = choice.predicted;
  choice.source = OddVertexSource::kPredicted;

  const bool adaptive = level.options.aperture_rule == ApertureRule::kAdaptive;
  const double limit = (adaptive ? kLargestDeviation : level.aperture) * e.half_length;
  const double reach = level.options.reach_in_edges * distance(a, b);
  thread_local std::vector<SurfacePoint> hits;
  level.index.all_hits(prediction, normal, -reach, reach, kHitLimit, hits);
  double nearest = limit * limit;
  for (const SurfacePoint& hit : hits) {
    const SurfaceLocation location{hit.triangle,
                                   {hit.barycentric[0], hit.barycentric[1], hit.barycentric[2]}};
    ChartPoint at;
    if (!level.map.to_chart(e.chart, location, at)) continue;
    const double deviation = squared_length(at - e.predicted);
    if (deviation > nearest || squared_length(at - e.midpoint) > e.half_length * e.half_length) continue;
    if (dot(level.map.face_normal(hit.triangle), normal) <= level.options.least_normal_agreement) continue;
    if (adaptive && !divides_evenly(level, edge, e, at, hit.position)) continue;
    nearest = deviation;
    choice.source = OddVertexSource::kPierced;
    choice.parameter = level.map.from_chart(e.chart, at);
    position = prediction + hit.t * normal;
  }
  return choice;
}

OddVertexChoice pierce_curve(const Level& level, std::uint32_t edge, const Vec3& prediction,
                             const LocalFrame& frame, Vec3& position) {
  const std::uint32_t a = level.topology.edge_vertices[2 * edge],
                      b = level.topology.edge_vertices[2 * edge + 1];
  const BaseCurve& curve = level.curve_of(edge);
  const double low = curve.share(level.map, level.parameters[a]),
               high = curve.share(level.map, level.parameters[b]);
  OddVertexChoice choice;
  choice.midpoint = choice.predicted = choice.parameter = curve.parameter(level.map, 0.5 * (low + high));
  choice.source = OddVertexSource::kMidpoint;
  const bool adaptive = level.options.aperture_rule == ApertureRule::kAdaptive;
  const double limit = (adaptive ? kLargestDeviation : level.aperture) * 0.5 * (high - low);
  const auto crossing =
      curve.cross_plane(prediction, frame.along, low, high, [&](const BaseCurve::Crossing& c) {
        if (std::abs(c.share - 0.5 * (low + high)) > limit) return false;
        return !adaptive ||
               ratio_is_balanced(c.position, curve.point(low), curve.point(high), level.aperture);
      });
  if (!crossing.found) return choice;
  choice.source = OddVertexSource::kPierced;
  choice.parameter = curve.parameter(level.map, crossing.share);
  position = crossing.position;
  return choice;
}

}  // namespace

LevelInsertion insert_level(const ParameterizedSurface& map, const SurfaceIndex& index,
                            const SubdivisionHierarchy& hierarchy, int level_number,
                            std::span<const Vec3> positions, std::span<const SurfaceParameter> parameters,
                            const InterpolatingOptions& options) {
  const LevelTopology& topology = hierarchy.level(level_number);
  Level level{map,
              index,
              hierarchy,
              topology,
              level_number,
              positions.data(),
              parameters,
              options,
              aperture_at(options, level_number),
              base_curves(map, hierarchy.level(0)),
              {}};
  if (options.aperture_rule == ApertureRule::kAdaptive) {
    level.anchors.resize(topology.vertex_count);
    parallel_for(topology.vertex_count,
                 [&](std::size_t v) { level.anchors[v] = map.position(map.locate(parameters[v])); });
  }
  const std::size_t edge_count = topology.edge_count;
  LevelInsertion result;
  result.positions.resize(edge_count);
  result.parameters.resize(edge_count);
  result.details.resize(edge_count);
  result.non_normal.assign(edge_count, 0);
  std::vector<OddVertexChoice> choices(edge_count);
  std::vector<Vec3> predictions(edge_count);
  parallel_for(edge_count, [&](std::size_t i) {
    const auto edge = static_cast<std::uint32_t>(i);
    predictions[i] = predict_odd_vertex(topology, hierarchy.ring_weights(), edge, Tension{options.tension},
                                        positions.data());
    if (level.on_curve(edge)) {
      const LocalFrame frame = odd_vertex_frame(topology, edge, positions.data());
      choices[i] = pierce_curve(level, edge, predictions[i], frame, result.positions[i]);
    } else {
      const Vec3 normal = odd_vertex_normal(topology, edge, positions.data());
      choices[i] = pierce_surface(level, edge, predictions[i], normal, result.positions[i]);
    }
  });

  LevelStatistics& statistics = result.statistics;
  statistics.vertex_count = topology.edge_count;
  for (const OddVertexChoice& choice : choices)
    statistics.missed_count += choice.source != OddVertexSource::kPierced;
  const FlipTestResult flips =
      resolve_flips(map, topology, level_number, parameters, options.least_child_area, choices);
  statistics.flip_count = flips.demoted_count;
  statistics.folded_face_count = flips.folded_face_count;
  statistics.non_normal_count = statistics.missed_count + statistics.flip_count;

  parallel_for(edge_count, [&](std::size_t i) {
    const auto edge = static_cast<std::uint32_t>(i);
    const OddVertexChoice& choice = choices[i];
    result.parameters[i] = choice.parameter;
    const bool on_curve = level.on_curve(edge);
    if (choice.source != OddVertexSource::kPierced) {
      result.non_normal[i] = 1;
      if (on_curve) {
        const BaseCurve& curve = level.curve_of(edge);
        result.positions[i] = curve.point(curve.share(map, choice.parameter));
      } else {
        result.positions[i] = map.position(map.locate(choice.parameter));
      }
    }
    const Vec3 offset = result.positions[i] - predictions[i];
    if (!on_curve && !result.non_normal[i]) {
      result.details[i].normal = dot(offset, odd_vertex_normal(topology, edge, positions.data()));
      return;
    }
    const LocalFrame frame = odd_vertex_frame(topology, edge, positions.data());
    result.details[i] = {dot(offset, frame.normal), dot(offset, frame.across),
                         result.non_normal[i] ? dot(offset, frame.along) : 0.0};
  });
  return result;
}

double InterpolatingResult::non_normal_share() const {
  std::uint64_t non_normal = 0, all = 0;
  for (const LevelStatistics& level : levels) {
    non_normal += level.non_normal_count;
    all += level.vertex_count;
  }
  return all > 0 ? static_cast<double>(non_normal) / static_cast<double>(all) : 0;
}

InterpolatingResult interpolate(const ParameterizedSurface& map, const SurfaceIndex& index,
                                const ParameterizedBase& base, const InterpolatingOptions& options) {
  InterpolatingResult result;
  NormalMesh& mesh = result.mesh;
  mesh.base_positions = base.positions;
  mesh.hierarchy = SubdivisionHierarchy(base.faces, static_cast<std::uint32_t>(base.positions.size()),
                                        options.level_count, base.creases);
  mesh.tension.assign(static_cast<std::size_t>(options.level_count), options.tension);
  mesh.details.resize(static_cast<std::size_t>(options.level_count));
  mesh.non_normal.resize(static_cast<std::size_t>(options.level_count));
  result.positions = base.positions;
  result.parameters = base.parameters;
  for (int l = 0; l < options.level_count; ++l) {
    LevelInsertion insertion =
        insert_level(map, index, mesh.hierarchy, l, result.positions, result.parameters, options);
    mesh.details[static_cast<std::size_t>(l)] = std::move(insertion.details);
    mesh.non_normal[static_cast<std::size_t>(l)] = std::move(insertion.non_normal);
    reconstruct_level(mesh, l, result.positions);
    result.parameters.insert(result.parameters.end(), insertion.parameters.begin(),
                             insertion.parameters.end());
    result.levels.push_back(insertion.statistics);
  }
  return result;
}

}  // namespace nmc
