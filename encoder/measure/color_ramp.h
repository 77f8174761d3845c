// SPDX-License-Identifier: Apache-2.0
// Error to colour: dark blue for none, over green, to yellow for the end of the scale, red beyond it.
//
// Based on: matplotlib's "viridis" (van der Walt, Smith 2015), by its own samples: brightness grows evenly
// with the value, so the map also reads in grey and for colour-blind eyes. Red is outside the ramp and marks
// overflow.
#ifndef NMC_ENCODER_MEASURE_COLOR_RAMP_H_
#define NMC_ENCODER_MEASURE_COLOR_RAMP_H_

#include <array>
#include <cstdint>

namespace nmc {

using RgbColor = std::array<std::uint8_t, 3>;  // sRGB

/// `value` 0 is the ramp's beginning and 1 its end; below 0 counts as 0, above 1 gives the overflow colour.
RgbColor ramp_color(double value);

/// A round number (1, 1.2, 1.6, 2, 2.4, 3, 4, 5, 6 or 8 times a power of ten, so that quarters of it are
/// short) not below `value`: the end of a legend. 1 for values <= 0.
double round_scale_end(double value);

}  // namespace nmc

#endif  // NMC_ENCODER_MEASURE_COLOR_RAMP_H_
