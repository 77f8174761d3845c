// SPDX-License-Identifier: Apache-2.0
#include "encoder/normal_mesh/quadrature.h"

#include "encoder/core/parallel.h"

namespace nmc {

std::vector<std::array<double, 3>> sub_triangle_centroids(int k) {
  std::vector<std::array<double, 3>> centroids;
  for (int i = 0; i < k; ++i) {
    for (int j = 0; j < k - i; ++j) {
      for (int up = 0; up < (j == k - i - 1 ? 1 : 2); ++up) {
        const double third = up ? 2.0 / 3 : 1.0 / 3;
        const double b1 = (i + third) / k, b2 = (j + third) / k;
        centroids.push_back({(1 - b1) - b2, b1, b2});
      }
    }
  }
  return centroids;
}

double map_stretch(const ParameterizedSurface& map, const LocalChart& chart, std::uint32_t triangle) {
  ChartPoint c[3];
  for (int k = 0; k < 3; ++k) {
    SurfaceLocation corner{triangle, {0, 0, 0}};
    corner.barycentric[k] = 1;
    if (!map.to_chart(chart, corner, c[k])) return 0;
  }
  const double in_chart = face_ratio(c[0], c[1], c[2]);
  if (!(in_chart > 0)) return 0;
  const Triangle& t = map.surface().triangles[triangle];
  const Vec3& a = map.surface().positions[t[0]];
  return norm(cross(map.surface().positions[t[1]] - a, map.surface().positions[t[2]] - a)) / in_chart;
}

std::vector<FaceIntegrals> integrate_faces(const ParameterizedSurface& map, const LevelTopology& topology,
                                           int level, std::span<const Vec3> positions,
                                           std::span<const SurfaceParameter> parameters,
                                           const QuadratureOptions& options) {
  const auto centroids = sub_triangle_centroids(options.subdivisions_at(level));
  const double share = 1.0 / static_cast<double>(centroids.size());
  std::vector<FaceIntegrals> integrals(topology.face_count);
  parallel_for(topology.face_count, [&](std::size_t i) {
    const auto face = static_cast<std::uint32_t>(i);
    const std::uint32_t* v = topology.face_vertices.data() + 3 * i;
    const SurfaceParameter corners[3] = {parameters[v[0]], parameters[v[1]], parameters[v[2]]};
    LocalChart chart;
    ChartPoint at[3];
    if (!map.make_chart(face >> (2 * level), corners, chart, at)) return;
    FaceIntegrals& sums = integrals[i];
    double weight = share;
    if (options.weighting == AreaWeighting::kMesh) {
      const Vec3& a = positions[v[0]];
      weight = share * 0.5 * norm(cross(positions[v[1]] - a, positions[v[2]] - a));
    }
    const double chart_area = 0.5 * share * face_ratio(at[0], at[1], at[2]);
    for (const auto& b : centroids) {
      const ChartPoint u = (b[0] * at[0] + b[1] * at[1]) + b[2] * at[2];
      const SurfaceLocation location = map.locate(map.from_chart(chart, u));
      const Vec3 target = map.position(location);
      if (options.weighting == AreaWeighting::kInput)
        weight = chart_area * map_stretch(map, chart, location.triangle);
      for (std::size_t k = 0; k < 3; ++k) {
        sums.mass[k] += weight * b[k] * b[k];
        sums.mass[3 + k] += weight * b[(k + 1) % 3] * b[(k + 2) % 3];
        sums.load[k] += weight * b[k] * target;
      }
    }
  });
  return integrals;
}

}  // namespace nmc
