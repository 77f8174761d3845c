// SPDX-License-Identifier: Apache-2.0
#include "encoder/normal_mesh/closest_samples.h"

#include <algorithm>
#include <cmath>

#include "encoder/core/parallel.h"

namespace nmc {

std::vector<SurfaceSample> closest_samples(const SurfaceIndex& input, const LevelTopology& level,
                                           const std::vector<Vec3>& positions, std::size_t sample_count) {
  constexpr double kLeastAgreement = 0.3, kDoubtfulWeight = 0.02;
  const double per_face = static_cast<double>(sample_count) / std::max<double>(level.face_count, 1);
  const auto side = static_cast<std::size_t>(std::clamp(std::ceil(std::sqrt(per_face)), 3.0, 40.0));
  const std::size_t each = side * side;
  std::vector<SurfaceSample> samples(level.face_count * each);
  parallel_for(level.face_count, [&](std::size_t f) {
    const std::uint32_t* corners = level.face_vertices.data() + 3 * f;
    const Vec3 &a = positions[corners[0]], &b = positions[corners[1]], &c = positions[corners[2]];
    const Vec3 doubled = cross(b - a, c - a);
    const double area = 0.5 * norm(doubled);
    SurfaceSample* sample = samples.data() + f * each;
    // Centres of the side^2 triangles into which parallels to the edges cut the face: row i holds 2 i + 1 of them.
    for (std::size_t i = 0; i < side; ++i) {
      for (std::size_t j = 0; j < 2 * i + 1; ++j, ++sample) {
        const double third = j % 2 == 0 ? 1.0 / 3 : 2.0 / 3, n = static_cast<double>(side);
        const double v = (static_cast<double>(j / 2) + third) / n;
        const double u = 1 - (static_cast<double>(i) + (j % 2 == 0 ? 2.0 / 3 : 1.0 / 3)) / n;
        const double w = 1 - u - v;
        sample->face = static_cast<std::uint32_t>(f);
        sample->barycentric[0] = static_cast<float>(u);
        sample->barycentric[1] = static_cast<float>(v);
        sample->barycentric[2] = static_cast<float>(w);
        const SurfacePoint hit = input.closest_point(u * a + v * b + w * c);
        const Triangle& t = input.triangles()[hit.triangle];
        const Vec3& p = input.positions()[t[0]];
        sample->target = hit.position;
        sample->normal = normalized(cross(input.positions()[t[1]] - p, input.positions()[t[2]] - p), normalized(doubled));
        const bool agrees = dot(sample->normal, doubled) > kLeastAgreement * 2 * area;
        sample->weight = static_cast<float>((agrees ? 1 : kDoubtfulWeight) * area / static_cast<double>(each));
      }
    }
  });
  return samples;
}

}  // namespace nmc
