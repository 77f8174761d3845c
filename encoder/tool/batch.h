// SPDX-License-Identifier: Apache-2.0
// Many files in one run.
#ifndef NMC_ENCODER_TOOL_BATCH_H_
#define NMC_ENCODER_TOOL_BATCH_H_

#include <string>
#include <vector>

namespace nmc {

/// The mesh files of a folder (those with an ending that can be read, in the order of their names, no
/// subfolders), or the lines of a text file (empty ones and those that begin with # are passed over; names
/// are relative to the text file's folder). Throws Error: kInputOutput; kUsage where there is no mesh file.
std::vector<std::string> batch_inputs(const std::string& list_or_folder);

}  // namespace nmc

#endif  // NMC_ENCODER_TOOL_BATCH_H_
