// SPDX-License-Identifier: Apache-2.0
// The command line of nmc-encode.
#ifndef NMC_ENCODER_TOOL_ENCODE_ARGUMENTS_H_
#define NMC_ENCODER_TOOL_ENCODE_ARGUMENTS_H_

#include <CLI/CLI.hpp>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "encoder/pipeline/encode_options.h"

namespace nmc {

/// What the user wrote, not interpreted yet.
struct EncodeArguments {
  std::vector<std::string> inputs;
  std::string output, output_folder, batch, input_format;
  std::string max_error, rms_error, size;
  std::optional<double> bits_per_vertex, quality;
  int effort = 5;
  std::optional<int> base, levels;
  std::string domain = "general", base_mesh, colour = "auto";
  int layers = 1, regions = 0;
  double crease = 0;
  std::string repair = "auto", units, up, report, vertex_map, glb, progress = "auto", memory_limit;
  double timeout_seconds = 0;
  unsigned threads = 0;
  bool force = false, quiet = false, strict = false, keep_holes = false, verify = false, dry_run = false;
  int verbosity = 0;
};

/// Declares all options on `app`; parsing then fills `arguments`, which must outlive the app.
void declare_options(CLI::App& app, EncodeArguments& arguments);

/// Everything of EncodeOptions but the target, the progress and the base mesh. Throws Error(kUsage).
EncodeOptions options_of(const EncodeArguments& arguments);

/// The target for an input of this diagonal and vertex count. Throws Error(kUsage).
Target target_of(const EncodeArguments& arguments, Units units, double diagonal, std::size_t vertex_count);

}  // namespace nmc

#endif  // NMC_ENCODER_TOOL_ENCODE_ARGUMENTS_H_
