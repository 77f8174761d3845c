// SPDX-License-Identifier: Apache-2.0
// One way to code a surface: a base mesh, a number of levels, and everything prepared so that quantizing it with a
// given step is quick.
#ifndef NMC_ENCODER_PIPELINE_CANDIDATE_H_
#define NMC_ENCODER_PIPELINE_CANDIDATE_H_

#include <cstdint>
#include <memory>
#include <vector>

#include "encoder/core/progress.h"
#include "encoder/domain/parameterization.h"
#include "encoder/fit/global_fit.h"
#include "encoder/fit/quantize.h"
#include "encoder/normal_mesh/interpolating_normal_mesh.h"
#include "encoder/pipeline/maximum_repair.h"
#include "encoder/pipeline/serialize.h"

namespace nmc {

/// The surface that is coded, and how distances to it are measured.
struct ReferenceSurface {
  Vec3 center;                             // of the input's box; what the encoder works on is moved by -center
  TriangleMesh mesh;                       // the input as measured against, moved
  std::unique_ptr<SurfaceIndex> index;     // of it
  double diagonal = 0;
};

struct CandidateOptions {
  int coded_level_count = 4;
  int smoothing_level_count = 0;
  int samples_per_face_side = 3;
  int reprojection_count = 1;
  /// Share of the butterfly's correction in the prediction: 1 on smooth surfaces, 0 (midpoints) where planes meet.
  double tension = 1;
};

/// Figures of a candidate before quantization.
struct CandidateStatistics {
  std::uint32_t base_vertex_count = 0, base_face_count = 0;
  std::uint32_t odd_vertex_count = 0, non_normal_count = 0;
  std::size_t replaced_samples = 0, doubtful_samples = 0;
  GlobalFitResult fit;
};

struct TrialOptions {
  int eighths_per_level = 7;
  int eighths_base_to_level_0 = 7;
  int eighths_tangential = 15;
  int measure_sample_count = 0;  // per direction; 0: those of the final measurement
  double lambda_factor = 0.08;
  int quality_layer_count = 1;
  int layer_ratio = 3;
  bool keep_correspondences = false;  // of the last trial (QuantizeOptions); for one layer
  bool is_final = false;              // a trial that may be the file: spikes are sought between vertices too
};

/// The steps of a stream's header as the quantizer takes them; `center` is the reference surface's.
QuantizeOptions quantize_options(const StreamSteps& steps, int coded_level_count, const StreamDescription& description,
                                 const Vec3& center, const TrialOptions& options);

/// The outcome of quantizing with one step.
struct Trial {
  double normal_step = 0;
  StreamSteps steps;
  std::vector<QuantizedMesh> coarser_layers;  // quality layers before the last
  int layer_ratio = 1;
  QuantizedMesh mesh;                         // the last quality layer
  std::size_t byte_count = 0;
  MeasuredError error;
};

class Candidate {
 public:
  /// Builds the interpolating normal mesh on `parameterization`, brings it into stream order and fits it. Keeps
  /// references to `reference` and shared ownership of the parameterization.
  Candidate(std::shared_ptr<const Parameterization> parameterization, const ReferenceSurface& reference,
            const CandidateOptions& options, const Progress& progress = {});
  /// The same on any parameterized surface with a base, a sphere for one; neither is needed afterwards.
  Candidate(const ParameterizedSurface& surface, const ParameterizedBase& base, const ReferenceSurface& reference,
            const CandidateOptions& options, const Progress& progress = {});
  /// With `base`, which lies near `surface`, as all there is but for what the fit adds: correspondences are closest points.
  /// None of the two is needed afterwards.
  Candidate(const TriangleMesh& base, const TriangleMesh& surface, const ReferenceSurface& reference,
            const CandidateOptions& options, const Progress& progress = {});
  ~Candidate();

  const CandidateStatistics& statistics() const;
  int coded_level_count() const;
  const SubdivisionHierarchy& hierarchy() const;
  const ReferenceSurface& reference() const;
  /// The mesh before quantization, in stream order.
  const NormalMesh& fitted_mesh() const;
  const std::vector<std::uint8_t>& base_creases() const;

  /// Error of the fit before quantization, measured as the final one is.
  MeasuredError fitted_error() const;

  /// True where the fit itself leaves more places beyond `tolerance` than repair() takes on: no step can help.
  bool is_out_of_reach(double tolerance) const;

  Trial quantize(double normal_step, const StreamDescription& description, const TrialOptions& options);

  /// Brings the places of `trial` that are farther than `tolerance` from the input within it where a few integers
  /// can (maximum_repair.h), and measures it again. Returns the places that were beyond before.
  std::size_t repair(const MaximumRepairOptions& repair, const StreamDescription& description,
                     const TrialOptions& options, Trial& trial) const;

  /// The error of a trial's mesh by the final measurement.
  MeasuredError measured_error(const Trial& trial) const;

  /// The final stream of a trial, all rows measured, with `colors` where there are any.
  StreamBytes finish(const Trial& trial, const StreamDescription& description, const ColorStream* colors = nullptr);

  /// Distance between the input and the given vertices of a level, both ways.
  MeasuredError measure(const std::vector<Vec3>& positions, int level, std::size_t sample_count) const;

 private:
  StreamBytes code(const Trial& trial, const StreamDescription& description, const MeasureLevel& measure_level,
                   const ColorStream* colors = nullptr) const;
  /// Size and error of trial.mesh.
  void assess(const StreamDescription& description, const TrialOptions& options, Trial& trial) const;

  /// Takes `mesh` into the order of the stream and fits it to the samples: the last act of every constructor.
  void fit(const NormalMesh& mesh, std::vector<SurfaceSample> samples, const Progress& progress);

  /// Vertices of the finest level before quantization.
  std::vector<Vec3> fitted_positions() const;

  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace nmc

#endif  // NMC_ENCODER_PIPELINE_CANDIDATE_H_
