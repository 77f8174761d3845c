// SPDX-License-Identifier: Apache-2.0
#include "libnmc/encode/base_face_lookup.h"

#include <algorithm>

namespace nmc {

Status BaseFaceLookup::build(const std::uint32_t* face_vertices, std::uint32_t face_count,
                             std::uint32_t vertex_count, Memory* memory) {
  if (!edges_.resize(std::size_t{3} * face_count)) return no_memory();
  Array<std::uint32_t> parent(memory);  // union-find over vertices
  if (!parent.resize(vertex_count)) return no_memory();
  for (std::uint32_t v = 0; v < vertex_count; ++v) parent[v] = v;
  const auto root = [&](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (std::uint32_t f = 0; f < face_count; ++f) {
    const std::uint32_t* c = face_vertices + std::size_t{3} * f;
    for (std::uint32_t k = 0; k < 3; ++k) {
      edges_[3 * f + k] = {c[k], c[(k + 1) % 3], c[(k + 2) % 3]};
      const std::uint32_t a = root(c[k]), b = root(c[(k + 1) % 3]);
      if (a != b) parent[std::max(a, b)] = std::min(a, b);
    }
  }
  std::sort(edges_.begin(), edges_.end(), [](const Edge& a, const Edge& b) {
    return a.from != b.from ? a.from < b.from : a.to < b.to;  // a manifold has no directed edge twice
  });
  Array<std::uint8_t> seen(memory);
  if (!seen.resize(vertex_count)) return no_memory();
  seeds_.clear();
  for (std::uint32_t f = 0; f < face_count; ++f) {
    const std::uint32_t* c = face_vertices + std::size_t{3} * f;
    std::uint8_t& done = seen[root(c[0])];
    if (done) continue;
    done = 1;
    for (std::uint32_t k = 0; k < 3; ++k) {
      if (!seeds_.push_back(c[k])) return no_memory();
    }
  }
  return ok_status();
}

std::uint32_t BaseFaceLookup::third_corner(std::uint32_t u, std::uint32_t v) const {
  const Edge* found = std::lower_bound(edges_.begin(), edges_.end(), Edge{u, v, 0}, [](const Edge& a, const Edge& b) {
    return a.from != b.from ? a.from < b.from : a.to < b.to;
  });
  return found != edges_.end() && found->from == u && found->to == v ? found->third : kNone;
}

}  // namespace nmc
