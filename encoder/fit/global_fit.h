// SPDX-License-Identifier: Apache-2.0
// The global fit: one scalar per vertex, chosen over all levels at once so that the finest surface is nearest
// to the input.
//
// A hierarchy of normal meshes has one scalar per vertex, but interpolating the input leaves the surface
// between the vertices where it falls. Minimising the distance level by level needs either a second set of
// coefficients for the vertices that move, or spoils the predictions of the next level. Here the scalars of
// all levels are the unknowns of one least-squares problem; directions are those the decoder will see, taken
// from the fitted coarser vertices. So the code stays critically sampled and the surface comes within a
// fraction of a decibel of unconstrained vectors.
//
// Based on: Friedel, Khodakovsky, Schroeder, Variational normal meshes, ACM TOG 23(4), 2004 (the problem per
// level).
#ifndef NMC_ENCODER_FIT_GLOBAL_FIT_H_
#define NMC_ENCODER_FIT_GLOBAL_FIT_H_

#include <vector>

#include "encoder/fit/fit_system.h"
#include "encoder/fit/reproject_samples.h"
#include "encoder/normal_mesh/normal_mesh.h"
#include "encoder/normal_mesh/surface_samples.h"

namespace nmc {

struct GlobalFitOptions {
  QuadraticEnergyOptions energy;
  MinimizeOptions minimize;
  ReprojectionOptions reprojection;
  /// Times the samples take the closest point of the fitted surface as their new target. Needs an input
  /// surface.
  int reprojection_count = 1;
  /// Points of the input farther than this many RMS distances from the fitted surface pull on it (with the
  /// last re-projection); 0: none do.
  double reach_multiple = 2;
  /// Coefficients exist below this level; -1: on all levels but the last. Deeper levels of the hierarchy are
  /// smoothing levels: predicted only, but the samples live on the last one.
  int coded_level_count = -1;
  /// Whether the tangential parts of non-normal vertices inside the surface move too. On boundaries and
  /// creases `across` always does.
  bool free_tangentials = true;
};

struct GlobalFitResult {
  double initial_rms = 0;  // point-to-plane over the samples, before and after; in units of the mesh
  double final_rms = 0;
  int outer = 0, inner = 0;
};

/// Where the unknowns of `mesh` live: tangential ones where the mesh is not normal, and on curves.
UnknownLayout unknown_layout(const NormalMesh& mesh, int coded_level_count);
/// The values of the unknowns, and back.
std::vector<double> values_of(const NormalMesh& mesh, const UnknownLayout& layout);
void store_values(const std::vector<double>& values, const UnknownLayout& layout, NormalMesh& mesh);
/// 1 for every unknown that the fit may move.
std::vector<std::uint8_t> free_unknowns(const NormalMesh& mesh, const UnknownLayout& layout,
                                        bool free_tangentials);

/// Fits `mesh` to the samples in place; `samples` are re-projected in place when `input` is given. The energy
/// never rises for any one set of correspondences. Throws Error(kInternal) on samples that do not belong to
/// the last level.
GlobalFitResult global_fit(const GlobalFitOptions& options, const InputSurface* input,
                           std::vector<SurfaceSample>& samples, NormalMesh& mesh);

}  // namespace nmc

#endif  // NMC_ENCODER_FIT_GLOBAL_FIT_H_
