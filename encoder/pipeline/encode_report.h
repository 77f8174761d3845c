// SPDX-License-Identifier: Apache-2.0
// What the encoder did, for programs (JSON, schema nmc-encode-v1) and for people (one screen).
#ifndef NMC_ENCODER_PIPELINE_ENCODE_REPORT_H_
#define NMC_ENCODER_PIPELINE_ENCODE_REPORT_H_

#include <string>

#include "encoder/pipeline/encode_mesh.h"

namespace nmc {

struct ReportContext {
  std::string input_name, output_name;
  std::uint64_t input_bytes = 0;
  std::vector<std::string> dropped_properties;
  Target target;
  double seconds = 0;
  int thread_count = 0;
};

/// JSON with stable keys, errors in units of the input and relative to the diagonal, sizes in bytes, times in
/// seconds.
std::string report_json(const EncodeResult& result, const ReportContext& context);

/// One line: sizes, error against the target, first mesh, time.
std::string summary_line(const EncodeResult& result, const ReportContext& context);

/// "1.21 MB", "640 B".
std::string human_bytes(std::uint64_t bytes);

/// Peak resident memory of this process so far, in bytes; 0 where the system does not tell.
std::uint64_t peak_memory_bytes();

}  // namespace nmc

#endif  // NMC_ENCODER_PIPELINE_ENCODE_REPORT_H_
