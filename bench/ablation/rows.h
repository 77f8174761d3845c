// SPDX-License-Identifier: Apache-2.0
// The rows of the ablation: the encoder with one part after the other put in.
#ifndef NMC_BENCH_ABLATION_ROWS_H_
#define NMC_BENCH_ABLATION_ROWS_H_

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/ablation/coefficient_bits.h"
#include "bench/ablation/scan.h"

namespace nmc_bench {

struct Row {
  std::string name;
  std::uint32_t base_vertex_count = 0;
  int level_count = 0;         // coded
  double step = 0;             // of the finest coded level
  std::size_t byte_count = 0;  // the whole stream by the real coder
  std::optional<CoefficientBits> bits;
  MeasuredError error;  // zero where no step reaches the asked one

  bool is_met() const { return byte_count > 0; }
  /// The stream with coefficients by one adaptive context per decision: computed, not coded.
  double one_context_bytes() const {
    return static_cast<double>(byte_count) + (bits->one_context - bits->coded) / 8;
  }
  double untrained_bytes() const {
    return static_cast<double>(byte_count) + (bits->mixing_untrained - bits->coded) / 8;
  }
};

struct AblationOptions {
  std::vector<double> errors;  // RMS, in units of the mesh
  /// Of all rows but the last. A row whose mesh is too coarse for an error is tried with up to two more
  /// levels.
  int base_vertex_count = 364, level_count = 4;
  /// Called after each row with the number of its error.
  std::function<void(std::size_t, const Row&)> done;
};

/// Open loop, closed loop, fit rounded, fit quantized, with a smoothing level: [error][row].
std::vector<std::vector<Row>> ablate(const Scan& scan, const AblationOptions& options);

/// The last row: the whole encoder.
Row whole_encoder(const Scan& scan, double rms, int effort);
inline constexpr const char* kWholeEncoder = "+ chosen base size";

}  // namespace nmc_bench

#endif  // NMC_BENCH_ABLATION_ROWS_H_
