// SPDX-License-Identifier: Apache-2.0
// The encoder's view of the connectivity of a semi-regular mesh: all levels at once, built by libnmc's own rules.
#ifndef NMC_ENCODER_CORE_SUBDIVISION_HIERARCHY_H_
#define NMC_ENCODER_CORE_SUBDIVISION_HIERARCHY_H_

#include <cstdint>
#include <vector>

#include "encoder/core/triangle_mesh.h"
#include "libnmc/common/butterfly.h"
#include "libnmc/common/subdivision.h"

namespace nmc {

class SubdivisionHierarchy {
 public:
  SubdivisionHierarchy() = default;
  /// Levels 0 ... level_count. `base_creases` holds one byte per edge of level 0 (numbered as libnmc does), or
  /// nothing. Throws nmc::Error(kInternal) when the base faces are not a manifold: they are the encoder's own work.
  SubdivisionHierarchy(const std::vector<Triangle>& base_faces, std::uint32_t base_vertex_count, int level_count,
                       const std::vector<std::uint8_t>& base_creases = {});

  int level_count() const { return static_cast<int>(levels_.size()) - 1; }
  const LevelTopology& level(int l) const { return levels_[static_cast<std::size_t>(l)]; }
  const RingWeights& ring_weights() const { return ring_weights_; }
  /// Adds finer levels until there are `level_count`.
  void refine_to(int level_count);

 private:
  std::vector<LevelTopology> levels_;
  RingWeights ring_weights_;
};

/// The faces of one level as a triangle list.
std::vector<Triangle> level_triangles(const LevelTopology& topology);

}  // namespace nmc

#endif  // NMC_ENCODER_CORE_SUBDIVISION_HIERARCHY_H_
