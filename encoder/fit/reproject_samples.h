// SPDX-License-Identifier: Apache-2.0
// New correspondences for the samples of a surface that has moved: the closest point of the input, where it
// is trustworthy.
//
// Based on: Besl, McKay, A method for registration of 3-D shapes, 1992; the compatibility test on normals and
// the limit on distance are those of Rusinkiewicz, Levoy, Efficient variants of the ICP algorithm, 2001.
#ifndef NMC_ENCODER_FIT_REPROJECT_SAMPLES_H_
#define NMC_ENCODER_FIT_REPROJECT_SAMPLES_H_

#include <cstddef>
#include <vector>

#include "encoder/normal_mesh/surface_samples.h"
#include "encoder/spatial/surface_index.h"
#include "libnmc/common/subdivision.h"

namespace nmc {

/// What the fit needs to know of the input.
struct InputSurface {
  const SurfaceIndex& index;
  const std::vector<Vec3>& vertex_normals;  // unit, of the index's vertices
  /// Beside a crease the mean of both sides is the normal of neither: there a triangle's own normal counts.
  bool has_creases = false;
};

struct ReprojectionOptions {
  /// A sample keeps its target when its new normal turns away from the old one by more than this cosine.
  double minimum_normal_cosine = 0.3;
  /// Every n-th sample only (0 and 1: all). The others keep their targets.
  int stride = 1;
};

struct ReprojectionResult {
  std::size_t moved = 0, kept = 0;
  double mean_move = 0;
};

/// The closest point is never farther than the old target, so the search is bounded by the present distance.
/// O(samples log triangles), parallel.
ReprojectionResult reproject_samples(const InputSurface& input, const LevelTopology& finest,
                                     const std::vector<Vec3>& positions, const ReprojectionOptions& options,
                                     std::vector<SurfaceSample>& samples);

/// What samples on the moving surface cannot see: points of the input that it does not reach, like the tip of
/// an ear cut short. Takes `count` area-uniform points of the input and appends to `samples` one sample for
/// each of them that lies farther than `minimum_distance` from the surface, at its closest point there, along
/// the line that joins them; all of them together would weigh `total_weight`. Returns the number appended.
/// O((faces + count) log faces).
std::size_t append_input_samples(const InputSurface& input, const LevelTopology& finest,
                                 const std::vector<Vec3>& positions, std::size_t count, double total_weight,
                                 double minimum_distance, std::vector<SurfaceSample>& samples);

/// Samples on the faces of a level as samples on the faces of the next finer one: same parameter, so with the
/// finest level one deeper than the coded ones the fit is made for what a smoothing decoder shows.
std::vector<SurfaceSample> samples_on_next_level(const std::vector<SurfaceSample>& samples);

}  // namespace nmc

#endif  // NMC_ENCODER_FIT_REPROJECT_SAMPLES_H_
