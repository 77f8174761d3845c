// SPDX-License-Identifier: Apache-2.0
// Original and result side by side, and the result coloured by its distance to the original, with a legend.
#ifndef NMC_ENCODER_RENDER_COMPARISON_PICTURE_H_
#define NMC_ENCODER_RENDER_COMPARISON_PICTURE_H_

#include <optional>
#include <string>

#include "encoder/core/triangle_mesh.h"
#include "encoder/measure/compare_meshes.h"
#include "encoder/render/image.h"

namespace nmc {

struct PictureOptions {
  int panel_size = 600;  // pixels, of each of the three square panels
  /// From which side the eye looks; without it the side that shows most of the surface, slightly from above.
  std::optional<Vec3> view_from;
  Vec3 up = {0, 1, 0};
  /// Distance at the end of the colour scale in units; 0: a round number near three times the RMS.
  double scale_end = 0;
  /// Surfaces that have colours of their own are shown in them.
  bool shows_colors = true;
  std::string original_title = "original", result_title = "result";
};

/// Each pixel of the third panel shows the exact distance of the surface point seen there to the original.
/// The figures in the captions are those of `compared`. O(triangles + pixels log triangles).
Image comparison_picture(const TriangleMesh& original, const TriangleMesh& result,
                         const CompareResult& compared, const PictureOptions& options = {});

}  // namespace nmc

#endif  // NMC_ENCODER_RENDER_COMPARISON_PICTURE_H_
