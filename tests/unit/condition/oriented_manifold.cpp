// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/condition/oriented_manifold.h"

#include <fmt/format.h>

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <map>

#include "encoder/read/mesh_reader.h"

namespace nmc::test {

namespace {

std::string edge_fault(const TriangleMesh& mesh) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> directed;
  for (const Triangle& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) directed.push_back({t[k], t[(k + 1) % 3]});
  std::sort(directed.begin(), directed.end());
  for (std::size_t i = 1; i < directed.size(); ++i)
    if (directed[i] == directed[i - 1])
      return fmt::format("two triangles run from vertex {} to vertex {}", directed[i].first,
                         directed[i].second);
  return "";
}

std::string openmesh_fault(const TriangleMesh& mesh) {
  OpenMesh::TriMesh_ArrayKernelT<> half_edges;
  std::vector<OpenMesh::VertexHandle> vertices;
  for (const Vec3& p : mesh.positions)
    vertices.push_back(
        half_edges.add_vertex({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)}));
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    const Triangle& c = mesh.triangles[t];
    if (!half_edges.add_face(vertices[c[0]], vertices[c[1]], vertices[c[2]]).is_valid())
      return fmt::format("OpenMesh refuses triangle {} ({}, {}, {})", t, c[0], c[1], c[2]);
  }
  // OpenMesh lets several fans meet in a vertex as long as each is open; an umbrella has at most one gap.
  for (const auto vertex : half_edges.vertices()) {
    int gaps = 0;
    for (const auto h : half_edges.voh_range(vertex)) gaps += half_edges.is_boundary(h);
    if (gaps > 1) return fmt::format("vertex {} has {} umbrellas", vertex.idx(), gaps);
  }
  return "";
}

}  // namespace

std::string manifold_fault(const TriangleMesh& mesh) {
  std::vector<std::uint8_t> is_used(mesh.vertex_count(), 0);
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    const Triangle& c = mesh.triangles[t];
    if (c[0] == c[1] || c[1] == c[2] || c[2] == c[0]) return fmt::format("triangle {} repeats a vertex", t);
    for (const std::uint32_t v : c) {
      if (v >= mesh.vertex_count()) return fmt::format("triangle {} names vertex {}", t, v);
      is_used[v] = 1;
    }
  }
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    if (!is_used[v]) return fmt::format("vertex {} is unused", v);
    if (!is_finite(mesh.positions[v])) return fmt::format("vertex {} is not finite", v);
  }
  std::vector<Triangle> sorted = mesh.triangles;
  for (Triangle& t : sorted) std::sort(t.begin(), t.end());
  std::sort(sorted.begin(), sorted.end());
  const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
  if (twice != sorted.end())
    return fmt::format("two triangles on vertices {}, {}, {}", (*twice)[0], (*twice)[1], (*twice)[2]);
  const std::string fault = edge_fault(mesh);
  return fault.empty() ? openmesh_fault(mesh) : fault;
}

std::string accounting_fault(const TriangleMesh& input, const ConditionedMesh& output) {
  const ConditionReport& report = output.report;
  const TriangleMesh& mesh = output.mesh;
  if (output.source_vertex.size() != mesh.vertex_count() ||
      output.stitched_vertex.size() != mesh.vertex_count())
    return "a vertex map has the wrong size";
  if (output.source_triangle.size() != mesh.triangle_count() ||
      output.component_of_triangle.size() != mesh.triangle_count())
    return "a triangle map has the wrong size";
  if (output.fate.size() != input.triangle_count()) return "fate has the wrong size";
  std::vector<std::uint8_t> vertex_is_kept(input.vertex_count(), 0);
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    if (output.source_vertex[v] >= input.vertex_count()) return fmt::format("vertex {} has no source", v);
    vertex_is_kept[output.source_vertex[v]] = 1;
    for (int k = 0; k < 3; ++k)
      if (std::bit_cast<std::uint64_t>(mesh.positions[v][k]) !=
          std::bit_cast<std::uint64_t>(input.positions[output.source_vertex[v]][k]))
        return fmt::format("vertex {} moved", v);
    if (output.stitched_vertex[v] > v ||
        output.stitched_vertex[output.stitched_vertex[v]] != output.stitched_vertex[v])
      return fmt::format("vertex {} is stitched to {}, which is not the lowest", v,
                         output.stitched_vertex[v]);
  }
  const auto kept_vertices =
      static_cast<std::size_t>(std::count(vertex_is_kept.begin(), vertex_is_kept.end(), 1));
  const std::size_t accounted = kept_vertices + report.non_finite_vertices + report.unreferenced_vertices +
                                report.welded_exactly + report.welded_nearby;
  if (accounted != input.vertex_count())
    return fmt::format("{} of {} input vertices are accounted for", accounted, input.vertex_count());

  std::vector<std::uint8_t> triangle_is_kept(input.triangle_count(), 0);
  std::size_t filled = 0;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    const std::uint32_t source = output.source_triangle[t];
    if (source == kFilledHole) {
      ++filled;
      continue;
    }
    if (source >= input.triangle_count()) return fmt::format("triangle {} has no source", t);
    triangle_is_kept[source] = 1;
    if (output.fate[source] == TriangleFate::kKept)
      for (int k = 0; k < 3; ++k)
        // Welding may have put another vertex at the corner, at the same place or within the weld distance.
        if (distance(mesh.positions[mesh.triangles[t][k]], input.positions[input.triangles[source][k]]) >
            2 * report.weld_distance)
          return fmt::format("triangle {} counts as kept but differs from its source {}", t, source);
  }
  if (filled != report.filled_hole_triangles)
    return fmt::format("{} filling triangles, {} reported", filled, report.filled_hole_triangles);
  std::size_t fates[kTriangleFateCount] = {};
  for (std::size_t t = 0; t < input.triangle_count(); ++t) {
    ++fates[static_cast<int>(output.fate[t])];
    if (is_dropped(output.fate[t]) == (triangle_is_kept[t] != 0))
      return fmt::format("input triangle {} has fate {} and is {}in the output", t,
                         static_cast<int>(output.fate[t]), triangle_is_kept[t] ? "" : "not ");
  }
  for (int i = 0; i < kTriangleFateCount; ++i)
    if (fates[i] != report.triangles_by_fate[i])
      return fmt::format("fate {}: {} triangles, {} reported", i, fates[i], report.triangles_by_fate[i]);

  std::size_t component_triangles = 0, loops = 0;
  for (const ConditionedComponent& c : report.components) {
    component_triangles += c.triangle_count;
    loops += c.boundary_loop_count;
    if (!c.orientable ||
        c.euler_characteristic() != 2 - 2 * c.genus - static_cast<long>(c.boundary_loop_count))
      return fmt::format("component of triangle {}: Euler characteristic {}, genus {}, {} loops",
                         c.first_triangle, c.euler_characteristic(), c.genus, c.boundary_loop_count);
  }
  if (component_triangles != mesh.triangle_count()) return "the components do not add up";
  if (loops != report.boundary_loops.size()) return "the boundary loops do not add up";
  return "";
}

std::string difference(const TriangleMesh& a, const TriangleMesh& b) {
  if (a.vertex_count() != b.vertex_count() || a.triangle_count() != b.triangle_count())
    return fmt::format("{} vertices and {} triangles against {} and {}", a.vertex_count(), a.triangle_count(),
                       b.vertex_count(), b.triangle_count());
  for (std::size_t v = 0; v < a.vertex_count(); ++v)
    for (int k = 0; k < 3; ++k)
      if (std::bit_cast<std::uint64_t>(a.positions[v][k]) != std::bit_cast<std::uint64_t>(b.positions[v][k]))
        return fmt::format("coordinate {} of vertex {}: {} against {}", k, v, a.positions[v][k],
                           b.positions[v][k]);
  for (std::size_t t = 0; t < a.triangle_count(); ++t)
    if (a.triangles[t] != b.triangles[t])
      return fmt::format("triangle {}: ({}, {}, {}) against ({}, {}, {})", t, a.triangles[t][0],
                         a.triangles[t][1], a.triangles[t][2], b.triangles[t][0], b.triangles[t][1],
                         b.triangles[t][2]);
  return "";
}

bool read_corpus_mesh(const std::string& file, TriangleMesh& mesh) {
  const char* folder = std::getenv("NMC_CORPUS");
  const std::filesystem::path path =
      (folder != nullptr ? std::filesystem::path(folder)
                         : std::filesystem::path(NMC_SOURCE_DIR).parent_path() / "shared" / "corpus") /
      file;
  if (!std::filesystem::exists(path)) {
    if (std::getenv("CI") != nullptr) FAIL("missing: " << path);
    WARN("not tested, missing: " << path);
    return false;
  }
  mesh = read_mesh(path.string());
  return true;
}

}  // namespace nmc::test
