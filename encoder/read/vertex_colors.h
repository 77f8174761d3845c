// SPDX-License-Identifier: Apache-2.0
// Vertex colours of any numeric kind to the bytes that TriangleMesh holds.
#ifndef NMC_ENCODER_READ_VERTEX_COLORS_H_
#define NMC_ENCODER_READ_VERTEX_COLORS_H_

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace nmc {

/// A sRGB byte from a value where `white` stands for full intensity; clamps, and takes NaN as black.
std::uint8_t color_byte(double value, double white);

/// Bytes from r g b triples in one common scale, which files do not state: it is 0..1 where no value is above
/// 1, else 0..255 where none is above 255, else 0..65535. (PLY float colours are 0..1 by custom but 0..255 in
/// files of several scanners, OBJ and OFF have both.) `rgb.size()` is a multiple of 3; `largest_opacity` is
/// the largest value of a fourth component in the same scale, which settles the matter for dark colours.
std::vector<std::array<std::uint8_t, 3>> colors_from_unscaled(std::span<const float> rgb,
                                                              float largest_opacity = 0);

/// True where any value is below zero: then the three values are no colours (some writers put normals there).
bool holds_negative(std::span<const float> rgb);

/// A sRGB byte from a linear intensity in [0, 1] (IEC 61966-2-1); clamps, and takes NaN as black.
std::uint8_t srgb_byte_from_linear(double linear);

}  // namespace nmc

#endif  // NMC_ENCODER_READ_VERTEX_COLORS_H_
