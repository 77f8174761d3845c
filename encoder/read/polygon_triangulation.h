// SPDX-License-Identifier: Apache-2.0
// Polygons to triangles.
//
// Based on: Meisters. Polygons have ears. American Mathematical Monthly 82, 1975 (every simple polygon of
// more than three corners has two ears, so clipping one after the other ends in a triangulation). The polygon
// is looked at along the dominant axis of its Newell normal.
#ifndef NMC_ENCODER_READ_POLYGON_TRIANGULATION_H_
#define NMC_ENCODER_READ_POLYGON_TRIANGULATION_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "encoder/core/triangle_mesh.h"

namespace nmc {

/// Appends exactly corners.size() - 2 triangles, in the orientation of the polygon and with indices 0..n-1
/// into `corners`, n >= 3. A polygon that is star-shaped about its first corner (every convex one is) becomes
/// the fan of that corner, a quadrilateral that is not the fan of its second, every other one is ear-clipped.
/// A simple planar polygon is covered exactly; one that crosses itself, is far from planar or holds
/// non-finite coordinates still gives n - 2 triangles that use every corner. O(n) for fans, O(n r) with r
/// reflex corners otherwise, bounded: after 5e8 tests (about 30,000 corners, half of them reflex) the rest is
/// cut without looking for blocked ears.
void triangulate_polygon(std::span<const Vec3> corners, std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace nmc

#endif  // NMC_ENCODER_READ_POLYGON_TRIANGULATION_H_
