// SPDX-License-Identifier: Apache-2.0
#include "libnmc/decode/vertex_normals.h"

#include <cmath>
#include <cstring>

namespace nmc {

namespace {

/// A power of two near 1 / longest edge of some faces of the mesh: products of scaled edges then neither
/// overflow nor vanish in single precision, whatever the units of the model are. A power of two changes no
/// direction.
double edge_scale(const LevelTopology& faces, const Vec3* positions) {
  double longest = 0;
  for (std::uint32_t f = 0; f < faces.face_count; ++f) {
    const std::uint32_t* v = faces.face_vertices.data() + std::size_t{3} * f;
    const Vec3 d = positions[v[1]] - positions[v[0]];
    const double m = std::fmax(std::fmax(std::fabs(d.x), std::fabs(d.y)), std::fabs(d.z));
    longest = m > longest ? m : longest;
  }
  if (!(longest > 0)) return 1;
  double scale = 1;
  while (longest * scale > 2) scale *= 0.5;
  while (longest * scale < 1) scale *= 2;
  return scale;
}

class NormalWriter {
 public:
  NormalWriter(const Vec3* positions, double scale, unsigned char* normals, std::size_t stride)
      : positions_(positions), scale_(scale), normals_(normals), stride_(stride) {}

  void add_face(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const Vec3 n = cross(scale_ * (positions_[b] - positions_[a]), scale_ * (positions_[c] - positions_[a]));
    const float add[3] = {static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)};
    for (const std::uint32_t v : {a, b, c}) {
      float sum[3];
      std::memcpy(sum, at(v), sizeof sum);
      for (int k = 0; k < 3; ++k) sum[k] += add[k];
      std::memcpy(at(v), sum, sizeof sum);
    }
  }
  void clear(std::uint32_t v) {
    const float zero[3] = {0, 0, 0};
    std::memcpy(at(v), zero, sizeof zero);
  }
  void normalize(std::uint32_t v) {
    float sum[3];
    std::memcpy(sum, at(v), sizeof sum);
    // In double: the square of a float cannot vanish.
    const Vec3 unit = normalized({sum[0], sum[1], sum[2]});
    const float out[3] = {static_cast<float>(unit.x), static_cast<float>(unit.y), static_cast<float>(unit.z)};
    std::memcpy(at(v), out, sizeof out);
  }

 private:
  unsigned char* at(std::uint32_t v) { return normals_ + stride_ * v; }

  const Vec3* positions_;
  double scale_;
  unsigned char* normals_;
  std::size_t stride_;
};

}  // namespace

void write_vertex_normals(const LevelTopology& faces, bool is_split, const Vec3* positions,
                          std::uint32_t vertex_count, unsigned char* normals, std::size_t stride) {
  NormalWriter writer(positions, edge_scale(faces, positions), normals, stride);
  for (std::uint32_t v = 0; v < vertex_count; ++v) writer.clear(v);
  for (std::uint32_t f = 0; f < faces.face_count; ++f) {
    const std::uint32_t* v = faces.face_vertices.data() + std::size_t{3} * f;
    if (!is_split) {
      writer.add_face(v[0], v[1], v[2]);
      continue;
    }
    const std::uint32_t* e = faces.face_edges.data() + std::size_t{3} * f;
    const std::uint32_t m0 = faces.vertex_count + e[0], m1 = faces.vertex_count + e[1],
                        m2 = faces.vertex_count + e[2];
    writer.add_face(v[0], m2, m1);
    writer.add_face(m2, v[1], m0);
    writer.add_face(m1, m0, v[2]);
    writer.add_face(m0, m1, m2);
  }
  for (std::uint32_t v = 0; v < vertex_count; ++v) writer.normalize(v);
}

}  // namespace nmc
