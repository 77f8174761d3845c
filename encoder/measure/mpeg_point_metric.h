// SPDX-License-Identifier: Apache-2.0
// D1 and D2: the mesh metric of MPEG's V-DMC, for comparison with published figures only.
//
// Based on: ISO/IEC JTC1/SC29/WG7 common test conditions for V-DMC: both meshes are sampled on a grid into
// point clouds; point-to-point (D1) and point-to-plane (D2) mean squared errors are the worse of both
// directions; PSNR = 10 log10(3 p^2 / MSE). Here p is the longest side of the original's own bounding box
// (MPEG: of the whole sequence), so that no outside number is needed.
#ifndef NMC_ENCODER_MEASURE_MPEG_POINT_METRIC_H_
#define NMC_ENCODER_MEASURE_MPEG_POINT_METRIC_H_

#include "encoder/core/triangle_mesh.h"
#include "encoder/measure/compare_meshes.h"

namespace nmc {

/// `grid`: number of grid lines along the longest side of the original's box. Each triangle is cut by the
/// lines parallel to the axis it faces most. Where a mesh is met by no line, its vertices stand in. O(points
/// log points); a closed surface gives about 2 to 6 grid^2 points.
PointCloudPsnr mpeg_point_metric(const TriangleMesh& original, const TriangleMesh& result, int grid);

}  // namespace nmc

#endif  // NMC_ENCODER_MEASURE_MPEG_POINT_METRIC_H_
