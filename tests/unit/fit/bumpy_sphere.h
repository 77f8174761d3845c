// SPDX-License-Identifier: Apache-2.0
// A surface known by formula: a sphere with bumps, and a normal mesh that interpolates it, by radial
// projection.
#ifndef NMC_TESTS_UNIT_FIT_BUMPY_SPHERE_H_
#define NMC_TESTS_UNIT_FIT_BUMPY_SPHERE_H_

#include <cmath>
#include <utility>
#include <vector>

#include "encoder/normal_mesh/normal_mesh.h"
#include "encoder/normal_mesh/surface_samples.h"
#include "libnmc/common/local_frame.h"

namespace nmc {

struct BumpySphere {
  double amplitude = 0.08;
  double frequency = 7;

  double radius(const Vec3& d) const {
    return 1 + amplitude * std::sin(frequency * d.x + 0.3) * std::cos(frequency * d.y) *
                   std::sin(0.5 + frequency * d.z);
  }
  Vec3 project(const Vec3& p) const {
    const Vec3 d = normalized(p);
    return radius(d) * d;
  }
  /// Of the surface at the direction of `p`: gradient of |x| - radius(x / |x|) by central differences.
  Vec3 normal(const Vec3& p) const {
    const Vec3 x = project(p);
    const auto f = [&](const Vec3& y) { return norm(y) - radius(normalized(y)); };
    constexpr double h = 1e-5;
    return normalized({f(x + Vec3{h, 0, 0}) - f(x - Vec3{h, 0, 0}),
                       f(x + Vec3{0, h, 0}) - f(x - Vec3{0, h, 0}),
                       f(x + Vec3{0, 0, h}) - f(x - Vec3{0, 0, h})});
  }
};

inline std::vector<Triangle> octahedron_faces() {
  return {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
}
inline std::vector<Vec3> octahedron_vertices() {
  return {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
}

/// Every odd vertex is moved along its normal to the surface; where `every_nth` divides its index it gets the
/// exact point as a vector and is marked non-normal.
inline NormalMesh interpolating_mesh(const BumpySphere& surface, int level_count, std::uint32_t every_nth = 0,
                                     std::vector<Triangle> faces = octahedron_faces()) {
  NormalMesh mesh;
  mesh.base_positions = octahedron_vertices();
  std::uint32_t used = 0;
  for (const Triangle& t : faces)
    for (const std::uint32_t v : t) used = std::max(used, v + 1);
  mesh.base_positions.resize(used);
  for (Vec3& p : mesh.base_positions) p = surface.project(p);
  mesh.hierarchy = SubdivisionHierarchy(faces, used, level_count);
  std::vector<Vec3> positions = mesh.base_positions;
  for (int l = 0; l < level_count; ++l) {
    const LevelTopology& topology = mesh.hierarchy.level(l);
    auto& details = mesh.details.emplace_back(topology.edge_count);
    auto& flags = mesh.non_normal.emplace_back(topology.edge_count, std::uint8_t{0});
    std::vector<Vec3> predicted = positions;
    for (std::uint32_t e = 0; e < topology.edge_count; ++e) {
      const Vec3 p = predict_odd_vertex(topology, mesh.hierarchy.ring_weights(), e, {}, positions.data());
      const LocalFrame frame = odd_vertex_frame(topology, e, positions.data());
      if ((every_nth && e % every_nth == 0) || topology.is_curve(e)) {
        const Vec3 d = surface.project(p) - p;
        details[e] = {dot(d, frame.normal), dot(d, frame.across),
                      topology.is_curve(e) ? 0 : dot(d, frame.along)};
        flags[e] = topology.is_curve(e) ? 0 : 1;
        continue;
      }
      double t = 0;  // along the normal to the surface, by Newton's method on |x| - radius
      for (int i = 0; i < 20; ++i) {
        const Vec3 x = p + t * frame.normal;
        t -= (norm(x) - surface.radius(normalized(x))) / std::max(0.2, dot(normalized(x), frame.normal));
      }
      details[e].normal = t;
    }
    reconstruct_level(mesh, l, positions);
  }
  return mesh;
}

/// Six samples per finest face, each at its radial projection.
inline std::vector<SurfaceSample> radial_samples(const BumpySphere& surface, const NormalMesh& mesh) {
  const LevelTopology& finest = mesh.hierarchy.level(mesh.level_count());
  const std::vector<Vec3> x = reconstruct(mesh, mesh.level_count());
  constexpr float kPoints[6][3] = {{0.6f, 0.2f, 0.2f},   {0.2f, 0.6f, 0.2f},   {0.2f, 0.2f, 0.6f},
                                   {0.1f, 0.45f, 0.45f}, {0.45f, 0.1f, 0.45f}, {0.45f, 0.45f, 0.1f}};
  std::vector<SurfaceSample> samples;
  for (std::uint32_t f = 0; f < finest.face_count; ++f) {
    const Vec3 &a = x[finest.face_vertices[3 * f]], &b = x[finest.face_vertices[3 * f + 1]],
               &c = x[finest.face_vertices[3 * f + 2]];
    const double area = 0.5 * norm(cross(b - a, c - a));
    for (const auto& point : kPoints) {
      SurfaceSample s;
      s.face = f;
      for (int k = 0; k < 3; ++k) s.barycentric[k] = point[k];
      const Vec3 y = static_cast<double>(point[0]) * a + static_cast<double>(point[1]) * b +
                     static_cast<double>(point[2]) * c;
      s.target = surface.project(y);
      s.normal = surface.normal(y);
      s.weight = static_cast<float>(area / 6);
      samples.push_back(s);
    }
  }
  return samples;
}

/// The surface itself as a fine triangle mesh: the octahedron split `levels` times and projected.
inline TriangleMesh fine_mesh(const BumpySphere& surface, int levels) {
  const SubdivisionHierarchy hierarchy(octahedron_faces(), 6, levels);
  TriangleMesh mesh;
  mesh.positions = octahedron_vertices();
  for (int l = 0; l < levels; ++l) {
    const LevelTopology& topology = hierarchy.level(l);
    for (std::uint32_t e = 0; e < topology.edge_count; ++e)
      mesh.positions.push_back(normalized(mesh.positions[topology.edge_vertices[2 * e]] +
                                          mesh.positions[topology.edge_vertices[2 * e + 1]]));
  }
  for (Vec3& p : mesh.positions) p = surface.project(p);
  mesh.triangles = level_triangles(hierarchy.level(levels));
  return mesh;
}

/// A fixed sequence of numbers in [-1, 1) (xorshift64*, seed 1).
class FixedNumbers {
 public:
  double next() {
    state_ ^= state_ >> 12;
    state_ ^= state_ << 25;
    state_ ^= state_ >> 27;
    return static_cast<double>((state_ * 0x2545f4914f6cdd1dull) >> 11) / 4503599627370496.0 - 1;
  }

 private:
  std::uint64_t state_ = 1;
};

}  // namespace nmc

#endif  // NMC_TESTS_UNIT_FIT_BUMPY_SPHERE_H_
