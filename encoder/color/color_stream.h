// SPDX-License-Identifier: Apache-2.0
// The colours of a stream: how finely, on which levels, for how many bytes.
#ifndef NMC_ENCODER_COLOR_COLOR_STREAM_H_
#define NMC_ENCODER_COLOR_COLOR_STREAM_H_

#include <cstdint>
#include <optional>
#include <vector>

#include "encoder/color/color_fit.h"
#include "encoder/color/color_quantizer.h"
#include "encoder/core/subdivision_hierarchy.h"

namespace nmc {

/// What the attribute chunks of a stream hold.
struct ColorStream {
  AttributeDescriptor descriptor;
  std::vector<std::vector<std::int32_t>> corrections;  // [level]: 3 for each vertex that the level adds
};

struct ColorOptions {
  /// Wanted peak signal-to-noise ratio of red, green and blue against the input, over area.
  double psnr_db = 38;
  /// At most this many bytes, whatever becomes of the ratio.
  std::optional<double> maximum_bytes;
};

struct ColorReport {
  double psnr_db = 0;  // of the decoded colours, measured as ColorFit does
  double resolution_psnr_db =
      0;  // of the best colours that vertices of this spacing can carry, without quantization
  double byte_estimate = 0;
  int finest_level = 0;
  double luma_step = 0;
  bool is_met = false;
  std::uint32_t vertex_count = 0;  // with colours of their own
};

struct ColorResult {
  ColorStream stream;
  ColorReport report;
};

/// Colours for the mesh whose finest level is the last of `hierarchy`, in stream order, with the decoded
/// positions `positions`; `input` and `input_colors` as in ColorSamples. The coarsest levels that carry the
/// wanted ratio are taken, or one more where that is cheaper. Where the mesh is too coarse the colours get
/// levels of their own beyond the last (by midpoints: the surface stays as it is), as long as these have no
/// more than 1.5 times the input's vertices. O((samples + vertices) log input) time; about 150 bytes per
/// vertex of the finest level tried.
ColorResult code_colors(const SubdivisionHierarchy& hierarchy, const std::vector<Vec3>& positions,
                        const SurfaceIndex& input, const std::vector<RgbByte>& input_colors,
                        const ColorOptions& options);

}  // namespace nmc

#endif  // NMC_ENCODER_COLOR_COLOR_STREAM_H_
