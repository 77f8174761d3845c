// SPDX-License-Identifier: Apache-2.0
// One mesh file to one stream file, with everything a user is told on the way.
#ifndef NMC_ENCODER_TOOL_ENCODE_FILE_H_
#define NMC_ENCODER_TOOL_ENCODE_FILE_H_

#include <string>

#include "encoder/core/error.h"
#include "encoder/tool/encode_arguments.h"

namespace nmc {

/// "-o FILE" or INPUT with the ending .nmc, in --output-dir where one is given. Throws Error(kUsage) for
/// standard input without a name.
std::string output_of(const EncodeArguments& arguments, const std::string& input);

/// Reads `input`, encodes it, writes `output` and what else was asked for. kOk, or kTargetNotMet where the
/// nearest result was written and said so on standard error. Throws Error: then no output was written.
ExitCode encode_file(const EncodeArguments& arguments, const std::string& input, const std::string& output);

}  // namespace nmc

#endif  // NMC_ENCODER_TOOL_ENCODE_FILE_H_
