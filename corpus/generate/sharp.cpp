// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <map>
#include <numbers>

#include "corpus/generate/shapes.h"

namespace nmc::corpus {

namespace {
using std::numbers::pi;

void add_quad(TriangleMesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  mesh.triangles.push_back({a, b, c});
  mesh.triangles.push_back({a, c, d});
}
}  // namespace

TriangleMesh koch_surface(int level) {
  TriangleMesh mesh;
  mesh.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int i = 0; i < level; ++i) {
    const TriangleMesh fine = split_one_to_four(mesh);
    mesh.positions = fine.positions;
    mesh.triangles.clear();
    for (std::size_t t = 0; t < fine.triangle_count(); ++t) {
      const Triangle& c = fine.triangles[t];
      if (t % 4 != 3) {  // split_one_to_four() puts the middle triangle last
        mesh.triangles.push_back(c);
        continue;
      }
      const Vec3 &p = mesh.positions[c[0]], &q = mesh.positions[c[1]], &r = mesh.positions[c[2]];
      // A pyramid of 0.3 edge lengths; a regular one (0.82) would touch its neighbours from the second level
      // on.
      const double height = 0.3 * std::sqrt(norm(cross(q - p, r - p)));
      const auto apex = static_cast<std::uint32_t>(mesh.vertex_count());
      mesh.positions.push_back((p + q + r) / 3 + height * normalized(cross(q - p, r - p)));
      for (int k = 0; k < 3; ++k) mesh.triangles.push_back({c[k], c[(k + 1) % 3], apex});
    }
  }
  return mesh;
}

TriangleMesh gear(int tooth_count, int segments) {
  // Radius over the angle of one tooth: root, rising flank, tip, falling flank, each `segments` long.
  const double root_radius = 0.82, tip_radius = 1.0, bore_radius = 0.3, height = 0.25;
  std::vector<Vec3> profile;
  for (int tooth = 0; tooth < tooth_count; ++tooth)
    for (int part = 0; part < 4; ++part)
      for (int s = 0; s < segments; ++s) {
        const double along = static_cast<double>(s) / segments;
        const double radius = part == 0   ? root_radius
                              : part == 1 ? root_radius + along * (tip_radius - root_radius)
                              : part == 2 ? tip_radius
                                          : tip_radius - along * (tip_radius - root_radius);
        const double share[5] = {0, 0.3, 0.5, 0.8, 1};
        const double angle =
            2 * pi * (tooth + share[part] + along * (share[part + 1] - share[part])) / tooth_count;
        profile.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
      }
  const auto count = static_cast<std::uint32_t>(profile.size());
  const std::uint32_t ring_count = 2 * static_cast<std::uint32_t>(segments) + 2;
  TriangleMesh mesh;
  // Rings from the bore over the bottom to the rim, up the rim, back over the top and down the bore.
  std::vector<std::uint32_t> rings;
  const auto add_ring = [&](double outward, double z) {
    rings.push_back(static_cast<std::uint32_t>(mesh.vertex_count()));
    for (const Vec3& p : profile) {
      const Vec3 bore = bore_radius * normalized(p);
      mesh.positions.push_back(bore + outward * (p - bore) + Vec3{0, 0, z});
    }
  };
  for (std::uint32_t i = 0; i < ring_count; ++i) add_ring(static_cast<double>(i) / (ring_count - 1), 0);
  for (int i = 1; i < segments; ++i) add_ring(1, height * i / segments);
  for (std::uint32_t i = ring_count; i-- > 0;) add_ring(static_cast<double>(i) / (ring_count - 1), height);
  for (int i = segments - 1; i > 0; --i) add_ring(0, height * i / segments);
  for (std::size_t r = 0; r < rings.size(); ++r) {
    const std::uint32_t here = rings[r], next = rings[(r + 1) % rings.size()];
    for (std::uint32_t j = 0; j < count; ++j) {
      const std::uint32_t j1 = (j + 1) % count;
      add_quad(mesh, here + j, here + j1, next + j1, next + j);
    }
  }
  return mesh;
}

TriangleMesh voxel_surface(int nx, int ny, int nz, const std::function<bool(int, int, int)>& is_solid,
                           const Vec3& cell) {
  TriangleMesh mesh;
  std::map<std::array<int, 3>, std::uint32_t> vertices;
  const auto vertex = [&](const std::array<int, 3>& at) {
    const auto [place, is_new] = vertices.try_emplace(at, static_cast<std::uint32_t>(mesh.vertex_count()));
    if (is_new) mesh.positions.push_back({at[0] * cell.x, at[1] * cell.y, at[2] * cell.z});
    return place->second;
  };
  const auto solid = [&](const std::array<int, 3>& c) {
    return c[0] >= 0 && c[0] < nx && c[1] >= 0 && c[1] < ny && c[2] >= 0 && c[2] < nz &&
           is_solid(c[0], c[1], c[2]);
  };
  for (int x = 0; x < nx; ++x)
    for (int y = 0; y < ny; ++y)
      for (int z = 0; z < nz; ++z) {
        const std::array<int, 3> c = {x, y, z};
        if (!solid(c)) continue;
        for (int axis = 0; axis < 3; ++axis)
          for (const int side : {0, 1}) {
            std::array<int, 3> neighbour = c;
            neighbour[axis] += side ? 1 : -1;
            if (solid(neighbour)) continue;
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            std::array<std::uint32_t, 4> corners{};
            for (int k = 0; k < 4; ++k) {
              std::array<int, 3> at = c;
              at[axis] += side;
              at[u] += k == 1 || k == 2;
              at[v] += k >= 2;
              corners[k] = vertex(at);
            }
            if (side)
              add_quad(mesh, corners[0], corners[1], corners[2], corners[3]);
            else
              add_quad(mesh, corners[3], corners[2], corners[1], corners[0]);
          }
      }
  return mesh;
}

TriangleMesh perforated_plate(int nx, int ny) {
  const double cell = 1.0 / (2 * nx + 1);
  return voxel_surface(2 * nx + 1, 2 * ny + 1, 1, [](int x, int y, int) { return x % 2 == 0 || y % 2 == 0; },
                       {cell, cell, cell});
}

TriangleMesh comb(int tine_count, int tine_length) {
  const double cell = 1.0 / (2 * tine_count);
  return voxel_surface(2 * tine_count - 1, tine_length + 2, 1,
                       [](int x, int y, int) { return y < 2 || x % 2 == 0; }, {cell, cell, cell});
}

}  // namespace nmc::corpus
