// SPDX-License-Identifier: Apache-2.0
// The closed loop without a fit: an interpolating normal mesh that is quantized while it grows.
//
// Every level is pierced from the vertices that a decoder has, so what rounding did to coarser levels is
// seen, and made good, by the finer ones; only the last level's own rounding stays. No system of equations is
// solved: each vertex looks at the surface around itself and nothing else. (The global fit of global_fit.h
// and quantize.h does better; this is what it is measured against.)
//
// Based on: Friedel, "Approximation of Surfaces by Normal Meshes" (thesis), Figure 2.5, with the quantizer in
// the loop.
#ifndef NMC_ENCODER_FIT_CLOSED_LOOP_H_
#define NMC_ENCODER_FIT_CLOSED_LOOP_H_

#include "encoder/fit/quantize.h"
#include "encoder/normal_mesh/interpolating_normal_mesh.h"

namespace nmc {

struct ClosedLoopOptions {
  /// Coded levels, apertures, tension.
  InterpolatingOptions interpolating;
  /// Steps and dead zone: the fields that round_mesh.h names.
  QuantizeOptions quantize;
};

/// The mesh that a decoder has, in the numbering of `base`: its details are whole steps and its base vertices
/// lie on the grid, so that round_mesh() with the same options gives the integers, here or after renumbering.
/// `index` must hold map.surface(). Deterministic for any number of threads; about one ray per vertex.
NormalMesh quantize_closed_loop(const ParameterizedSurface& map, const SurfaceIndex& index,
                                const ParameterizedBase& base, const ClosedLoopOptions& options);

}  // namespace nmc

#endif  // NMC_ENCODER_FIT_CLOSED_LOOP_H_
