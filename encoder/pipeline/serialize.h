// SPDX-License-Identifier: Apache-2.0
// Quantized meshes to bytes: how a stream is cut into chunks and rows of the layer table.
#ifndef NMC_ENCODER_PIPELINE_SERIALIZE_H_
#define NMC_ENCODER_PIPELINE_SERIALIZE_H_

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "encoder/color/color_stream.h"
#include "encoder/core/triangle_mesh.h"
#include "encoder/fit/quantized_mesh.h"
#include "libnmc/common/format.h"

namespace nmc {

/// Steps as the header can say them: the grid is a 24-bit number times a power of two, and the other steps are
/// powers of the eighth root of two away from it.
struct StreamSteps {
  std::uint32_t mantissa = 1;
  int exponent = 0;
  int eighths_per_level = 7;       // step of a level over that of the next coarser one: 2^(7/8) = 1.834
  int eighths_base_to_level_0 = 7; // step of level 0 over the base grid
  int eighths_tangential = 15;     // tangential over normal step: 2^(15/8) = 3.67

  double grid_step() const;
  double normal_step(int level) const;
};

/// The steps whose finest of `level_count` levels is as near to `finest_normal_step` as can be said.
StreamSteps stream_steps(double finest_normal_step, int level_count, int eighths_per_level,
                         int eighths_base_to_level_0, int eighths_tangential);

/// The lattice point at or below `corner`, in grid steps of `steps` times `layer_ratio`.
struct StreamOrigin {
  std::int64_t at[3] = {0, 0, 0};
  Vec3 position(const StreamSteps& steps) const;
};
StreamOrigin stream_origin(const StreamSteps& steps, const Vec3& corner);

struct StreamDescription {
  BoundingBox box;  // of the input
  std::uint64_t input_vertex_count = 0, input_triangle_count = 0;
  Units units = Units::kUnknown;
  UpAxis up_axis = UpAxis::kUnknown;
  int region_count = 0;  // parts that can be fetched alone (spec 5.4); 0: the surface is not divided
};

struct MeasuredError {
  double rms = 0, maximum = 0;
};
/// Measures a level of the decoded mesh against the input.
using MeasureLevel = std::function<MeasuredError(const std::vector<Vec3>& positions, int level)>;

struct StreamRow {
  std::uint64_t end_offset = 0;
  int level = 0;
  std::uint32_t triangle_count = 0;
  MeasuredError error;
};

struct StreamBytes {
  std::vector<std::uint8_t> bytes;
  std::vector<StreamRow> rows;
  std::uint64_t header_size = 0, base_size = 0;
  std::uint64_t color_size = 0;  // of all chunks with colours
  std::vector<std::uint64_t> level_sizes;
  int region_count = 0;
  std::uint64_t state_hash = 0, position_hash = 0;
};

/// Codes the quality layers of a mesh whose hierarchy is in stream order: `layers` are complete meshes, coarse to fine,
/// each with steps `layer_ratio` times finer than the one before; `steps` are those of the last. Without `measure` the
/// errors of the table are zero and the size is that of the final file. Regions share the levels before the last two
/// that are coded, and have a row each in every layer. Colours follow the geometry of their level;
/// levels that only colours have follow all geometry, and their rows have the error of the last level before them,
/// whose surface they share.
StreamBytes serialize(const std::vector<const QuantizedMesh*>& layers, int layer_ratio,
                      const SubdivisionHierarchy& hierarchy,
                      const std::vector<std::uint8_t>& base_creases, const StreamSteps& steps,
                      const StreamDescription& description, const MeasureLevel& measure = {}, const ColorStream* colors = nullptr);

}  // namespace nmc

#endif  // NMC_ENCODER_PIPELINE_SERIALIZE_H_
