// SPDX-License-Identifier: Apache-2.0
#include "encoder/normal_mesh/semi_regular_input.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "encoder/core/error.h"

namespace nmc {

namespace {

using VertexPair = std::pair<std::uint32_t, std::uint32_t>;

VertexPair ordered(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

/// What lies across each edge of each face; edge k is opposite to corner k.
class FaceNeighbors {
 public:
  /// False where an edge has more than two faces or two that disagree in orientation.
  bool build(const std::vector<Triangle>& faces) {
    struct Side {
      VertexPair edge;
      std::uint32_t slot;
    };
    std::vector<Side> sides;
    sides.reserve(3 * faces.size());
    for (std::uint32_t f = 0; f < faces.size(); ++f)
      for (std::uint32_t k = 0; k < 3; ++k)
        sides.push_back({ordered(faces[f][(k + 1) % 3], faces[f][(k + 2) % 3]), 3 * f + k});
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
      return a.edge != b.edge ? a.edge < b.edge : a.slot < b.slot;
    });
    opposite_.assign(sides.size(), kNone);
    for (std::size_t i = 0; i < sides.size();) {
      std::size_t end = i + 1;
      while (end < sides.size() && sides[end].edge == sides[i].edge) ++end;
      if (end - i > 2) return false;
      if (end - i == 2) {
        const std::uint32_t s = sides[i].slot, t = sides[i + 1].slot;
        if (faces[s / 3][(s % 3 + 1) % 3] == faces[t / 3][(t % 3 + 1) % 3]) return false;
        opposite_[s] = t;
        opposite_[t] = s;
      }
      i = end;
    }
    return true;
  }
  /// The slot 3 * face + corner on the other side, or kNone.
  std::uint32_t across(std::uint32_t slot) const { return opposite_[slot]; }

 private:
  std::vector<std::uint32_t> opposite_;
};

/// One split undone.
struct CoarserMesh {
  std::vector<Triangle> faces;              // in vertices of the finest mesh
  std::map<VertexPair, std::uint32_t> odd;  // the vertex that was inserted on each edge
};

/// Tiles one component with groups of four, starting from the guess that `middle` is the middle of one.
class Tiler {
 public:
  /// `must_be_even` holds one byte per vertex, or nothing.
  Tiler(const std::vector<Triangle>& faces, const FaceNeighbors& neighbors, std::size_t vertex_count,
        const std::vector<std::uint8_t>& must_be_even)
      : faces_(faces),
        neighbors_(neighbors),
        must_be_even_(must_be_even),
        group_(faces.size(), kNone),
        roles_(vertex_count, Role::kUnknown) {}

  bool is_tiled(std::uint32_t face) const { return group_[face] != kNone; }

  /// Appends the component's coarse faces; undone where the guess fails.
  bool tile_component(std::uint32_t middle, CoarserMesh& coarser) {
    std::vector<std::uint32_t> middles;
    if (!claim(middle, middles)) {
      release(middles);
      return false;
    }
    for (std::size_t i = 0; i < middles.size(); ++i) {
      for (std::uint32_t k = 0; k < 3; ++k) {
        // Corner triangle k has two sides on the border of the group. Across each lies the corner triangle,
        // with the same even vertex, of the next group.
        const std::uint32_t inner = neighbors_.across(3 * middles[i] + k);
        for (std::uint32_t j = 1; j <= 2; ++j) {
          const std::uint32_t outer = neighbors_.across(3 * (inner / 3) + (inner % 3 + j) % 3);
          if (outer == kNone) continue;
          const std::uint32_t face = outer / 3, even = faces_[inner / 3][inner % 3];
          std::uint32_t corner = 0;
          while (faces_[face][corner] != even) ++corner;
          const std::uint32_t next = neighbors_.across(3 * face + corner);
          if (next == kNone || !(group_[face] == next / 3 || claim(next / 3, middles)) ||
              group_[face] != next / 3) {
            release(middles);
            return false;
          }
        }
      }
    }
    for (const std::uint32_t f : middles) {
      const Triangle even = even_vertices(f);
      // The middle triangle (m0, m1, m2) faces the corner triangles of v0, v1, v2 with its edges 0, 1, 2.
      for (std::size_t k = 0; k < 3; ++k)
        coarser.odd[ordered(even[(k + 1) % 3], even[(k + 2) % 3])] = faces_[f][k];
      coarser.faces.push_back(even);
    }
    return true;
  }

 private:
  enum class Role : std::uint8_t { kUnknown, kEven, kOdd };

  /// Takes `middle` and its three neighbours for one group, unless one is missing or taken, or a vertex would
  /// be even in one group and odd in another.
  bool claim(std::uint32_t middle, std::vector<std::uint32_t>& middles) {
    if (is_tiled(middle)) return false;
    std::uint32_t members[4] = {middle, 0, 0, 0};
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t slot = neighbors_.across(3 * middle + k);
      if (slot == kNone || is_tiled(slot / 3)) return false;
      members[k + 1] = slot / 3;
      if (roles_[faces_[middle][k]] == Role::kEven || roles_[faces_[slot / 3][slot % 3]] == Role::kOdd)
        return false;
      if (!must_be_even_.empty() && must_be_even_[faces_[middle][k]]) return false;
    }
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < i; ++j)
        if (members[i] == members[j]) return false;
    const Triangle even = even_vertices(middle);
    if (even[0] == even[1] || even[1] == even[2] || even[2] == even[0]) return false;
    for (const std::uint32_t member : members) group_[member] = middle;
    middles.push_back(middle);
    set_roles(middle, Role::kEven, Role::kOdd);
    return true;
  }
  /// The tips of the corner triangles: the coarse face.
  Triangle even_vertices(std::uint32_t middle) const {
    Triangle even;
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t slot = neighbors_.across(3 * middle + k);
      even[k] = faces_[slot / 3][slot % 3];
    }
    return even;
  }
  void set_roles(std::uint32_t middle, Role even, Role odd) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t slot = neighbors_.across(3 * middle + k);
      roles_[faces_[slot / 3][slot % 3]] = even;
      roles_[faces_[middle][k]] = odd;
    }
  }
  /// A failed guess has touched one component only, and no other guess has left anything there.
  void release(const std::vector<std::uint32_t>& middles) {
    for (const std::uint32_t f : middles) {
      set_roles(f, Role::kUnknown, Role::kUnknown);
      for (std::uint32_t k = 0; k < 3; ++k) group_[neighbors_.across(3 * f + k) / 3] = kNone;
      group_[f] = kNone;
    }
  }

  const std::vector<Triangle>& faces_;
  const FaceNeighbors& neighbors_;
  const std::vector<std::uint8_t>& must_be_even_;
  std::vector<std::uint32_t> group_;  // the middle face of each face's group
  std::vector<Role> roles_;           // of the vertices
};

/// An odd vertex belongs to one coarse edge only and is no corner of a coarse face, and the coarse faces are
/// a manifold again: otherwise the tiling is an accident.
bool is_consistent(const CoarserMesh& coarser, std::size_t vertex_count) {
  std::vector<std::uint8_t> is_even(vertex_count, 0), is_odd(vertex_count, 0);
  for (const Triangle& t : coarser.faces) {
    for (const std::uint32_t v : t) is_even[v] = 1;
  }
  for (const auto& [edge, v] : coarser.odd) {
    if (is_even[v] || is_odd[v]) return false;
    is_odd[v] = 1;
  }
  FaceNeighbors neighbors;
  return neighbors.build(coarser.faces);
}

std::optional<CoarserMesh> undo_split(const std::vector<Triangle>& faces, std::size_t vertex_count,
                                      const std::vector<std::uint8_t>& must_be_even) {
  if (faces.empty() || faces.size() % 4 != 0) return std::nullopt;
  FaceNeighbors neighbors;
  if (!neighbors.build(faces)) return std::nullopt;
  CoarserMesh coarser;
  Tiler tiler(faces, neighbors, vertex_count, must_be_even);
  for (std::uint32_t f = 0; f < faces.size(); ++f) {
    if (tiler.is_tiled(f)) continue;
    bool tiled = tiler.tile_component(f, coarser);
    for (std::uint32_t k = 0; k < 3 && !tiled; ++k) {
      const std::uint32_t slot = neighbors.across(3 * f + k);
      tiled = slot != kNone && tiler.tile_component(slot / 3, coarser) && tiler.is_tiled(f);
    }
    if (!tiled) return std::nullopt;
  }
  if (!is_consistent(coarser, vertex_count)) return std::nullopt;
  return coarser;
}

/// The hierarchy that undone splits tell. `must_be_even`: vertices that no split may have inserted, or
/// nothing.
std::optional<SemiRegularInput> recognize(const TriangleMesh& mesh, int maximum_level_count,
                                          const std::vector<std::uint8_t>& must_be_even) {
  for (const Triangle& t : mesh.triangles)
    for (const std::uint32_t v : t)
      if (v >= mesh.vertex_count()) return std::nullopt;
  std::vector<CoarserMesh> steps;  // finest first
  while (static_cast<int>(steps.size()) < maximum_level_count) {
    auto coarser =
        undo_split(steps.empty() ? mesh.triangles : steps.back().faces, mesh.vertex_count(), must_be_even);
    if (!coarser) break;
    steps.push_back(std::move(*coarser));
  }
  if (steps.empty()) return std::nullopt;

  SemiRegularInput input;
  std::vector<std::uint32_t> number(mesh.vertex_count(), kNone);
  for (Triangle t : steps.back().faces) {
    for (std::uint32_t& v : t) {
      if (number[v] == kNone) {
        number[v] = static_cast<std::uint32_t>(input.input_vertex.size());
        input.input_vertex.push_back(v);
      }
      v = number[v];
    }
    input.base_faces.push_back(t);
  }
  input.base_vertex_count = static_cast<std::uint32_t>(input.input_vertex.size());
  const int level_count = static_cast<int>(steps.size());
  try {
    input.hierarchy = SubdivisionHierarchy(input.base_faces, input.base_vertex_count, level_count);
  } catch (const Error&) {
    return std::nullopt;  // a vertex with two umbrellas
  }
  for (int l = 0; l < level_count; ++l) {
    const LevelTopology& topology = input.hierarchy.level(l);
    const CoarserMesh& step = steps[static_cast<std::size_t>(level_count - 1 - l)];
    for (std::uint32_t e = 0; e < topology.edge_count; ++e) {
      const auto odd = step.odd.find(ordered(input.input_vertex[topology.edge_vertices[2 * e]],
                                             input.input_vertex[topology.edge_vertices[2 * e + 1]]));
      if (odd == step.odd.end()) return std::nullopt;
      input.input_vertex.push_back(odd->second);
    }
  }
  if (input.input_vertex.size() != mesh.vertex_count()) return std::nullopt;  // unused vertices
  return input;
}

/// Finds the point that lies within a tolerance of another one. Cells of a grid far wider than the tolerance,
/// so that nearly always one of them is looked into.
class PlaceFinder {
 public:
  PlaceFinder(const std::vector<Vec3>& points, double tolerance)
      : points_(points), tolerance_(tolerance), cell_(64 * tolerance) {
    for (std::uint32_t i = 0; i < points.size(); ++i) cells_[cell_of(points[i])].push_back(i);
  }
  /// The nearest point within the tolerance, of equally near ones the first; kNone without one.
  std::uint32_t find(const Vec3& p) const {
    const Vec3 margin{tolerance_, tolerance_, tolerance_};
    const Cell low = cell_of(p - margin), high = cell_of(p + margin);
    std::uint32_t nearest = kNone;
    double least = tolerance_;
    Cell c;
    for (c[0] = low[0]; c[0] <= high[0]; ++c[0])
      for (c[1] = low[1]; c[1] <= high[1]; ++c[1])
        for (c[2] = low[2]; c[2] <= high[2]; ++c[2]) {
          const auto found = cells_.find(c);
          if (found == cells_.end()) continue;
          for (const std::uint32_t i : found->second) {
            const double d = distance(points_[i], p);
            if (d > least || (d == least && nearest < i)) continue;
            least = d;
            nearest = i;
          }
        }
    return nearest;
  }

 private:
  using Cell = std::array<std::int64_t, 3>;
  Cell cell_of(const Vec3& p) const {
    Cell c;
    for (int k = 0; k < 3; ++k)
      c[static_cast<std::size_t>(k)] = static_cast<std::int64_t>(std::floor(p[k] / cell_));
    return c;
  }

  const std::vector<Vec3>& points_;
  double tolerance_, cell_;
  std::map<Cell, std::vector<std::uint32_t>> cells_;
};

[[noreturn]] void refuse(const std::string& reason) { throw Error(ExitCode::kInvalidInput, reason); }

/// How often `base` must be split for so many triangles.
int splits_between(std::size_t base_triangles, std::size_t triangles) {
  int splits = 0;
  std::size_t count = base_triangles;
  for (; count < triangles; ++splits) count *= 4;
  if (count != triangles || splits == 0) {
    refuse("its " + std::to_string(triangles) + " triangles are not 4, 16, 64 ... times the " +
           std::to_string(base_triangles) + " of the base mesh");
  }
  return splits;
}

/// The corners in order: whoever prepared the mesh may have turned whole components inside out.
Triangle sorted(Triangle t) {
  std::sort(t.begin(), t.end());
  return t;
}

}  // namespace

std::optional<SemiRegularInput> recognize_subdivision_connectivity(const TriangleMesh& mesh,
                                                                   int maximum_level_count) {
  return recognize(mesh, maximum_level_count, {});
}

SemiRegularInput recognize_subdivision_of(const TriangleMesh& base, const TriangleMesh& mesh,
                                          double tolerance, std::optional<int> level_count) {
  if (base.triangles.empty()) refuse("the base mesh has no triangles");
  const int splits = splits_between(base.triangle_count(), mesh.triangle_count());
  if (level_count && *level_count != splits) {
    refuse("its " + std::to_string(mesh.triangle_count()) + " triangles are those of the base mesh after " +
           std::to_string(splits) + " splits, not " + std::to_string(*level_count));
  }
  if (!std::all_of(base.positions.begin(), base.positions.end(), [](const Vec3& p) { return is_finite(p); }))
    refuse("a vertex of the base mesh is not finite");
  // A place stands for all vertices of the base that lie there: the number of the first of them.
  const PlaceFinder places(base.positions, tolerance);
  std::vector<std::uint32_t> place_of(mesh.vertex_count());
  std::vector<std::uint8_t> is_of_base(mesh.vertex_count(), 0), is_found(base.vertex_count(), 0);
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    place_of[v] = places.find(mesh.positions[v]);
    if (place_of[v] == kNone) continue;
    is_of_base[v] = 1;
    is_found[place_of[v]] = 1;
  }
  std::map<Triangle, int> triangles;  // of the base by places; how many of each
  for (const Triangle& t : base.triangles) {
    Triangle named;
    for (std::size_t k = 0; k < 3; ++k) {
      if (t[k] >= base.vertex_count())
        refuse("a triangle of the base mesh names a vertex that does not exist");
      named[k] = places.find(base.positions[t[k]]);
      if (!is_found[named[k]]) {
        refuse("vertex " + std::to_string(t[k]) + " of the base mesh (from 0) is no vertex of the input");
      }
    }
    ++triangles[sorted(named)];
  }
  std::optional<SemiRegularInput> input = recognize(mesh, splits, is_of_base);
  if (!input || input->hierarchy.level_count() < splits) {
    refuse("its connectivity is not that of the base mesh after " + std::to_string(splits) +
           " splits; only " + std::to_string(input ? input->hierarchy.level_count() : 0) + " can be undone");
  }
  for (const Triangle& t : input->base_faces) {
    Triangle named;
    for (std::size_t k = 0; k < 3; ++k) named[k] = place_of[input->input_vertex[t[k]]];
    const auto found = triangles.find(sorted(named));
    if (found == triangles.end() || found->second-- == 0)
      refuse("undoing its splits ends with triangles that the base mesh does not have");
  }
  return std::move(*input);
}

Parameterization identity_parameterization(const SemiRegularInput& input, const TriangleMesh& mesh) {
  const int level_count = input.hierarchy.level_count();
  Parameterization result;
  result.domain = BaseDomain(input.base_vertex_count, input.base_faces);
  const BaseDomain& domain = result.domain;
  auto surface = std::make_shared<TriangleMesh>();
  surface->triangles = level_triangles(input.hierarchy.level(level_count));
  for (const std::uint32_t v : input.input_vertex) surface->positions.push_back(mesh.positions[v]);
  result.input_vertex_count = surface->vertex_count();

  std::vector<std::array<ChartPoint, 3>> corners(input.base_faces.size(), kFaceCorners);
  for (int l = 0; l < level_count; ++l) {
    std::vector<std::array<ChartPoint, 3>> finer;
    finer.reserve(4 * corners.size());
    for (const auto& c : corners) {
      const ChartPoint m0 = 0.5 * (c[1] + c[2]), m1 = 0.5 * (c[2] + c[0]), m2 = 0.5 * (c[0] + c[1]);
      finer.push_back({c[0], m2, m1});
      finer.push_back({m2, c[1], m0});
      finer.push_back({m1, m0, c[2]});
      finer.push_back({m0, m1, m2});
    }
    corners = std::move(finer);
  }
  result.vertex_points.resize(surface->vertex_count());
  result.triangle_charts.resize(surface->triangle_count());
  for (std::uint32_t t = 0; t < surface->triangle_count(); ++t) {
    const std::uint32_t face = t >> (2 * level_count);
    TriangleChart& chart = result.triangle_charts[t];
    chart.face = face;
    for (std::size_t k = 0; k < 3; ++k) {
      DomainPoint& point = result.vertex_points[surface->triangles[t][k]];
      if (point.face == kNoFace) point = {face, corners[t][k]};
      if (point.face == face) continue;
      if (domain.cone_at(point) == kNoVertex) {
        chart.maps[k] = *domain.find_map(point.face, face);  // the neighbour across a base edge
        continue;
      }
      // Any isometry that takes corner to corner will do, and a translation does.
      chart.maps[k].tu = static_cast<std::int16_t>(std::lround(corners[t][k].u - point.at.u));
      chart.maps[k].tv = static_cast<std::int16_t>(std::lround(corners[t][k].v - point.at.v));
    }
  }
  for (std::uint32_t v = 0; v < input.base_vertex_count; ++v) {
    result.base_vertex_ids.push_back(v);
    result.base_positions.push_back(surface->positions[v]);
  }
  result.surface = std::move(surface);
  return result;
}

}  // namespace nmc
