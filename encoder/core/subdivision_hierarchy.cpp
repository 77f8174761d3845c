// SPDX-License-Identifier: Apache-2.0
#include "encoder/core/subdivision_hierarchy.h"

#include <string>
#include <utility>

#include "encoder/core/error.h"

namespace nmc {

namespace {
void check(const Status& status, const char* what) {
  if (!status.ok()) {
    throw Error(ExitCode::kInternal, std::string(what) + ": " + (status.message() ? status.message() : "out of memory"));
  }
}
}  // namespace

SubdivisionHierarchy::SubdivisionHierarchy(const std::vector<Triangle>& base_faces, std::uint32_t base_vertex_count,
                                           int level_count, const std::vector<std::uint8_t>& base_creases) {
  levels_.emplace_back();
  check(build_base_topology(base_faces.empty() ? nullptr : base_faces.front().data(),
                            static_cast<std::uint32_t>(base_faces.size()), base_vertex_count, nullptr, levels_[0]),
        "base mesh");
  if (!base_creases.empty()) check(set_creases(base_creases.data(), levels_[0]), "base creases");
  check(ring_weights_.build(levels_[0]), "base mesh");
  refine_to(level_count);
}

void SubdivisionHierarchy::refine_to(int level_count) {
  while (this->level_count() < level_count) {
    LevelTopology fine;
    check(subdivide(levels_.back(), false, fine), "subdivision");
    levels_.push_back(std::move(fine));
  }
}

std::vector<Triangle> level_triangles(const LevelTopology& topology) {
  std::vector<Triangle> triangles(topology.face_count);
  for (std::uint32_t f = 0; f < topology.face_count; ++f)
    for (std::uint32_t k = 0; k < 3; ++k) triangles[f][k] = topology.face_vertices[3 * f + k];
  return triangles;
}

}  // namespace nmc
