// SPDX-License-Identifier: Apache-2.0
// From the numbering of the domain to that of the stream.
//
// A stream numbers base vertices and faces in the order in which its connectivity coder visits them, and all finer
// numbers follow from the base (libnmc/common/subdivision.h). A normal mesh is brought into that numbering once,
// before it is fitted and quantized; nothing about its shape changes.
#ifndef NMC_ENCODER_PIPELINE_RENUMBER_H_
#define NMC_ENCODER_PIPELINE_RENUMBER_H_

#include <cstdint>
#include <vector>

#include "encoder/normal_mesh/normal_mesh.h"
#include "encoder/normal_mesh/surface_samples.h"

namespace nmc {

/// Which old face, and which of its corners comes first, and which old edge, and whether it runs backwards, stand
/// behind each new number of one level.
struct LevelRenumbering {
  std::vector<std::uint32_t> old_face;
  std::vector<std::uint8_t> first_corner;
  std::vector<std::uint32_t> old_edge;
  std::vector<std::uint8_t> reversed;
};

struct StreamOrder {
  std::vector<std::uint32_t> old_vertex;   // of the base
  std::vector<Triangle> base_faces;        // in the new numbering
  std::vector<std::uint8_t> base_creases;  // per new edge of level 0; empty where there are none
};

/// The order in which the stream visits the base mesh of `hierarchy`. O(n log n).
StreamOrder stream_order(const SubdivisionHierarchy& hierarchy);

/// `mesh` and `samples` (on its finest level) in the numbering of the stream. O(vertices).
NormalMesh renumber(const NormalMesh& mesh, const StreamOrder& order, std::vector<SurfaceSample>& samples);

}  // namespace nmc

#endif  // NMC_ENCODER_PIPELINE_RENUMBER_H_
