// SPDX-License-Identifier: Apache-2.0
// Rate-distortion optimised quantization of a fitted normal mesh, with the decoder in the loop.
//
// The steps grow towards the finest level, Delta_l = Delta s^(l - L + 1): the basis functions of coarse
// levels cover more surface. What is rounded or dropped on one level is made good by the others:
//   1. active set: coefficients below a threshold become zero and leave the system; the rest is solved again,
//   so that
//      coarse levels take over what died; correspondences follow the surface;
//   2. the base is rounded to its grid, then the levels coarse to fine, every time the finer ones are solved
//   again;
//   3. coordinate descent over the integers of all levels minimises J = D + lambda R with the exact
//   interactions; here
//      zeroed coefficients may come back and coarse ones may move.
//
// Based on: Khodakovsky, Guskov, Normal mesh compression, 2002 (scalar codes); the classics of decisions by
// lambda are cited in coordinate_descent.h.
#ifndef NMC_ENCODER_FIT_QUANTIZE_H_
#define NMC_ENCODER_FIT_QUANTIZE_H_

#include <cstdint>
#include <memory>
#include <vector>

#include "encoder/fit/fit_system.h"
#include "encoder/fit/global_fit.h"
#include "encoder/fit/quantized_mesh.h"
#include "encoder/fit/rate_model.h"

namespace nmc {

struct QuantizeOptions {
  double normal_step = 1e-3;      // Delta of the finest coded level, in units of the mesh
  double step_ratio = 1.8;        // s: steps of neighbouring levels
  double tangential_ratio = 3.5;  // tangential over normal step of the same level
  double base_step_factor = 1;    // base grid in units of Delta s^-L
  Vec3 base_origin;
  /// lambda in units of the energy of one finest step: lambda = factor * 1/2 h Delta^2, h the mean curvature
  /// of the energy in a coefficient of the finest coded level.
  double lambda_factor = 0.08;
  /// Coefficients below this share of their step leave the active set.
  double dead_zone = 0.62;
  int active_set_rounds = 2;
  /// Rounds of coordinate descent over all levels.
  int descent_rounds = 3;
  /// Points of the input farther than this many RMS distances from the surface pull on it; 0: none do.
  double reach_multiple = 2;
  /// Correspondences follow the surface this many times (needs an input surface).
  int reprojection_count = 2;
  /// Starts from the correspondences that the last call ended with instead of the fit's. For steps within a
  /// factor of about 1.5 they are as good, and one re-projection less is enough.
  bool keep_correspondences = false;
};

struct QuantizeReport {
  double fit_rms = 0;     // point-to-plane over the samples before rounding, after the active set
  double final_rms = 0;   // of the integers
  double model_bits = 0;  // normal coefficients, by the rate model
  std::size_t nonzero_count = 0;
  std::size_t tangential_count = 0;
};

/// Holds one fitted mesh and quantizes it any number of times. Not thread-safe; parallel inside.
class MeshQuantizer {
 public:
  /// `mesh` is fitted (global_fit) to `samples` on its last level. `input` may be null (no re-projection); it
  /// and the mesh's hierarchy must outlive the object.
  MeshQuantizer(const NormalMesh& mesh, int coded_level_count, std::vector<SurfaceSample> samples,
                const InputSurface* input, const QuadraticEnergyOptions& energy = {});
  ~MeshQuantizer();

  /// A function of its arguments and of what the object was made from: earlier calls leave no trace, unless
  /// options.keep_correspondences asks for it.
  QuantizedMesh quantize(const QuantizeOptions& options, QuantizeReport* report = nullptr);

  /// The quality layer before `finer`: steps and base grid are `ratio` times coarser, base vertices lie where
  /// those of `finer` round to, and integers are charged with what they add to the differences that `finer`
  /// codes. `options` gives everything but steps and origin. Correspondences are those that the last call
  /// ended with.
  QuantizedMesh coarsen(const QuantizedMesh& finer, int ratio, const QuantizeOptions& options,
                        QuantizeReport* report = nullptr);

  /// Rate-distortion descent on the integers of one quality layer between its neighbours, of which either may
  /// be null: it is charged for its own differences to `coarser` and for those of `finer` to it.
  QuantizedMesh polish(const QuantizedMesh& mesh, const QuantizedMesh* coarser, const QuantizedMesh* finer,
                       int ratio, const QuantizeOptions& options, QuantizeReport* report = nullptr);

  const SubdivisionHierarchy& hierarchy() const;

 private:
  struct State;
  QuantizedMesh run(const QuantizeOptions& options, const QuantizedMesh* finer, int ratio,
                    QuantizeReport* report);
  std::unique_ptr<State> state_;
};

}  // namespace nmc

#endif  // NMC_ENCODER_FIT_QUANTIZE_H_
