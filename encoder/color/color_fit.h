// SPDX-License-Identifier: Apache-2.0
// The colours at the vertices of a hierarchy's level that come nearest to those of the input.
//
// Colours taken at the vertices alone alias wherever the input is finer than the level, and averages over the
// vertices' cells blur. The best piecewise linear function in the mean square is neither: it is the L2
// projection, whose system is a mass matrix, well conditioned at any resolution (A. Wathen. Realistic
// eigenvalue bounds for the Galerkin mass matrix. IMA J. Numer. Anal. 7, 1987), so a few steps of conjugate
// gradients solve it.
#ifndef NMC_ENCODER_COLOR_COLOR_FIT_H_
#define NMC_ENCODER_COLOR_COLOR_FIT_H_

#include <array>
#include <cstdint>
#include <vector>

#include "encoder/core/triangle_mesh.h"
#include "encoder/spatial/surface_index.h"
#include "libnmc/common/subdivision.h"

namespace nmc {

/// Red, green, blue, 0 ... 255, sRGB.
using RgbValue = std::array<float, 3>;
using RgbByte = std::array<std::uint8_t, 3>;

/// The input's colours all over a decoded surface: four samples for each of its triangles.
struct ColorSamples {
  static constexpr std::size_t kPerTriangle = 4;

  /// `topology` is the level that is shown and `positions` its decoded vertices; vertex i of the surface that
  /// `input` indexes has the colour input_colors[i]. Every sample takes the colour of its closest point of
  /// the input. One query per sample; parallel, deterministic.
  ColorSamples(const LevelTopology& topology, const std::vector<Vec3>& positions, const SurfaceIndex& input,
               const std::vector<RgbByte>& input_colors);

  std::vector<std::array<RgbValue, kPerTriangle>> colors;  // per triangle, at sample_weights()
  std::vector<float> weights;                              // per triangle: area over mean area
};

class ColorFit {
 public:
  /// Piecewise linear functions on the level of `topology`, `levels_between` levels coarser than that of the
  /// samples and carried to it by midpoints. Both must outlive the object. O(samples).
  ColorFit(const ColorSamples& samples, const LevelTopology& topology, int levels_between);

  /// Per vertex, within 0 ... 255.
  std::vector<RgbValue> solve() const;

  /// Mean over area and the three channels of the squared difference between the samples and what `colors`
  /// interpolate.
  double mean_squared_error(const std::vector<RgbValue>& colors) const;

 private:
  using Sum = std::array<double, 3>;
  void multiply(const std::vector<Sum>& x, std::vector<Sum>& y) const;
  double scaled(std::size_t vertex, double value) const {
    return diagonal_[vertex] > 0 ? value / diagonal_[vertex] : 0;
  }

  const LevelTopology& topology_;
  std::vector<std::array<float, 6>> masses_;  // per face: products of the corners' weights: 00 11 22 01 02 12
  std::vector<Sum> right_side_;               // per vertex
  std::vector<double> diagonal_;              // per vertex
  double square_sum_ = 0;                     // of the samples, all channels
  double weight_sum_ = 0;
};

}  // namespace nmc

#endif  // NMC_ENCODER_COLOR_COLOR_FIT_H_
