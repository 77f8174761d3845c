// SPDX-License-Identifier: Apache-2.0
// Tips of limbs, ears, fingers, horns: vertices that a base mesh should keep.
//
// A normal displacement cannot grow a finger out of a flat patch, and a quadric simplifier, which weighs
// errors by area, drops fingers early. Tips are found where the average geodesic distance to the rest of the
// surface has local maxima, and ranked by how far the maximum stands out.
//
// Based on: Hilaga, Shinagawa, Kohmura, Kunii, "Topology matching for fully automatic similarity estimation
// of 3D shapes" (2001), average geodesic distance; Edelsbrunner, Letscher, Zomorodian, "Topological
// persistence and simplification" (2002), for the rank.
#ifndef NMC_ENCODER_DOMAIN_EXTREMITIES_H_
#define NMC_ENCODER_DOMAIN_EXTREMITIES_H_

#include <cstdint>
#include <vector>

#include "encoder/domain/corner_table.h"

namespace nmc {

/// The tips of the live surface of `table`, the most prominent first. A tip counts from a prominence of
/// `least_prominence` times the square root of its component's area. Distances are along edges: meant for
/// meshes of a few thousand vertices. O(64 n log n).
std::vector<std::uint32_t> find_extremities(const CornerTable& table, const std::vector<Vec3>& positions,
                                            double least_prominence);

}  // namespace nmc

#endif  // NMC_ENCODER_DOMAIN_EXTREMITIES_H_
