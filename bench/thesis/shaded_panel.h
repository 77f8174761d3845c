// SPDX-License-Identifier: Apache-2.0
// One shaded view of a mesh, a panel of the pictures.
#ifndef NMC_BENCH_THESIS_SHADED_PANEL_H_
#define NMC_BENCH_THESIS_SHADED_PANEL_H_

#include <vector>

#include "encoder/core/triangle_mesh.h"
#include "encoder/render/image.h"

namespace nmc_bench {

/// `shown` seen from the direction `from`, `size` pixels square, lit by `normals` (one per vertex). With
/// `checker`, a unit vector per vertex, fields of 10 degrees of longitude and latitude are drawn. With
/// `frame`, the camera fits that mesh instead, so that panels can share a scale.
nmc::Image shaded_panel(const nmc::TriangleMesh& shown, const std::vector<nmc::Vec3>& normals,
                        const std::vector<nmc::Vec3>* checker, const nmc::Vec3& from, const nmc::Vec3& up,
                        int size, const nmc::TriangleMesh* frame = nullptr);

}  // namespace nmc_bench

#endif  // NMC_BENCH_THESIS_SHADED_PANEL_H_
