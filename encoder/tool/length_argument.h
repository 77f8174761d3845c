// SPDX-License-Identifier: Apache-2.0
// Numbers with units on a command line: "0.05mm", "0.01%", "2MB".
#ifndef NMC_ENCODER_TOOL_LENGTH_ARGUMENT_H_
#define NMC_ENCODER_TOOL_LENGTH_ARGUMENT_H_

#include <cstdint>
#include <string>

#include "libnmc/common/format.h"

namespace nmc {

/// A distance as the user wrote it.
struct LengthArgument {
  double number = 0;
  bool is_percent = false;        // of the bounding-box diagonal
  Units units = Units::kUnknown;  // of the number; unknown: those of the input
};

/// Parses NUMBER[%|mm|cm|m|in|ft|km]. Throws nmc::Error(kUsage).
LengthArgument parse_length(const std::string& text);

/// In units of an input whose positions are in `input_units`. Throws nmc::Error(kUsage) when the argument
/// names units and the input's are not known.
double length_in_input_units(const LengthArgument& length, Units input_units, double diagonal);

/// NUMBER[B|kB|KB|MB|GB|KiB|MiB|GiB]: bytes. Throws nmc::Error(kUsage).
double parse_size(const std::string& text);

/// "mm", "cm", "m", "in", "ft", "km". Throws nmc::Error(kUsage).
Units parse_units(const std::string& text);

}  // namespace nmc

#endif  // NMC_ENCODER_TOOL_LENGTH_ARGUMENT_H_
