// SPDX-License-Identifier: Apache-2.0
// Rate-distortion coordinate descent on the integers of one level.
//
// Minimises J = D + lambda R over one level's integers, all others held fixed: D by the exact quadratic
// (gradient of the whole mesh and the Galerkin interactions between the level's coefficients), R by a rate
// model that charges a change with its effect on neighbouring contexts. Each accepted change lowers J; the
// gradient of the neighbours is updated at once, so a coefficient that goes to zero is taken over by those
// around it.
//
// Based on: Ramchandran, Vetterli, Rate-distortion optimal fast thresholding, IEEE TIP 3(5), 1994; Wen,
// Luthra, Joint optimization of run-length coding, Huffman coding and quantization, 2000 (trellis-free
// coefficient decisions).
#ifndef NMC_ENCODER_FIT_COORDINATE_DESCENT_H_
#define NMC_ENCODER_FIT_COORDINATE_DESCENT_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "encoder/fit/fit_system.h"
#include "encoder/fit/rate_model.h"

namespace nmc {

struct DescentOptions {
  double lambda = 0;  // energy per bit
  int maximum_sweeps = 3;
};

/// Changes `field` (and the state of `rates`) on `level`. `dual` is the gradient of the energy in all
/// unknowns at the field's mesh, whose directions are frozen in the system. Returns the number of changes.
/// Serial, in edge order.
std::size_t descend_level(FitSystem& system, int level, double step, const std::vector<double>& dual,
                          const DescentOptions& options, RateModel& rates, CoefficientField& field);

/// The same for the coordinates of the base vertices. Their bits depend little on a step more or less, so the
/// first layer takes the best grid points; with `previous` (the coordinates of the previous layer on the
/// present grid) corrections are charged.
std::size_t descend_base(FitSystem& system, double step, const std::vector<double>& dual,
                         const DescentOptions& options,
                         const std::vector<std::array<std::int32_t, 3>>* previous,
                         std::vector<std::array<std::int32_t, 3>>& coordinates);

}  // namespace nmc

#endif  // NMC_ENCODER_FIT_COORDINATE_DESCENT_H_
