// SPDX-License-Identifier: Apache-2.0
// Numbers with units, in and out: "0.05mm", "0.01%", "2MB"; "2.48 MB".
#ifndef NMC_DECODER_TOOL_QUANTITY_H_
#define NMC_DECODER_TOOL_QUANTITY_H_

#include <cstdint>
#include <string>

#include "libnmc/include/nmc/nmc.h"

namespace nmc {

/// NUMBER[%|mm|cm|m|in|ft|km] as a length in the units of a stream: percent is of the diagonal of its box.
/// Throws ToolError(kUsage), also when the number has units and the stream has none.
double parse_length(const std::string& text, const nmc_info& info);

/// NUMBER[B|kB|MB|GB|KiB|MiB|GiB] as bytes. Throws ToolError(kUsage).
double parse_size(const std::string& text);

/// "mm" and so on; "" for unknown units.
const char* units_name(nmc_units units);

/// "17 bytes", "18.2 kB", "2.48 MB".
std::string bytes_text(std::uint64_t bytes);

/// Three significant digits, and the units when known.
std::string length_text(double length, nmc_units units);

/// 16 hexadecimal digits.
std::string hash_text(std::uint64_t hash);

}  // namespace nmc

#endif  // NMC_DECODER_TOOL_QUANTITY_H_
