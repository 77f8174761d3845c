// SPDX-License-Identifier: Apache-2.0
#include "encoder/condition/condition.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include "encoder/condition/degenerate.h"
#include "encoder/condition/half_edges.h"
#include "encoder/condition/outward.h"
#include "encoder/condition/pair_edges.h"
#include "encoder/condition/pieces.h"
#include "encoder/condition/slivers.h"
#include "encoder/condition/small_holes.h"
#include "encoder/condition/split_vertices.h"
#include "encoder/condition/t_junctions.h"
#include "encoder/condition/weld.h"
#include "encoder/condition/working_mesh.h"
#include "encoder/core/error.h"

namespace nmc {

namespace {

using conditioning::Defect;
using conditioning::EdgeGroups;
using conditioning::GroupedHalfEdge;
using conditioning::head_of;
using conditioning::kNone;
using conditioning::tail_of;
using conditioning::WorkingMesh;

constexpr std::size_t kMaximumTriangles = std::size_t{1} << 30;  // half-edge numbers are 32 bits
constexpr double kSmallestExtent = 1e-60,
                 kLargestExtent = 1e60;  // fourth powers of lengths stay finite and normal
constexpr int kMaximumWeldRounds = 8, kMaximumSeparations = 4;

[[noreturn]] void refuse(const std::string& reason) { throw Error(ExitCode::kInvalidInput, reason); }

/// One run of condition(): the state that its steps share.
class Conditioner {
 public:
  Conditioner(const TriangleMesh& input, const ConditionOptions& options, const Progress& progress)
      : input_(input), options_(options), progress_(progress), mesh_(out_.fate, out_.report) {}

  ConditionedMesh run() {
    if (input_.triangle_count() >= kMaximumTriangles)
      throw Error(ExitCode::kLimit, fmt::format("{} triangles; at most {} can be conditioned",
                                                input_.triangle_count(), kMaximumTriangles - 1));
    out_.report.input_vertices = input_.vertex_count();
    out_.report.input_triangles = input_.triangle_count();
    if (input_.triangle_count() == 0)
      refuse(input_.vertex_count() == 0
                 ? "the mesh is empty: it has no vertices and no triangles"
                 : fmt::format("the mesh has {} vertices but no triangles", input_.vertex_count()));
    step("reading triangles", 0);
    take_usable_triangles();
    center();
    if (options_.repair == Repair::kNothing)
      accept_manifold_only();
    else
      repair();
    step("describing", 0.85);
    write_output();
    if (options_.repair == Repair::kStrict && out_.report.needed_repair()) refuse_repair();
    step("describing", 1);
    return std::move(out_);
  }

 private:
  void step(const char* what, double fraction) const { nmc::report(progress_, what, fraction); }

  void take_usable_triangles() {
    ConditionReport& report = out_.report;
    out_.fate.assign(input_.triangle_count(), TriangleFate::kKept);
    const auto is_usable = [&](std::uint32_t v) { return is_finite(input_.positions[v]); };
    for (std::size_t v = 0; v < input_.vertex_count(); ++v)
      if (!is_finite(input_.positions[v])) {
        ++report.non_finite_vertices;
        mesh_.note(Defect::kNonFinite, [&] { return fmt::format("vertex {} is not finite", v); });
      }
    std::size_t out_of_range = 0;
    mesh_.stored.reserve(input_.triangle_count());
    mesh_.source.reserve(input_.triangle_count());
    for (std::uint32_t t = 0; t < input_.triangle_count(); ++t) {
      const Triangle& corners = input_.triangles[t];
      const auto bad = std::find_if(corners.begin(), corners.end(),
                                    [&](std::uint32_t v) { return v >= input_.vertex_count(); });
      if (bad != corners.end()) {
        ++out_of_range;
        mesh_.note(Defect::kOutOfRange, [&] {
          return fmt::format("triangle {} names vertex {} of {}", t, *bad, input_.vertex_count());
        });
        out_.fate[t] = TriangleFate::kOutOfRange;
      } else if (!std::all_of(corners.begin(), corners.end(), is_usable)) {
        out_.fate[t] = TriangleFate::kNonFinite;
      } else {
        mesh_.stored.push_back(corners);
        mesh_.source.push_back(t);
      }
    }
    mesh_.triangles = mesh_.stored;
    mesh_.is_turned.assign(mesh_.stored.size(), 0);
    if (mesh_.triangles.empty())
      refuse(fmt::format(
          "no usable triangle: {} of {} have a corner that is not finite, {} name a vertex that does "
          "not exist",
          input_.triangle_count() - out_of_range, input_.triangle_count(), out_of_range));
  }

  void center() {
    used_.assign(input_.vertex_count(), 0);
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    BoundingBox box{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
    bool all_float = true;
    double largest = 0;
    for (const Triangle& t : mesh_.triangles)
      for (const std::uint32_t v : t) {
        if (used_[v]) continue;
        used_[v] = 1;
        const Vec3& p = input_.positions[v];
        for (int k = 0; k < 3; ++k) {
          box.minimum[k] = std::min(box.minimum[k], p[k]);
          box.maximum[k] = std::max(box.maximum[k], p[k]);
          largest = std::max(largest, std::abs(p[k]));
          // The 29 bits that a double has and a float has not.
          all_float = all_float && (std::bit_cast<std::uint64_t>(p[k]) & 0x1fffffffu) == 0;
        }
      }
    const double extent = std::max(
        {box.maximum.x - box.minimum.x, box.maximum.y - box.minimum.y, box.maximum.z - box.minimum.z});
    if (largest > kLargestExtent)
      refuse(fmt::format("a coordinate of {:g} is beyond the largest one that can be measured, {:g}", largest,
                         kLargestExtent));
    if (extent == 0) refuse("all points are the same: no triangle has an area");
    if (extent < kSmallestExtent)
      refuse(fmt::format("an extent of {:g} is below the smallest one that can be measured, {:g}", extent,
                         kSmallestExtent));
    const Vec3 center = box.center();
    mesh_.positions.resize(input_.vertex_count());
    for (std::size_t v = 0; v < input_.vertex_count(); ++v)
      if (used_[v]) mesh_.positions[v] = input_.positions[v] - center;
    out_.report.diagonal = box.diagonal();
    weld_radius_ = options_.weld_fraction * box.diagonal();
    // Rounding to 32 bits far from the origin moves a point by up to half a unit in the last place, 2^-24 of
    // it.
    if (weld_radius_ > 0 && all_float) weld_radius_ = std::max(weld_radius_, largest * 0x1p-22);
  }

  // -------------------------------------------------------------------------------------- kNothing

  void accept_manifold_only() {
    conditioning::drop_degenerate(mesh_);
    refuse_without_area();
    std::vector<std::uint32_t> opposite(3 * mesh_.triangles.size(), kNone);
    const auto name = [&](const GroupedHalfEdge& entry) { return mesh_.source[entry.half_edge() / 3]; };
    EdgeGroups(mesh_.triangles, mesh_.positions.size()).for_each([&](std::span<const GroupedHalfEdge> group) {
      const std::uint32_t h = group[0].half_edge();
      const std::uint32_t a = tail_of(mesh_.triangles, h), b = head_of(mesh_.triangles, h);
      if (group.size() > 2)
        refuse(fmt::format(
            "not a manifold: the edge between vertices {} and {} has {} triangles, among them {}, {} "
            "and {}; --repair auto would separate them",
            std::min(a, b), std::max(a, b), group.size(), name(group[0]), name(group[1]), name(group[2])));
      if (group.size() < 2) return;
      const std::uint32_t other = group[1].half_edge();
      if (conditioning::apex_of(mesh_.triangles, h) == conditioning::apex_of(mesh_.triangles, other))
        refuse(fmt::format(
            "not a manifold: triangles {} and {} have the same corners; --repair auto would drop one",
            name(group[0]), name(group[1])));
      if (tail_of(mesh_.triangles, other) == a)
        refuse(fmt::format(
            "not oriented: triangles {} and {} run the same way along the edge between vertices {} and "
            "{}; --repair auto would turn one",
            name(group[0]), name(group[1]), a, b));
      opposite[h] = other;
      opposite[other] = h;
    });
    const conditioning::SplitVertices split = conditioning::split_vertices(mesh_, opposite, false);
    if (split.source.size() > input_.vertex_count())
      refuse(
          fmt::format("not a manifold: vertex {} joins several sheets of the surface; --repair auto would "
                      "separate them",
                      split.source[input_.vertex_count()]));
    source_ = split.source;
    welded_ = split.welded;
  }

  // -------------------------------------------------------------------------------------- kAuto, kStrict

  void repair() {
    step("welding", 0.05);
    equal_ = conditioning::equal_vertices(input_.positions, used_);
    for (Triangle& t : mesh_.triangles)
      for (std::uint32_t& v : t) v = equal_[v];
    conditioning::drop_degenerate(mesh_);
    refuse_without_area();
    EdgeGroups edges(mesh_.triangles, mesh_.positions.size());
    const auto group_again = [&] { edges = EdgeGroups(mesh_.triangles, mesh_.positions.size()); };
    drop_duplicates(edges, group_again);
    weld_nearby(edges, group_again);
    step("closing cracks", 0.3);
    if (options_.close_t_junctions &&
        conditioning::close_t_junctions(mesh_, edges, out_.report.weld_distance) > 0) {
      conditioning::drop_degenerate(mesh_);
      group_again();
      drop_duplicates(edges, group_again);
    }
    std::vector<std::uint32_t> opposite;
    std::vector<std::uint8_t> is_seam;
    for (int round = 0;; ++round) {
      step("pairing edges", 0.4);
      separate_sheets(edges, round == 0, opposite, is_seam);
      edges = EdgeGroups({}, 0);  // half of the memory in use
      step("removing slivers", 0.6);
      if (conditioning::remove_slivers(mesh_, opposite, is_seam) == 0) break;
      // A sliver may have been what kept two sheets apart or together.
      if (std::find(is_seam.begin(), is_seam.end(), 1) == is_seam.end() || round == kMaximumSeparations)
        break;
      mesh_.stored = mesh_.triangles;
      for (Triangle& t : mesh_.triangles)
        for (std::uint32_t& v : t) v = welded_[v];
      group_again();
      drop_duplicates(edges, group_again);
    }
    if (options_.repair == Repair::kAuto) conditioning::fill_small_holes(mesh_, opposite, is_seam, options_);
    treat_dust(opposite);
    step("orienting", 0.75);
    if (options_.turn_outward) turned_ = conditioning::turn_outward(mesh_, opposite);
  }

  /// Pairs half-edges and splits vertices. A later round starts from the vertices that the last one made.
  void separate_sheets(const EdgeGroups& edges, bool is_first_round, std::vector<std::uint32_t>& opposite,
                       std::vector<std::uint8_t>& is_seam) {
    conditioning::PairedEdges paired = conditioning::pair_edges(mesh_, edges);
    if (is_first_round) {
      out_.report.non_manifold_edges = paired.crowded_edges;
      out_.report.non_manifold_edges_open = paired.crowded_edges_open;
      out_.report.cut_edges = paired.cut_edges;
      out_.report.non_orientable_components = paired.non_orientable_pieces;
    }
    opposite = std::move(paired.pairs);
    conditioning::SplitVertices split =
        conditioning::split_vertices(mesh_, opposite, paired.crowded_edges + paired.cut_edges > 0);
    if (!is_first_round)
      for (std::uint32_t& source : split.source) source = source_[source];
    source_ = std::move(split.source);
    welded_ = std::move(split.welded);
    is_seam = std::move(split.is_seam);
  }

  template <class GroupAgain>
  void weld_nearby(EdgeGroups& edges, const GroupAgain& group_again) {
    // A weld can lengthen the shortest edges and with them the safe distance; until it does not, so that
    // conditioning the result again welds nothing.
    for (int round = 0; round < kMaximumWeldRounds; ++round) {
      double radius = conditioning::limited_weld_radius(mesh_, edges, weld_radius_);
      if (radius < 1e-15 * out_.report.diagonal) radius = 0;  // below what double precision can tell apart
      out_.report.weld_distance = std::max(out_.report.weld_distance, radius);
      const std::vector<std::uint32_t> target = conditioning::weld_nearby(mesh_, edges, radius);
      if (target.empty()) return;
      nearby_.resize(input_.vertex_count(), 0);
      for (std::uint32_t v = 0; v < target.size(); ++v) {
        if (target[v] == v || nearby_[v]) continue;
        mesh_.note(Defect::kNearbyVertices, [&] {
          return fmt::format("vertices {} and {} are {:g} apart", target[v], v,
                             distance(mesh_.positions[target[v]], mesh_.positions[v]));
        });
        nearby_[v] = 1;
      }
      conditioning::drop_degenerate(mesh_);
      group_again();
      drop_duplicates(edges, group_again);
    }
  }

  /// A triangle dropped from a closed surface opens it, and then its other duplicates are not kept either.
  template <class GroupAgain>
  void drop_duplicates(EdgeGroups& edges, const GroupAgain& group_again) {
    while (conditioning::drop_duplicates(mesh_, edges) > 0) group_again();
  }

  void treat_dust(std::vector<std::uint32_t>& opposite) {
    if (!options_.drop_dust) return;
    const conditioning::Pieces pieces = conditioning::find_pieces(mesh_, opposite);
    double whole_area = 0;
    for (const conditioning::Piece& piece : pieces.list) whole_area += piece.area;
    std::vector<std::uint8_t> is_dust(pieces.list.size());
    for (std::size_t p = 0; p < pieces.list.size(); ++p) {
      is_dust[p] = pieces.list[p].box.diagonal() < options_.dust_diagonal_fraction * out_.report.diagonal &&
                   pieces.list[p].area < options_.dust_area_fraction * whole_area;
      out_.report.dust_components += is_dust[p];
    }
    // A cloud of dust and nothing else is what the user has; it stays.
    if (out_.report.dust_components == pieces.list.size()) out_.report.dust_components = 0;
    if (out_.report.dust_components == 0) return;
    std::vector<std::uint32_t> renamed(mesh_.triangles.size());
    std::uint32_t kept = 0;
    for (std::size_t t = 0; t < renamed.size(); ++t)
      renamed[t] = is_dust[pieces.of_triangle[t]] ? kNone : kept++;
    for (std::size_t h = 0; h < opposite.size(); ++h) {
      if (renamed[h / 3] == kNone) continue;
      // A partner is in the same component and so is kept too; renamed[h / 3] <= h / 3 was read before.
      opposite[3 * renamed[h / 3] + h % 3] =
          opposite[h] == kNone ? kNone : 3 * renamed[opposite[h] / 3] + opposite[h] % 3;
    }
    opposite.resize(3 * kept);
    mesh_.drop([&](std::size_t t) {
      return is_dust[pieces.of_triangle[t]] ? TriangleFate::kDust : TriangleFate::kKept;
    });
  }

  void refuse_without_area() const {
    double area = 0;
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) area += 0.5 * norm(mesh_.area_normal(t));
    if (area > 1e-12 * out_.report.diagonal * out_.report.diagonal) return;
    refuse(mesh_.triangles.empty() ? "no triangle is left: every one has two corners at the same point"
                                   : fmt::format("the {} triangles have no area: their points lie on a line",
                                                 mesh_.triangles.size()));
  }

  // -------------------------------------------------------------------------------------- output

  void write_output() {
    std::vector<std::uint32_t> renamed(mesh_.positions.size(), kNone);
    for (const Triangle& t : mesh_.triangles)
      for (const std::uint32_t v : t) renamed[v] = 0;
    for (std::uint32_t v = 0; v < renamed.size(); ++v) {
      if (renamed[v] == kNone) continue;
      renamed[v] = static_cast<std::uint32_t>(out_.source_vertex.size());
      out_.source_vertex.push_back(source_[v]);
      out_.stitched_vertex.push_back(welded_[v]);
    }
    stitch();
    TriangleMesh& mesh = out_.mesh;
    mesh.dropped_properties = input_.dropped_properties;
    mesh.triangles = std::move(mesh_.triangles);
    for (Triangle& t : mesh.triangles)
      for (std::uint32_t& v : t) v = renamed[v];
    out_.source_triangle = std::move(mesh_.source);
    mesh_.positions = {};
    mesh.positions.reserve(out_.source_vertex.size());
    for (const std::uint32_t v : out_.source_vertex) mesh.positions.push_back(input_.positions[v]);
    if (!input_.colors.empty())
      for (const std::uint32_t v : out_.source_vertex) mesh.colors.push_back(input_.colors[v]);
    for (const VertexAttribute& attribute : input_.attributes) {
      const auto width = static_cast<std::size_t>(attribute.component_count);
      VertexAttribute copy{attribute.name, attribute.component_count, {}};
      copy.values.reserve(width * out_.source_vertex.size());
      for (const std::uint32_t v : out_.source_vertex) {
        const auto first = attribute.values.begin() + static_cast<std::ptrdiff_t>(width * v);
        copy.values.insert(copy.values.end(), first, first + static_cast<std::ptrdiff_t>(width));
      }
      mesh.attributes.push_back(std::move(copy));
    }
    count_vertices();
    count_triangles();
    describe();
  }

  /// Turns welded names into the lowest output vertex with that name.
  void stitch() {
    std::vector<std::uint32_t> first(welded_.size(), kNone);
    for (std::uint32_t v = 0; v < out_.stitched_vertex.size(); ++v) {
      std::uint32_t& lowest = first[out_.stitched_vertex[v]];
      if (lowest == kNone) lowest = v;
      out_.stitched_vertex[v] = lowest;
    }
  }

  void count_vertices() {
    ConditionReport& report = out_.report;
    std::vector<std::uint8_t> is_output(input_.vertex_count(), 0);  // 2: more than once
    for (const std::uint32_t v : out_.source_vertex) {
      report.split_vertices += is_output[v] > 0;
      report.non_manifold_vertices += is_output[v] == 1;
      if (is_output[v] < 2) ++is_output[v];
    }
    for (std::size_t v = 0; v < input_.vertex_count(); ++v) {
      if (is_output[v] || !is_finite(input_.positions[v])) continue;
      if (used_[v] && !equal_.empty() && equal_[v] != v)
        ++report.welded_exactly;
      else if (used_[v] && !nearby_.empty() && nearby_[v])
        ++report.welded_nearby;
      else
        ++report.unreferenced_vertices;
    }
  }

  /// Counts every input triangle once. What a step noted while working is only provisional: a triangle split
  /// into parts may have lost one part as a sliver, and one turned twice is as it was.
  void count_triangles() {
    for (std::size_t t = 0; t < out_.source_triangle.size(); ++t) {
      const std::uint32_t source = out_.source_triangle[t];
      if (source == kFilledHole) continue;
      TriangleFate& fate = out_.fate[source];
      if (fate == TriangleFate::kKept) {
        if (mesh_.is_turned[t]) fate = TriangleFate::kReoriented;
      } else if (is_dropped(fate)) {
        fate = TriangleFate::kSplit;
      }
    }
    std::fill(std::begin(out_.report.triangles_by_fate), std::end(out_.report.triangles_by_fate), 0u);
    for (const TriangleFate fate : out_.fate) ++out_.report.triangles_by_fate[static_cast<int>(fate)];
  }

  void describe() {
    ConditionReport& report = out_.report;
    Topology topology = analyze_topology(out_.mesh);
    if (!topology.is_oriented_manifold())
      throw Error(
          ExitCode::kInternal,
          fmt::format(
              "conditioning left {} non-manifold edges, {} non-manifold vertices and {} edges without "
              "orientation",
              topology.non_manifold_edge_count, topology.non_manifold_vertex_count,
              topology.misoriented_edge_count));
    report.output_vertices = out_.mesh.vertex_count();
    report.output_triangles = out_.mesh.triangle_count();
    report.components.reserve(topology.components.size());
    for (std::size_t c = 0; c < topology.components.size(); ++c)
      report.components.push_back({topology.components[c], c < turned_.size() && turned_[c] != 0});
    report.boundary_loops = std::move(topology.boundary_loops);
    out_.component_of_triangle = std::move(topology.component_of_triangle);
  }

  [[noreturn]] void refuse_repair() const {
    std::string reasons;
    for (const std::string& first : out_.report.first_cases) reasons += (reasons.empty() ? "" : "; ") + first;
    refuse(fmt::format("the mesh needs repair: {}; --repair auto would do it", reasons));
  }

  const TriangleMesh& input_;
  const ConditionOptions& options_;
  const Progress& progress_;
  ConditionedMesh out_;
  WorkingMesh mesh_;
  double weld_radius_ = 0;
  std::vector<std::uint8_t> used_;              // input vertices that a usable triangle names
  std::vector<std::uint32_t> equal_;            // as equal_vertices()
  std::vector<std::uint8_t> nearby_;            // input vertices that weld_nearby() merged into others
  std::vector<std::uint32_t> source_, welded_;  // as SplitVertices
  std::vector<std::uint8_t> turned_;            // by component
};

}  // namespace

ConditionedMesh condition(const TriangleMesh& input, const ConditionOptions& options,
                          const Progress& progress) {
  return Conditioner(input, options, progress).run();
}

}  // namespace nmc
