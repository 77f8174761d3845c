// SPDX-License-Identifier: Apache-2.0
#include "encoder/fit/reproject_samples.h"

#include <algorithm>
#include <cmath>

#include "encoder/core/parallel.h"
#include "encoder/measure/area_samples.h"

namespace nmc {

namespace {

/// Interpolated normals that turn away from their triangle by more than this (cosine of 26 degrees) are not smooth.
constexpr double kSmoothCosine = 0.9;

}  // namespace

ReprojectionResult reproject_samples(const InputSurface& input, const LevelTopology& finest,
                                     const std::vector<Vec3>& positions, const ReprojectionOptions& options,
                                     std::vector<SurfaceSample>& samples) {
  struct Tally {
    std::size_t moved = 0, kept = 0;
    double distance = 0;
    Tally& operator+=(const Tally& t) {
      moved += t.moved;
      kept += t.kept;
      distance += t.distance;
      return *this;
    }
  };
  const std::size_t stride = options.stride > 1 ? static_cast<std::size_t>(options.stride) : 1;
  const std::size_t count = (samples.size() + stride - 1) / stride;
  const Tally tally = parallel_sum<Tally>(count, [&](std::size_t i) {
    SurfaceSample& sample = samples[stride * i];
    const std::uint32_t* corners = finest.face_vertices.data() + std::size_t{3} * sample.face;
    Vec3 y;
    for (int k = 0; k < 3; ++k) y += static_cast<double>(sample.barycentric[k]) * positions[corners[k]];
    const double present = distance(y, sample.target);
    const SurfacePoint hit = input.index.closest_point(y, present * (1 + 1e-9));
    if (!hit.found()) return Tally{0, 1, 0};
    const Triangle& t = input.index.triangles()[hit.triangle];
    Vec3 normal;
    for (std::size_t k = 0; k < 3; ++k) normal += hit.barycentric[k] * input.vertex_normals[t[k]];
    normal = normalized(normal, sample.normal);
    if (input.has_creases) {
      const Vec3& corner = input.index.positions()[t[0]];
      const Vec3 own = normalized(
          cross(input.index.positions()[t[1]] - corner, input.index.positions()[t[2]] - corner), normal);
      if (dot(normal, own) < kSmoothCosine) normal = own;
    }
    if (dot(normal, sample.normal) < options.minimum_normal_cosine) return Tally{0, 1, 0};
    const double move = distance(hit.position, sample.target);
    sample.target = hit.position;
    sample.normal = normal;
    return Tally{1, 0, move};
  });
  return {tally.moved, tally.kept, tally.moved ? tally.distance / static_cast<double>(tally.moved) : 0};
}

std::size_t append_input_samples(const InputSurface& input, const LevelTopology& finest,
                                 const std::vector<Vec3>& positions, std::size_t count, double total_weight,
                                 double minimum_distance, std::vector<SurfaceSample>& samples) {
  std::vector<Triangle> triangles(finest.face_count);
  for (std::size_t f = 0; f < triangles.size(); ++f)
    for (std::size_t k = 0; k < 3; ++k) triangles[f][k] = finest.face_vertices[3 * f + k];
  const SurfaceIndex surface(positions, triangles);
  const AreaSamples points(input.index.positions(), input.index.triangles(), count);
  std::vector<SurfaceSample> found(points.size());
  const double weight = points.size() ? total_weight / static_cast<double>(points.size()) : 0;
  parallel_for(points.size(), [&](std::size_t i) {
    const Vec3 point = points[i].position;
    found[i].weight = 0;
    if (surface.is_within(point, minimum_distance)) return;
    const SurfacePoint hit = surface.closest_point(point);
    if (!hit.found()) return;
    found[i].face = hit.triangle;
    for (int k = 0; k < 3; ++k) found[i].barycentric[k] = static_cast<float>(hit.barycentric[k]);
    found[i].target = point;
    found[i].normal = normalized(point - hit.position);
    found[i].weight = static_cast<float>(weight);
  });
  const std::size_t before = samples.size();
  for (const SurfaceSample& sample : found)
    if (sample.weight > 0) samples.push_back(sample);
  return samples.size() - before;
}

std::vector<SurfaceSample> samples_on_next_level(const std::vector<SurfaceSample>& samples) {
  std::vector<SurfaceSample> result = samples;
  parallel_for(result.size(), [&](std::size_t i) {
    SurfaceSample& s = result[i];
    float* b = s.barycentric;
    for (std::uint32_t k = 0; k < 3; ++k) {
      if (b[k] < 0.5f) continue;
      // Child k keeps corner k; its other corners are the midpoints of the two edges there.
      s.face = 4 * s.face + k;
      for (std::uint32_t j = 0; j < 3; ++j) b[j] = j == k ? 2 * b[j] - 1 : 2 * b[j];
      return;
    }
    s.face = 4 * s.face + 3;  // corners are the midpoints opposite to the corners
    for (int j = 0; j < 3; ++j) b[j] = 1 - 2 * b[j];
  });
  return result;
}

}  // namespace nmc
