// SPDX-License-Identifier: Apache-2.0
#include "encoder/condition/condition_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>

namespace nmc {

namespace {

using Json = nlohmann::ordered_json;

Json to_json(const Vec3& p) { return Json::array({p.x, p.y, p.z}); }

Json to_json(const ConditionedComponent& component) {
  Json json;
  json["triangles"] = component.triangle_count;
  json["vertices"] = component.vertex_count;
  json["area"] = component.area;
  json["closed"] = component.is_closed();
  if (component.is_closed()) json["volume"] = component.volume;
  json["genus"] = component.genus;
  json["boundaryLoops"] = component.boundary_loop_count;
  json["turnedInsideOut"] = component.turned_inside_out;
  json["bbox"] = {{"min", to_json(component.box.minimum)}, {"max", to_json(component.box.maximum)}};
  return json;
}

/// Indices of the `limit` items with the largest size, largest first; equal ones in their order.
template <class Size>
std::vector<std::size_t> largest(std::size_t count, std::size_t limit, const Size& size) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return size(a) > size(b); });
  if (order.size() > limit) order.resize(limit);
  return order;
}

/// "1 component", "3 components".
std::string counted(std::size_t count, const char* noun, const char* plural = nullptr) {
  if (count == 1) return fmt::format("1 {}", noun);
  return plural != nullptr ? fmt::format("{} {}", count, plural) : fmt::format("{} {}s", count, noun);
}

}  // namespace

bool is_dropped(TriangleFate fate) { return fate >= TriangleFate::kNonFinite; }

std::size_t ConditionReport::dropped_triangles() const {
  std::size_t sum = 0;
  for (int fate = 0; fate < kTriangleFateCount; ++fate)
    if (is_dropped(static_cast<TriangleFate>(fate))) sum += triangles_by_fate[fate];
  return sum;
}

long ConditionReport::total_genus() const {
  return std::accumulate(components.begin(), components.end(), 0L,
                         [](long sum, const ConditionedComponent& c) { return sum + c.genus; });
}

bool ConditionReport::needed_repair() const {
  return count(TriangleFate::kKept) != input_triangles ||
         non_finite_vertices + welded_nearby + split_vertices > 0 ||
         slivers_left + t_junctions_closed + non_manifold_edges + cut_edges > 0 ||
         turned_components + filled_holes + dust_components > 0;
}

std::string to_json(const ConditionReport& report, std::size_t component_limit) {
  Json json;
  json["input"] = {{"vertices", report.input_vertices}, {"triangles", report.input_triangles}};
  Json& repairs = json["repairs"];
  repairs["needed"] = report.needed_repair();
  repairs["keptTriangles"] = report.count(TriangleFate::kKept);
  repairs["reorientedTriangles"] = report.count(TriangleFate::kReoriented);
  repairs["splitTriangles"] = report.count(TriangleFate::kSplit);
  repairs["reshapedTriangles"] = report.count(TriangleFate::kReshaped);
  repairs["nonFiniteTriangles"] = report.count(TriangleFate::kNonFinite);
  repairs["outOfRangeTriangles"] = report.count(TriangleFate::kOutOfRange);
  repairs["degenerateTriangles"] = report.count(TriangleFate::kDegenerate);
  repairs["duplicateTriangles"] = report.count(TriangleFate::kDuplicate);
  repairs["oppositeDuplicateTriangles"] = report.count(TriangleFate::kOppositeDuplicate);
  repairs["sliverTriangles"] = report.count(TriangleFate::kSliver);
  repairs["dustTriangles"] = report.count(TriangleFate::kDust);
  repairs["droppedTriangles"] = report.dropped_triangles();
  repairs["nonFiniteVertices"] = report.non_finite_vertices;
  repairs["unreferencedVertices"] = report.unreferenced_vertices;
  repairs["weldedExactly"] = report.welded_exactly;
  repairs["weldedNearby"] = report.welded_nearby;
  repairs["weldDistance"] = report.weld_distance;
  repairs["splitVertices"] = report.split_vertices;
  repairs["needlesCollapsed"] = report.needles_collapsed;
  repairs["capsFlipped"] = report.caps_flipped;
  repairs["capsRemoved"] = report.caps_removed;
  repairs["sliversLeft"] = report.slivers_left;
  repairs["tJunctionsClosed"] = report.t_junctions_closed;
  repairs["nonManifoldEdges"] = report.non_manifold_edges;
  repairs["nonManifoldEdgesOpen"] = report.non_manifold_edges_open;
  repairs["nonManifoldVertices"] = report.non_manifold_vertices;
  repairs["cutEdges"] = report.cut_edges;
  repairs["nonOrientableComponents"] = report.non_orientable_components;
  repairs["turnedComponents"] = report.turned_components;
  repairs["filledHoles"] = report.filled_holes;
  repairs["filledHoleTriangles"] = report.filled_hole_triangles;
  repairs["filledHoleArea"] = report.filled_hole_area;
  repairs["dustComponents"] = report.dust_components;
  repairs["firstCases"] = report.first_cases;

  Json& output = json["output"];
  output["vertices"] = report.output_vertices;
  output["triangles"] = report.output_triangles;
  output["diagonal"] = report.diagonal;
  output["components"] = report.components.size();
  output["genus"] = report.total_genus();
  output["boundaryLoops"] = report.boundary_loops.size();
  Json& components = output["largestComponents"] = Json::array();
  for (const std::size_t c : largest(report.components.size(), component_limit,
                                     [&](std::size_t i) { return report.components[i].area; }))
    components.push_back(to_json(report.components[c]));
  Json& loops = output["longestBoundaryLoops"] = Json::array();
  for (const std::size_t i : largest(report.boundary_loops.size(), component_limit,
                                     [&](std::size_t l) { return report.boundary_loops[l].length; }))
    loops.push_back(
        {{"edges", report.boundary_loops[i].edge_count}, {"length", report.boundary_loops[i].length}});
  return json.dump();
}

std::string to_text(const ConditionReport& report) {
  std::string text = fmt::format("input: {}, {}\n", counted(report.input_vertices, "vertex", "vertices"),
                                 counted(report.input_triangles, "triangle"));
  const auto line = [&](std::size_t count, const char* noun, const std::string& what) {
    if (count > 0) text += fmt::format("  {:>9} {}{} {}\n", count, noun, count == 1 ? "" : "s", what);
  };
  const auto vertex_line = [&](std::size_t count, const std::string& what) {
    if (count > 0) text += fmt::format("  {:>9} {} {}\n", count, count == 1 ? "vertex" : "vertices", what);
  };
  const char* triangle = "triangle";
  line(report.count(TriangleFate::kOutOfRange), triangle, "dropped: names a vertex that does not exist");
  line(report.count(TriangleFate::kNonFinite), triangle, "dropped: a corner is not finite");
  line(report.count(TriangleFate::kDegenerate), triangle, "dropped: two corners are the same point");
  line(report.count(TriangleFate::kDuplicate), triangle, "dropped: stored twice");
  line(report.count(TriangleFate::kOppositeDuplicate), triangle, "dropped: stored twice, front and back");
  line(report.count(TriangleFate::kSliver), triangle, "without area dropped, the neighbours closed up");
  line(report.count(TriangleFate::kDust), triangle,
       fmt::format("dropped as dust ({})", counted(report.dust_components, "component")));
  line(report.caps_flipped, triangle, "without area removed by flipping an edge");
  line(report.slivers_left, triangle,
       "without area left: nothing could be done without changing the surface");
  line(report.count(TriangleFate::kReoriented), triangle, "turned around");
  line(report.turned_components, "component", "turned as a whole: inside out");
  vertex_line(report.unreferenced_vertices, "left out: in no triangle");
  vertex_line(report.non_finite_vertices, "left out: not finite");
  vertex_line(report.welded_exactly, "welded: at the position of another");
  vertex_line(report.welded_nearby, fmt::format("welded: within {:.3g} of another", report.weld_distance));
  line(report.t_junctions_closed, "T-junction", "closed");
  line(report.non_manifold_edges, "edge",
       fmt::format("with more than two triangles taken apart, {} left open", report.non_manifold_edges_open));
  vertex_line(report.non_manifold_vertices, "joining several sheets taken apart");
  line(report.cut_edges, "edge",
       fmt::format("opened: {} cannot be oriented", counted(report.non_orientable_components, "component")));
  line(report.filled_holes, "small hole",
       fmt::format("filled with {}", counted(report.filled_hole_triangles, "triangle")));
  std::size_t closed = 0;
  for (const ConditionedComponent& component : report.components) closed += component.is_closed();
  text += fmt::format("surface: {}, {}, {} ({} closed), genus {}, {}\n",
                      counted(report.output_vertices, "vertex", "vertices"),
                      counted(report.output_triangles, "triangle"),
                      counted(report.components.size(), "component"), closed, report.total_genus(),
                      counted(report.boundary_loops.size(), "boundary loop"));
  constexpr std::size_t kCasesShown = 3;
  for (std::size_t i = 0; i < std::min(kCasesShown, report.first_cases.size()); ++i)
    text += fmt::format("  first case: {}\n", report.first_cases[i]);
  return text;
}

}  // namespace nmc
