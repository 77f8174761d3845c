// SPDX-License-Identifier: Apache-2.0
#include "encoder/tool/vertex_map.h"

#include <fmt/format.h>

#include <array>
#include <iterator>

#include "encoder/core/parallel.h"
#include "encoder/spatial/surface_index.h"

namespace nmc {

SurfaceAddress address_on_base(std::uint32_t face, int level, const double (&barycentric)[3]) {
  // A child's corners are corners and edge midpoints of its parent; the inner child's are the midpoints
  // alone.
  std::array<double, 3> weights{barycentric[0], barycentric[1], barycentric[2]};
  for (int l = level; l > 0; --l) {
    const std::uint32_t child = face % 4;
    face /= 4;
    const std::array<double, 3> w = weights;
    if (child == 3) {
      for (std::size_t k = 0; k < 3; ++k) weights[k] = 0.5 * (w[(k + 1) % 3] + w[(k + 2) % 3]);
    } else {
      for (std::size_t k = 0; k < 3; ++k) weights[k] = 0.5 * w[k];
      weights[child] = 0.5 + 0.5 * w[child];
    }
  }
  return {face, weights[1], weights[2], 0};
}

std::vector<SurfaceAddress> map_vertices(const TriangleMesh& input, const TriangleMesh& decoded, int level) {
  const SurfaceIndex index(decoded);
  std::vector<SurfaceAddress> map(input.vertex_count());
  parallel_for(input.vertex_count(), [&](std::size_t i) {
    const Vec3& p = input.positions[i];
    if (!is_finite(p)) return;
    const SurfacePoint nearest = index.closest_point(p);
    if (!nearest.found()) return;
    map[i] = address_on_base(nearest.triangle, level, nearest.barycentric);
    const Triangle& t = decoded.triangles[nearest.triangle];
    const Vec3& a = decoded.positions[t[0]];
    const Vec3 normal = cross(decoded.positions[t[1]] - a, decoded.positions[t[2]] - a);
    const double d = distance(p, nearest.position);
    map[i].height = dot(normal, p - nearest.position) < 0 ? -d : d;
  });
  return map;
}

std::string to_csv(const std::vector<SurfaceAddress>& map) {
  fmt::memory_buffer text;
  auto out = std::back_inserter(text);
  fmt::format_to(out, "vertex,base_face,u,v,height\n");
  for (std::size_t i = 0; i < map.size(); ++i) {
    const SurfaceAddress& a = map[i];
    if (a.base_face == kNoBaseFace)
      fmt::format_to(out, "{},-1,0,0,0\n", i);
    else
      fmt::format_to(out, "{},{},{:.9g},{:.9g},{:.9g}\n", i, a.base_face, a.u, a.v, a.height);
  }
  return fmt::to_string(text);
}

}  // namespace nmc
