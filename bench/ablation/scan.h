// SPDX-License-Identifier: Apache-2.0
// A scan as the encoder sees it, and the one search that every row of the ablation goes through.
#ifndef NMC_BENCH_ABLATION_SCAN_H_
#define NMC_BENCH_ABLATION_SCAN_H_

#include <functional>
#include <memory>
#include <string>

#include "encoder/domain/parameterization.h"
#include "encoder/pipeline/candidate.h"

namespace nmc_bench {

using namespace nmc;

struct Scan {
  std::string name;
  TriangleMesh input;
  TriangleMesh surface;  // conditioned, about the centre of the box
  ReferenceSurface reference;
  StreamDescription description;
};
Scan read_scan(const std::string& path);

/// A base of about `vertex_count` vertices, and the surface's map onto it.
std::shared_ptr<const Parameterization> parameterization_of(const Scan& scan, int vertex_count);

/// Steps of the header, and the same steps as the quantizers take them.
struct Steps {
  StreamSteps stream;
  QuantizeOptions quantize;
};
Steps steps_of(const Scan& scan, double finest_normal_step, int level_count, const TrialOptions& options);

/// A mesh of integers with everything that its stream and its measurement need.
struct Coded {
  StreamSteps steps;
  QuantizedMesh mesh;
  std::shared_ptr<const SubdivisionHierarchy> hierarchy;  // in stream order, smoothing levels included
  std::vector<std::uint8_t> base_creases;
  std::size_t byte_count = 0;  // of the whole stream, header and layer table included
  MeasuredError error;         // of the decoded positions, both ways
};
/// Of the decoded vertices, both ways; `sample_count` 0: as many as for the encoder's own verdict.
MeasuredError error_of(const Scan& scan, const Coded& coded, std::size_t sample_count);

/// With these a search finds its way; near the target all samples decide.
inline constexpr std::size_t kFewSamples = 60000;

/// Makes the integers for a step; the size is left open, and the error may be.
using Quantize = std::function<Coded(double finest_normal_step)>;

/// The stream whose error meets `rms` most closely from below. Throws Error(kTargetNotMet) where no step
/// does.
Coded closest_below(const Scan& scan, const Quantize& quantize, double rms, double first_step);

}  // namespace nmc_bench

#endif  // NMC_BENCH_ABLATION_SCAN_H_
