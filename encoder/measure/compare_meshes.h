// SPDX-License-Identifier: Apache-2.0
// The single measure of the project: how far two surfaces are apart, both ways.
//
// Based on: Cignoni, Rocchini, Scopigno, "Metro: measuring error on simplified surfaces", 1998 (two one-sided
// samplings), with exact point-to-triangle distances and a deterministic low-discrepancy sampling.
//
// What is measured, for each direction (from a source surface to a target surface):
//  - the distances d of n area-uniform points of the source to the nearest point of the target: the RMS and
//  the
//    mean are means of d^2 and d over these points, which approximate integrals over the source's area;
//  - the distances of all vertices of the source that a triangle uses: they count for the maximum only,
//  because
//    their density says nothing about area.
// The maximum over points and vertices is called "Hausdorff" elsewhere; it is a measurement from below, since
// the true maximum may lie between the points. The symmetric figure is always the larger of the two one-sided
// ones.
#ifndef NMC_ENCODER_MEASURE_COMPARE_MESHES_H_
#define NMC_ENCODER_MEASURE_COMPARE_MESHES_H_

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "encoder/core/triangle_mesh.h"
#include "encoder/spatial/surface_index.h"

namespace nmc {

/// Points that a measurement takes on a source of so many triangles unless it is told otherwise.
inline std::size_t usual_sample_count(std::size_t triangle_count) {
  return std::max<std::size_t>(200'000, 2 * triangle_count);
}

struct CompareOptions {
  /// Area-uniform points per direction; 0: usual_sample_count() of the source.
  std::size_t sample_count = 0;
  bool original_to_result = true;
  bool result_to_original = true;
  /// Also measure the vertices (for the maximum).
  bool vertices = true;
  /// Angles between the triangle normals at each point and its nearest point.
  bool normals = true;
  /// Where both meshes have colours.
  bool colors = true;
  /// D1 and D2 of MPEG's mesh metric with this many grid lines along the longest side (MPEG: 1024); 0: not.
  int mpeg_grid = 0;
  /// An index of the original, when the caller compares many results with it. Must hold the same triangles.
  const SurfaceIndex* original_index = nullptr;
};

/// Distances in units of the meshes; angles in degrees.
struct OneSidedDistance {
  double rms = 0;
  double mean = 0;
  double maximum = 0;
  Vec3 maximum_at;  // the point of the source where it was found
  double normal_mean_degrees = 0;
  double normal_rms_degrees = 0;
  double luma_mean_squared = 0;  // of 8-bit sRGB values, luma as BT.709
  double rgb_mean_squared = 0;   // mean over the three channels
  std::size_t sample_count = 0;
  std::size_t vertex_count = 0;
};

struct PointCloudPsnr {
  double point_to_point_db = 0;  // D1
  double point_to_plane_db = 0;  // D2
  std::size_t original_points = 0, result_points = 0;
};

struct CompareResult {
  OneSidedDistance original_to_result, result_to_original;
  double diagonal = 0;                    // of the original's bounding box; "relative" means divided by it
  double rms = 0, mean = 0, maximum = 0;  // the larger of the two sides
  double normal_mean_degrees = 0, normal_rms_degrees = 0;
  /// The result's triangles are turned the other way round (mean angle above 90 degrees); the angles above
  /// are then those of the turned result.
  bool orientation_reversed = false;

  /// Enclosed volumes; only where the area vectors cancel out, so that a volume exists.
  std::optional<double> original_volume, result_volume;
  std::optional<double> luma_psnr_db, rgb_psnr_db;
  std::optional<PointCloudPsnr> mpeg;

  double relative_rms() const { return rms / diagonal; }
  double relative_mean() const { return mean / diagonal; }
  double relative_maximum() const { return maximum / diagonal; }
  /// 20 log10(diagonal / rms); infinite for equal surfaces.
  double psnr_db() const;
};

/// Compares two surfaces. Same input, same result, for any number of threads. Throws Error(kInvalidInput)
/// where a mesh has no triangles. Where a mesh has no area its vertices stand for its samples. O((samples +
/// vertices) log triangles); with an index of the original given, only the result is indexed.
CompareResult compare_meshes(const TriangleMesh& original, const TriangleMesh& result,
                             const CompareOptions& options = {});

/// The distance of every vertex of `mesh` to the indexed surface, in units. The input of error colour maps.
std::vector<double> vertex_distances(const TriangleMesh& mesh, const SurfaceIndex& index);

}  // namespace nmc

#endif  // NMC_ENCODER_MEASURE_COMPARE_MESHES_H_
