// SPDX-License-Identifier: Apache-2.0
// A finished stream inside a GLB file.
#ifndef NMC_ENCODER_TOOL_PROGRESSIVE_GLB_H_
#define NMC_ENCODER_TOOL_PROGRESSIVE_GLB_H_

#include <cstdint>
#include <span>
#include <string>

namespace nmc {

/// Writes `stream` to the GLB file `path`, behind a plain mesh for programs that do not know it: the finest layer of at
/// most 4096 triangles, or the first one. Throws Error.
void write_stream_as_glb(const std::string& path, std::span<const std::uint8_t> stream);

}  // namespace nmc

#endif  // NMC_ENCODER_TOOL_PROGRESSIVE_GLB_H_
