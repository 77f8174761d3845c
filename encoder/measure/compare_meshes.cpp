// SPDX-License-Identifier: Apache-2.0
#include "encoder/measure/compare_meshes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "encoder/core/error.h"
#include "encoder/core/parallel.h"
#include "encoder/measure/area_samples.h"
#include "encoder/measure/mpeg_point_metric.h"

namespace nmc {
namespace {

// Points of one block are visited in order so that each starts from the previous one's distance.
constexpr std::size_t kPointsPerBlock = 1024;

double degrees_between(const Vec3& a, const Vec3& b) {
  return std::atan2(norm(cross(a, b)), dot(a, b)) * (180 / std::numbers::pi);
}

Vec3 scaled_normal(const std::vector<Vec3>& positions, const Triangle& triangle) {
  const Vec3& a = positions[triangle[0]];
  return cross(positions[triangle[1]] - a, positions[triangle[2]] - a);
}

struct Rgb {
  double channel[3];
  double luma() const { return 0.2126 * channel[0] + 0.7152 * channel[1] + 0.0722 * channel[2]; }
};

Rgb interpolated_color(const TriangleMesh& mesh, std::uint32_t triangle, const double barycentric[3]) {
  Rgb color{};
  for (int corner = 0; corner < 3; ++corner) {
    const auto& at_corner = mesh.colors[mesh.triangles[triangle][corner]];
    for (int i = 0; i < 3; ++i) color.channel[i] += barycentric[corner] * at_corner[i];
  }
  return color;
}

// Nearest points for a walk along a surface: the previous answer bounds the next one by the triangle
// inequality, so the search starts with a small sphere. The answer itself does not depend on the bound.
class ClosestPointWalk {
 public:
  explicit ClosestPointWalk(const SurfaceIndex& index) : index_(index) {}

  SurfacePoint step(const Vec3& point) {
    SurfacePoint nearest;
    if (last_.found()) {
      const double bound = distance(point, last_.position) * (1 + 1e-9);
      nearest = index_.closest_point(point, bound);
    }
    if (!nearest.found()) nearest = index_.closest_point(point);
    last_ = nearest;
    return nearest;
  }

 private:
  const SurfaceIndex& index_;
  SurfacePoint last_;
};

struct Sums {
  double distance_squared = 0, distance = 0;
  double maximum = -1;
  Vec3 maximum_at;
  double angle = 0, angle_squared = 0;
  std::size_t angle_count = 0;
  double luma_squared = 0, rgb_squared = 0;

  void note_maximum(double value, const Vec3& at) {
    if (value <= maximum) return;
    maximum = value;
    maximum_at = at;
  }
  void add_distance(double value, const Vec3& at) {
    distance_squared += value * value;
    distance += value;
    note_maximum(value, at);
  }
  // Triangles without area have no normal and do not count.
  void add_angle(const Vec3& from_normal, const Vec3& to_normal) {
    if (from_normal == Vec3{} || to_normal == Vec3{}) return;
    const double degrees = degrees_between(from_normal, to_normal);
    angle += degrees;
    angle_squared += degrees * degrees;
    ++angle_count;
  }
  void add_color(const Rgb& a, const Rgb& b) {
    const double luma = a.luma() - b.luma();
    luma_squared += luma * luma;
    for (int i = 0; i < 3; ++i) {
      const double difference = a.channel[i] - b.channel[i];
      rgb_squared += difference * difference / 3;
    }
  }
  Sums& operator+=(const Sums& other) {
    distance_squared += other.distance_squared;
    distance += other.distance;
    note_maximum(other.maximum, other.maximum_at);
    angle += other.angle;
    angle_squared += other.angle_squared;
    angle_count += other.angle_count;
    luma_squared += other.luma_squared;
    rgb_squared += other.rgb_squared;
    return *this;
  }
};

std::vector<std::uint32_t> used_vertices(const TriangleMesh& mesh) {
  std::vector<std::uint8_t> used(mesh.vertex_count(), 0);
  for (const Triangle& triangle : mesh.triangles) {
    for (const std::uint32_t corner : triangle) used[corner] = 1;
  }
  std::vector<std::uint32_t> vertices;
  for (std::uint32_t v = 0; v < used.size(); ++v) {
    if (used[v] != 0 && is_finite(mesh.positions[v])) vertices.push_back(v);
  }
  return vertices;
}

bool both_have_colors(const TriangleMesh& a, const TriangleMesh& b, const CompareOptions& options) {
  return options.colors && !a.colors.empty() && !b.colors.empty();
}

Sums measure_samples(const AreaSamples& samples, const TriangleMesh& source, const TriangleMesh& target,
                     const SurfaceIndex& target_index, const CompareOptions& options) {
  const bool colors = both_have_colors(source, target, options);
  return parallel_block_sum<Sums>(samples.size(), kPointsPerBlock, [&](std::size_t begin, std::size_t end) {
    Sums block;
    ClosestPointWalk walk(target_index);
    for (std::size_t i = begin; i < end; ++i) {
      const AreaSample sample = samples[i];
      const SurfacePoint nearest = walk.step(sample.position);
      block.add_distance(nearest.t, sample.position);
      if (options.normals) {
        block.add_angle(scaled_normal(source.positions, source.triangles[sample.triangle]),
                        scaled_normal(target.positions, target.triangles[nearest.triangle]));
      }
      if (colors) {
        block.add_color(interpolated_color(source, sample.triangle, sample.barycentric),
                        interpolated_color(target, nearest.triangle, nearest.barycentric));
      }
    }
    return block;
  });
}

// With a maximum already known, only what exceeds it is looked for: the sums stay zero.
Sums measure_vertices(const std::vector<std::uint32_t>& vertices, const TriangleMesh& source,
                      const SurfaceIndex& target_index, std::optional<double> known_maximum) {
  return parallel_block_sum<Sums>(vertices.size(), kPointsPerBlock, [&](std::size_t begin, std::size_t end) {
    Sums block;
    ClosestPointWalk walk(target_index);
    if (known_maximum) block.maximum = *known_maximum;
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3& point = source.positions[vertices[i]];
      if (known_maximum) {
        // Nearly every vertex is seen to be nearer than the farthest so far at its first triangle.
        if (!target_index.is_within(point, block.maximum))
          block.note_maximum(target_index.closest_point(point).t, point);
        continue;
      }
      block.add_distance(walk.step(point).t, point);
    }
    return block;
  });
}

OneSidedDistance one_sided(const TriangleMesh& source, const TriangleMesh& target,
                           const SurfaceIndex& target_index, const CompareOptions& options) {
  const std::size_t asked =
      options.sample_count != 0 ? options.sample_count : usual_sample_count(source.triangle_count());
  const AreaSamples samples(source.positions, source.triangles, asked);
  const bool has_area = samples.size() != 0;
  const Sums of_samples = measure_samples(samples, source, target, target_index, options);
  OneSidedDistance side;
  side.sample_count = samples.size();
  Sums of_vertices;
  if (options.vertices || !has_area) {
    const std::vector<std::uint32_t> vertices = used_vertices(source);
    side.vertex_count = vertices.size();
    of_vertices = measure_vertices(vertices, source, target_index,
                                   has_area ? std::optional(of_samples.maximum) : std::nullopt);
  }

  const Sums& means = has_area ? of_samples : of_vertices;
  const double count = static_cast<double>(has_area ? side.sample_count : side.vertex_count);
  side.rms = std::sqrt(means.distance_squared / count);
  side.mean = means.distance / count;
  const Sums& farthest = of_vertices.maximum > of_samples.maximum ? of_vertices : of_samples;
  side.maximum = farthest.maximum;
  side.maximum_at = farthest.maximum_at;
  if (of_samples.angle_count != 0) {
    const double angle_count = static_cast<double>(of_samples.angle_count);
    side.normal_mean_degrees = of_samples.angle / angle_count;
    side.normal_rms_degrees = std::sqrt(of_samples.angle_squared / angle_count);
  }
  if (has_area && both_have_colors(source, target, options)) {
    side.luma_mean_squared = of_samples.luma_squared / count;
    side.rgb_mean_squared = of_samples.rgb_squared / count;
  }
  return side;
}

// Mean and RMS of (180 - angle) from those of the angle.
void turn_normals(OneSidedDistance& side) {
  const double mean = side.normal_mean_degrees, rms = side.normal_rms_degrees;
  side.normal_mean_degrees = 180 - mean;
  side.normal_rms_degrees = std::sqrt(std::max(0.0, 180.0 * 180.0 - 360.0 * mean + rms * rms));
}

// Of the finite vertices that a finite triangle uses; an empty box (minimum above maximum) where there is
// none.
BoundingBox finite_box(const TriangleMesh& mesh) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  BoundingBox box{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  for (const Triangle& triangle : mesh.triangles) {
    const Vec3 &a = mesh.positions[triangle[0]], &b = mesh.positions[triangle[1]],
               &c = mesh.positions[triangle[2]];
    if (!is_finite(a) || !is_finite(b) || !is_finite(c)) continue;
    for (int i = 0; i < 3; ++i) {
      box.minimum[i] = std::min({box.minimum[i], a[i], b[i], c[i]});
      box.maximum[i] = std::max({box.maximum[i], a[i], b[i], c[i]});
    }
  }
  return box;
}

// A volume exists independently of the origin exactly when the triangles' area vectors cancel out.
std::optional<double> enclosed_volume(const TriangleMesh& mesh) {
  const Vec3 origin = finite_box(mesh).center();
  struct Terms {
    Vec3 area_vector;
    double area = 0, volume = 0;
    Terms& operator+=(const Terms& other) {
      area_vector += other.area_vector;
      area += other.area;
      volume += other.volume;
      return *this;
    }
  };
  const Terms total = parallel_sum<Terms>(mesh.triangle_count(), [&](std::size_t t) {
    const Vec3 a = mesh.positions[mesh.triangles[t][0]] - origin;
    const Vec3 b = mesh.positions[mesh.triangles[t][1]] - origin;
    const Vec3 c = mesh.positions[mesh.triangles[t][2]] - origin;
    const Vec3 area_vector = 0.5 * cross(b - a, c - a);
    return Terms{area_vector, norm(area_vector), dot(a, cross(b, c)) / 6};
  });
  if (!(norm(total.area_vector) <= 1e-9 * total.area)) return std::nullopt;
  return total.volume;
}

std::optional<double> color_psnr(bool measured, double mean_squared) {
  if (!measured) return std::nullopt;
  return 10 * std::log10(255.0 * 255.0 / mean_squared);
}

}  // namespace

double CompareResult::psnr_db() const { return 20 * std::log10(diagonal / rms); }

CompareResult compare_meshes(const TriangleMesh& original, const TriangleMesh& result,
                             const CompareOptions& options) {
  const BoundingBox original_box = finite_box(original), result_box = finite_box(result);
  if (original_box.minimum.x > original_box.maximum.x) {
    throw Error(ExitCode::kInvalidInput, "the original has no triangles to measure");
  }
  if (result_box.minimum.x > result_box.maximum.x) {
    throw Error(ExitCode::kInvalidInput, "the result has no triangles to measure");
  }

  CompareResult comparison;
  comparison.diagonal = original_box.diagonal();
  OneSidedDistance& forward = comparison.original_to_result;
  OneSidedDistance& backward = comparison.result_to_original;
  if (options.original_to_result) forward = one_sided(original, result, SurfaceIndex(result), options);
  if (options.result_to_original) {
    std::optional<SurfaceIndex> own_index;
    if (options.original_index == nullptr) own_index.emplace(original);
    backward = one_sided(result, original, own_index ? *own_index : *options.original_index, options);
  }

  const double mean_angle = std::max(forward.normal_mean_degrees, backward.normal_mean_degrees);
  comparison.orientation_reversed = mean_angle > 90;
  if (comparison.orientation_reversed) {
    if (options.original_to_result) turn_normals(forward);
    if (options.result_to_original) turn_normals(backward);
  }
  comparison.rms = std::max(forward.rms, backward.rms);
  comparison.mean = std::max(forward.mean, backward.mean);
  comparison.maximum = std::max(forward.maximum, backward.maximum);
  comparison.normal_mean_degrees = std::max(forward.normal_mean_degrees, backward.normal_mean_degrees);
  comparison.normal_rms_degrees = std::max(forward.normal_rms_degrees, backward.normal_rms_degrees);
  comparison.original_volume = enclosed_volume(original);
  comparison.result_volume = enclosed_volume(result);
  const bool colors = both_have_colors(original, result, options);
  comparison.luma_psnr_db =
      color_psnr(colors, std::max(forward.luma_mean_squared, backward.luma_mean_squared));
  comparison.rgb_psnr_db = color_psnr(colors, std::max(forward.rgb_mean_squared, backward.rgb_mean_squared));
  if (options.mpeg_grid > 0) comparison.mpeg = mpeg_point_metric(original, result, options.mpeg_grid);
  return comparison;
}

std::vector<double> vertex_distances(const TriangleMesh& mesh, const SurfaceIndex& index) {
  std::vector<double> distances(mesh.vertex_count());
  parallel_for(mesh.vertex_count(),
               [&](std::size_t v) { distances[v] = index.closest_point(mesh.positions[v]).t; });
  return distances;
}

}  // namespace nmc
