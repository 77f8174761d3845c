// SPDX-License-Identifier: Apache-2.0
#include "encoder/normal_mesh/sample_correspondences.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "encoder/core/parallel.h"
#include "encoder/normal_mesh/quadrature.h"

namespace nmc {

namespace {

struct Counts {
  std::size_t replaced = 0, doubtful = 0;
  Counts& operator+=(const Counts& other) {
    replaced += other.replaced;
    doubtful += other.doubtful;
    return *this;
  }
};

/// The corners of one face and what is derived from them.
struct FaceFrame {
  Vec3 corners[3];
  Vec3 normal;
  double area = 0, longest_edge = 0;

  FaceFrame(const LevelTopology& topology, std::uint32_t face, std::span<const Vec3> positions) {
    for (std::uint32_t k = 0; k < 3; ++k) corners[k] = positions[topology.face_vertices[3 * face + k]];
    const Vec3 doubled = cross(corners[1] - corners[0], corners[2] - corners[0]);
    area = 0.5 * norm(doubled);
    normal = normalized(doubled, {0, 0, 0});
    for (int k = 0; k < 3; ++k)
      longest_edge = std::max(longest_edge, distance(corners[k], corners[(k + 1) % 3]));
  }
  Vec3 point(const std::array<double, 3>& b) const {
    return b[0] * corners[0] + b[1] * corners[1] + b[2] * corners[2];
  }
  /// A face without area has no normal to compare.
  bool agrees(const Vec3& n, double least) const { return area == 0 || dot(n, normal) >= least; }
};

SurfaceLocation location_of(const SurfacePoint& point) {
  return {point.triangle, {point.barycentric[0], point.barycentric[1], point.barycentric[2]}};
}

void scale_weights(double factor, std::vector<SurfaceSample>& samples) {
  parallel_for(samples.size(),
               [&](std::size_t i) { samples[i].weight = static_cast<float>(samples[i].weight * factor); });
}

/// Replaces the target by the input's closest point; true where that one cannot be trusted either.
bool take_closest_point(const ParameterizedSurface& map, const SurfaceIndex& index, const FaceFrame& face,
                        const Vec3& own, const SamplingOptions& options, SurfaceSample& sample) {
  const SurfacePoint closest = index.closest_point(own);
  sample.target = closest.position;
  sample.normal = map.smooth_normal(location_of(closest));
  return !face.agrees(sample.normal, options.least_normal_agreement);
}

template <class Sampler>
std::vector<SurfaceSample> sample_faces(const LevelTopology& topology, const SamplingOptions& options,
                                        SampleStatistics* statistics, const Sampler& sample_face) {
  const auto centroids = sub_triangle_centroids(std::clamp(options.subdivisions, 1, 16));
  std::vector<SurfaceSample> samples(centroids.size() * topology.face_count);
  std::vector<Counts> counts(topology.face_count);
  parallel_for(topology.face_count, [&](std::size_t face) {
    counts[face] =
        sample_face(static_cast<std::uint32_t>(face), centroids, samples.data() + face * centroids.size());
  });
  if (statistics) {
    Counts total;
    for (const Counts& c : counts) total += c;
    *statistics = {samples.size(), total.replaced, total.doubtful};
  }
  return samples;
}

}  // namespace

std::vector<SurfaceSample> sample_correspondences(const ParameterizedSurface& map, const SurfaceIndex& index,
                                                  const LevelTopology& topology, int level,
                                                  std::span<const Vec3> positions,
                                                  std::span<const SurfaceParameter> parameters,
                                                  const SamplingOptions& options,
                                                  SampleStatistics* statistics) {
  const double mesh_area = parallel_sum<double>(topology.face_count, [&](std::size_t face) {
    return FaceFrame(topology, static_cast<std::uint32_t>(face), positions).area;
  });
  const double input_area = surface_area(map.surface());
  const double mesh_share = options.weighting == SampleWeighting::kMesh    ? 1.0
                            : options.weighting == SampleWeighting::kInput ? 0.0
                                                                           : 0.5;
  std::vector<std::uint8_t> is_doubtful;
  const std::size_t per_face = sub_triangle_centroids(std::clamp(options.subdivisions, 1, 16)).size();
  is_doubtful.assign(per_face * topology.face_count, 0);
  auto samples = sample_faces(
      topology, options, statistics,
      [&](std::uint32_t face, const std::vector<std::array<double, 3>>& centroids, SurfaceSample* out) {
        Counts counts;
        const FaceFrame frame(topology, face, positions);
        SurfaceParameter corners[3];
        for (std::uint32_t k = 0; k < 3; ++k) corners[k] = parameters[topology.face_vertices[3 * face + k]];
        LocalChart chart;
        ChartPoint at[3];
        const bool laid_out = map.make_chart(face >> (2 * level), corners, chart, at);
        const double chart_area = laid_out ? 0.5 * face_ratio(at[0], at[1], at[2]) : 0;
        const double share = 1.0 / static_cast<double>(centroids.size());
        const double mesh_weight = mesh_area > 0 ? share * frame.area / mesh_area : 0;
        for (std::size_t i = 0; i < centroids.size(); ++i) {
          const auto& b = centroids[i];
          SurfaceSample& sample = out[i];
          sample.face = face;
          for (int k = 0; k < 3; ++k) sample.barycentric[k] = static_cast<float>(b[k]);
          const Vec3 own = frame.point(b);
          double input_weight = mesh_weight;
          bool trusted = laid_out;
          if (laid_out) {
            const SurfaceLocation location =
                map.locate(map.from_chart(chart, (b[0] * at[0] + b[1] * at[1]) + b[2] * at[2]));
            sample.target = map.position(location);
            sample.normal = map.smooth_normal(location);
            trusted = distance(own, sample.target) <= options.farthest_in_edges * frame.longest_edge &&
                      frame.agrees(sample.normal, options.least_normal_agreement);
            if (trusted && mesh_share < 1)
              input_weight = share * chart_area * map_stretch(map, chart, location.triangle) / input_area;
          }
          if (!trusted) {
            ++counts.replaced;
            if (take_closest_point(map, index, frame, own, options, sample)) {
              ++counts.doubtful;
              is_doubtful[std::size_t{face} * centroids.size() + i] = 1;
            }
          }
          sample.weight = static_cast<float>(mesh_share * mesh_weight + (1 - mesh_share) * input_weight);
        }
        return counts;
      });
  const double total =
      parallel_sum<double>(samples.size(), [&](std::size_t i) { return double{samples[i].weight}; });
  if (total > 0) scale_weights(1 / total, samples);
  parallel_for(samples.size(), [&](std::size_t i) {
    if (is_doubtful[i]) samples[i].weight *= static_cast<float>(options.doubtful_weight);
  });
  return samples;
}

std::vector<SurfaceSample> sample_closest_points(const ParameterizedSurface& map, const SurfaceIndex& index,
                                                 const LevelTopology& topology,
                                                 std::span<const Vec3> positions,
                                                 const SamplingOptions& options,
                                                 SampleStatistics* statistics) {
  const double mesh_area = parallel_sum<double>(topology.face_count, [&](std::size_t face) {
    return FaceFrame(topology, static_cast<std::uint32_t>(face), positions).area;
  });
  return sample_faces(
      topology, options, statistics,
      [&](std::uint32_t face, const std::vector<std::array<double, 3>>& centroids, SurfaceSample* out) {
        Counts counts;
        const FaceFrame frame(topology, face, positions);
        const double weight =
            mesh_area > 0 ? frame.area / (mesh_area * static_cast<double>(centroids.size())) : 0;
        for (std::size_t i = 0; i < centroids.size(); ++i) {
          SurfaceSample& sample = out[i];
          sample.face = face;
          for (int k = 0; k < 3; ++k) sample.barycentric[k] = static_cast<float>(centroids[i][k]);
          sample.weight = static_cast<float>(weight);
          ++counts.replaced;
          if (take_closest_point(map, index, frame, frame.point(centroids[i]), options, sample)) {
            ++counts.doubtful;
            sample.weight *= static_cast<float>(options.doubtful_weight);
          }
        }
        return counts;
      });
}

}  // namespace nmc
