// SPDX-License-Identifier: Apache-2.0
// The affine transforms of glTF nodes and instances.
#ifndef NMC_ENCODER_READ_GLTF_TRANSFORM_H_
#define NMC_ENCODER_READ_GLTF_TRANSFORM_H_

#include <array>
#include <span>

#include "libnmc/common/vec3.h"

namespace nmc {

/// p -> columns[0] p.x + columns[1] p.y + columns[2] p.z + columns[3].
struct AffineTransform {
  std::array<Vec3, 4> columns = {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}, Vec3{0, 0, 0}};

  Vec3 direction(const Vec3& d) const { return columns[0] * d.x + columns[1] * d.y + columns[2] * d.z; }
  Vec3 operator()(const Vec3& p) const { return direction(p) + columns[3]; }

  /// This transform after `inner`.
  AffineTransform operator*(const AffineTransform& inner) const {
    return {{direction(inner.columns[0]), direction(inner.columns[1]), direction(inner.columns[2]),
             (*this)(inner.columns[3])}};
  }

  /// True where the transform turns surfaces inside out (a mirroring).
  bool mirrors() const { return dot(cross(columns[0], columns[1]), columns[2]) < 0; }

  /// Translation after rotation (a quaternion x y z w, normalized here) after scale: glTF 2.0, section 3.5.2.
  static AffineTransform from_parts(const Vec3& translation, std::array<double, 4> rotation,
                                    const Vec3& scale) {
    auto [x, y, z, w] = rotation;
    const double length = std::sqrt(x * x + y * y + z * z + w * w);
    if (length > 0) {
      x /= length;
      y /= length;
      z /= length;
      w /= length;
    }
    const Vec3 a{1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)};
    const Vec3 b{2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)};
    const Vec3 c{2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)};
    return {{a * scale.x, b * scale.y, c * scale.z, translation}};
  }

  /// From the 16 numbers of a column-major 4x4 matrix; its last row is taken as 0 0 0 1.
  static AffineTransform from_matrix(std::span<const double> m) {
    return {
        {Vec3{m[0], m[1], m[2]}, Vec3{m[4], m[5], m[6]}, Vec3{m[8], m[9], m[10]}, Vec3{m[12], m[13], m[14]}}};
  }
};

}  // namespace nmc

#endif  // NMC_ENCODER_READ_GLTF_TRANSFORM_H_
