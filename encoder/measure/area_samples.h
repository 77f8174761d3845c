// SPDX-License-Identifier: Apache-2.0
// Deterministic points spread uniformly by area over a triangle mesh.
//
// Based on: systematic sampling along the cumulated area, and within the triangles the R2 sequence (Roberts,
// "The Unreasonable Effectiveness of Quasirandom Sequences", 2018) folded from the square to the triangle.
// Together the three coordinates form a low-discrepancy set, so a mean over n samples converges faster than
// n^(-1/2).
#ifndef NMC_ENCODER_MEASURE_AREA_SAMPLES_H_
#define NMC_ENCODER_MEASURE_AREA_SAMPLES_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "encoder/core/triangle_mesh.h"

namespace nmc {

struct AreaSample {
  std::uint32_t triangle = 0;
  double barycentric[3] = {1, 0, 0};  // >= 0, sum 1
  Vec3 position;
};

/// Sample i of n lies at (i + 1/2) / n of the cumulated area, in triangle order: a triangle of area A
/// receives n A / total samples, rounded down or up. Same mesh, same n: same samples. O(triangles) to
/// construct; the mesh must outlive the object.
class AreaSamples {
 public:
  AreaSamples(const std::vector<Vec3>& positions, const std::vector<Triangle>& triangles, std::size_t count);

  /// The number asked for; 0 where the mesh has no area at all.
  std::size_t size() const { return count_; }
  double total_area() const { return cumulated_area_.empty() ? 0 : cumulated_area_.back(); }

  /// O(log triangles).
  AreaSample operator[](std::size_t i) const;

 private:
  const std::vector<Vec3>& positions_;
  const std::vector<Triangle>& triangles_;
  std::vector<double> cumulated_area_;  // up to and including each triangle
  std::size_t count_;
};

}  // namespace nmc

#endif  // NMC_ENCODER_MEASURE_AREA_SAMPLES_H_
