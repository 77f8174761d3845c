// SPDX-License-Identifier: Apache-2.0
#include "encoder/pipeline/renumber.h"

#include <algorithm>
#include <map>
#include <utility>

#include "encoder/core/error.h"
#include "libnmc/encode/stream_writer.h"

namespace nmc {

namespace {

/// Edges of two level-0 topologies of the same mesh, matched by their end points.
LevelRenumbering match_base(const LevelTopology& old_base, const LevelTopology& new_base,
                            const std::vector<std::uint32_t>& old_vertex) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> old_slot;  // directed edge -> 3 * face + corner
  for (std::uint32_t f = 0; f < old_base.face_count; ++f)
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t* v = old_base.face_vertices.data() + std::size_t{3} * f;
      old_slot[{v[k], v[(k + 1) % 3]}] = 3 * f + k;
    }
  LevelRenumbering result;
  result.old_face.resize(new_base.face_count);
  result.first_corner.resize(new_base.face_count);
  result.old_edge.resize(new_base.edge_count);
  result.reversed.resize(new_base.edge_count);
  for (std::uint32_t f = 0; f < new_base.face_count; ++f) {
    const std::uint32_t* v = new_base.face_vertices.data() + std::size_t{3} * f;
    const auto found = old_slot.find({old_vertex[v[0]], old_vertex[v[1]]});
    if (found == old_slot.end()) throw Error(ExitCode::kInternal, "the stream order lost a base face");
    result.old_face[f] = found->second / 3;
    result.first_corner[f] = static_cast<std::uint8_t>(found->second % 3);
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t new_edge = new_base.face_edges[3 * f + k];
      const std::uint32_t old_edge =
          old_base.face_edges[3 * result.old_face[f] + (k + result.first_corner[f]) % 3];
      result.old_edge[new_edge] = old_edge;
      result.reversed[new_edge] =
          old_base.edge_vertices[2 * old_edge] != old_vertex[new_base.edge_vertices[2 * new_edge]];
    }
  }
  return result;
}

/// The rule of libnmc/common/subdivision.h, applied to both numberings at once.
LevelRenumbering refine(const LevelRenumbering& coarse, const LevelTopology& old_level) {
  const auto face_count = static_cast<std::uint32_t>(coarse.old_face.size());
  const auto edge_count = static_cast<std::uint32_t>(coarse.old_edge.size());
  LevelRenumbering fine;
  fine.old_face.resize(std::size_t{4} * face_count);
  fine.first_corner.resize(std::size_t{4} * face_count);
  fine.old_edge.resize(std::size_t{2} * edge_count + std::size_t{3} * face_count);
  fine.reversed.resize(fine.old_edge.size());
  for (std::uint32_t e = 0; e < edge_count; ++e) {
    for (std::uint32_t half = 0; half < 2; ++half) {
      fine.old_edge[2 * e + half] = 2 * coarse.old_edge[e] + (coarse.reversed[e] ? 1 - half : half);
      fine.reversed[2 * e + half] = coarse.reversed[e];
    }
  }
  for (std::uint32_t f = 0; f < face_count; ++f) {
    const std::uint32_t old = coarse.old_face[f], turn = coarse.first_corner[f];
    for (std::uint32_t k = 0; k < 3; ++k) {
      // Corner child k keeps its own corner k in place k, so it is turned as its parent is.
      fine.old_face[4 * f + k] = 4 * old + (k + turn) % 3;
      fine.first_corner[4 * f + k] = coarse.first_corner[f];
      const std::size_t inner = std::size_t{2} * edge_count + std::size_t{3} * f + k;
      fine.old_edge[inner] = 2 * old_level.edge_count + 3 * old + (k + turn) % 3;
      fine.reversed[inner] = 0;
    }
    fine.old_face[4 * f + 3] = 4 * old + 3;
    fine.first_corner[4 * f + 3] = coarse.first_corner[f];
  }
  return fine;
}

}  // namespace

StreamOrder stream_order(const SubdivisionHierarchy& hierarchy) {
  const LevelTopology& base = hierarchy.level(0);
  Array<std::uint32_t> old_index, new_faces;
  const Status status = order_base_mesh(base.face_vertices.data(), base.face_count, base.vertex_count, nullptr,
                                        old_index, new_faces);
  if (!status.ok()) {
    throw Error(ExitCode::kInternal, std::string("base mesh: ") + (status.message() ? status.message() : "no order"));
  }
  StreamOrder order;
  order.old_vertex.assign(old_index.begin(), old_index.end());
  order.base_faces.resize(base.face_count);
  for (std::uint32_t f = 0; f < base.face_count; ++f)
    for (std::uint32_t k = 0; k < 3; ++k) order.base_faces[f][k] = new_faces[3 * f + k];
  bool has_creases = false;
  for (std::uint32_t e = 0; e < base.edge_count; ++e) has_creases |= base.is_curve(e) && !base.is_boundary(e);
  if (has_creases) {
    const SubdivisionHierarchy plain(order.base_faces, base.vertex_count, 0);
    const LevelRenumbering match = match_base(base, plain.level(0), order.old_vertex);
    order.base_creases.resize(base.edge_count);
    for (std::uint32_t e = 0; e < base.edge_count; ++e) {
      const std::uint32_t old = match.old_edge[e];
      order.base_creases[e] = base.is_curve(old) && !base.is_boundary(old);
    }
  }
  return order;
}

NormalMesh renumber(const NormalMesh& mesh, const StreamOrder& order, std::vector<SurfaceSample>& samples) {
  const int level_count = mesh.level_count();
  NormalMesh result;
  result.hierarchy = SubdivisionHierarchy(order.base_faces, static_cast<std::uint32_t>(order.old_vertex.size()),
                                          level_count, order.base_creases);
  result.tension = mesh.tension;
  for (const std::uint32_t v : order.old_vertex) result.base_positions.push_back(mesh.base_positions[v]);
  LevelRenumbering numbers = match_base(mesh.hierarchy.level(0), result.hierarchy.level(0), order.old_vertex);
  for (int level = 0; level < level_count; ++level) {
    const auto l = static_cast<std::size_t>(level);
    const std::size_t edge_count = numbers.old_edge.size();
    std::vector<OddVertexDetail> details(edge_count);
    std::vector<std::uint8_t> non_normal(edge_count);
    for (std::size_t e = 0; e < edge_count; ++e) {
      details[e] = mesh.details[l][numbers.old_edge[e]];
      non_normal[e] = mesh.non_normal[l][numbers.old_edge[e]];
      if (numbers.reversed[e]) {  // the frame turns by half a turn about the normal
        details[e].along = -details[e].along;
        details[e].across = -details[e].across;
      }
    }
    result.details.push_back(std::move(details));
    result.non_normal.push_back(std::move(non_normal));
    numbers = refine(numbers, mesh.hierarchy.level(level));
  }
  std::vector<std::uint32_t> new_face(numbers.old_face.size());
  for (std::size_t f = 0; f < new_face.size(); ++f) new_face[numbers.old_face[f]] = static_cast<std::uint32_t>(f);
  for (SurfaceSample& sample : samples) {
    sample.face = new_face[sample.face];
    const int turn = numbers.first_corner[sample.face];
    const float b[3] = {sample.barycentric[0], sample.barycentric[1], sample.barycentric[2]};
    for (int k = 0; k < 3; ++k) sample.barycentric[k] = b[(k + turn) % 3];
  }
  return result;
}

}  // namespace nmc
