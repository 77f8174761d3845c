// SPDX-License-Identifier: Apache-2.0
// The meshes of a .nmc stream, layer by layer, for measuring them: a thin client of the decoder's C API.
#ifndef NMC_ENCODER_MEASURE_STREAM_LAYERS_H_
#define NMC_ENCODER_MEASURE_STREAM_LAYERS_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "encoder/core/triangle_mesh.h"

namespace nmc {

/// A row of the stream's layer table. Errors are those that the stream states, in units of the model.
struct StreamLayer {
  std::uint64_t end_byte = 0;
  std::uint32_t level = 0;
  bool states_error = false;
  double stated_rms = 0;
  double stated_maximum = 0;
};

/// True for names that end in ".nmc", in any case.
bool is_stream_name(const std::string& path);

/// Calls `visit` with each layer of the stream at `path` and its mesh, in order. A stream that is cut off
/// ends with its last whole layer. Throws Error: kInputOutput; kInvalidInput with byte offset and reason;
/// kUnsupported; kLimit; kCutOff where not even the first layer is whole.
void visit_stream_layers(const std::string& path,
                         const std::function<void(const StreamLayer&, const TriangleMesh&)>& visit);

/// The mesh of the last whole layer. Errors as above.
TriangleMesh read_stream(const std::string& path);

/// The same for a stream in memory; `name` stands in messages.
TriangleMesh read_stream(std::span<const std::byte> bytes, const std::string& name);

}  // namespace nmc

#endif  // NMC_ENCODER_MEASURE_STREAM_LAYERS_H_
