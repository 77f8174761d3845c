// SPDX-License-Identifier: Apache-2.0
// Which triangle is seen at each pixel: an off-screen z-buffer without any graphics hardware.
//
// Based on: Pineda, "A parallel algorithm for polygon rasterization", SIGGRAPH 1988 (edge functions).
#ifndef NMC_ENCODER_RENDER_RASTERIZER_H_
#define NMC_ENCODER_RENDER_RASTERIZER_H_

#include <cstdint>
#include <vector>

#include "encoder/core/triangle_mesh.h"

namespace nmc {

/// Looks along -z of its own axes with perspective; x goes right and y up. Positions are in units of the
/// mesh.
struct Camera {
  Vec3 eye;
  Vec3 right, up, back;               // orthonormal; `back` points from the scene to the eye
  double focal = 1;                   // pixels per unit of slope
  double center_x = 0, center_y = 0;  // pixel that the eye looks at
};

/// A camera at the side `from` of the box that shows every vertex of `mesh` within the given pixels, with
/// `margin` pixels left free at each edge. `from` and `up` need not be unit vectors and must not be parallel.
Camera camera_around(const TriangleMesh& mesh, const Vec3& from, const Vec3& up, int width, int height,
                     int margin);

/// One entry per pixel, row by row from the top.
struct VisibleSurface {
  static constexpr std::uint32_t kNothing = 0xffffffffu;
  struct Pixel {
    std::uint32_t triangle = kNothing;
    float barycentric[3] = {0, 0, 0};
  };
  int width = 0, height = 0;
  std::vector<Pixel> pixels;
};

/// O(triangles + covered pixels); the nearest triangle wins, the lowest index among equals. Both sides are
/// seen.
VisibleSurface rasterize(const TriangleMesh& mesh, const Camera& camera, int width, int height);

}  // namespace nmc

#endif  // NMC_ENCODER_RENDER_RASTERIZER_H_
