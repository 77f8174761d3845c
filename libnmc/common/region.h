// SPDX-License-Identifier: Apache-2.0
// Regions: parts of the surface that can be fetched and refined alone (spec 5.4).
//
// Base faces are grouped into regions. From some level on, the integers of a region are coded as if its faces
// were a mesh of their own, so that no region waits for another. An edge between two regions belongs to that
// of its left face; in the other it is foreign: there, but never coded, and zero.
#ifndef NMC_COMMON_REGION_H_
#define NMC_COMMON_REGION_H_

#include <cstdint>

#include "libnmc/common/format.h"
#include "libnmc/common/memory.h"
#include "libnmc/common/status.h"
#include "libnmc/common/subdivision.h"

namespace nmc {

/// Which base face lies in which region. Regions are the cells of seeds on the graph of the faces: each seed
/// is the face farthest from those before it. Based on: Gonzalez, "Clustering to minimize the maximum
/// intercluster distance" (Theoretical Computer Science 38, 1985).
struct RegionPartition {
  explicit RegionPartition(Memory* memory = nullptr)
      : region_of_face(memory), faces(memory), rank_of_face(memory) {}

  /// `region_count` is at least 1 and at most the number of faces and kMaximumRegionCount. O(faces region_count).
  Status build(const LevelTopology& base, std::uint32_t region_count, Memory* memory);

  Array<std::uint32_t> region_of_face;  // per base face
  Array<std::uint32_t> faces;           // base faces by region, in increasing order
  Array<std::uint32_t> rank_of_face;    // per base face: its number among those of its region
  std::uint32_t first_face[kMaximumRegionCount + 1] = {};  // region r has faces[first_face[r] ... first_face[r + 1] - 1]
};

/// One level of one region as a mesh of its own. An edge on its border may have its left face missing. Faces and
/// edges have the order that they have in the whole.
struct RegionLevel {
  explicit RegionLevel(Memory* memory = nullptr)
      : edges(memory), odd_edges(memory), topologies_{LevelTopology(memory), LevelTopology(memory)} {}

  /// Level 0; vertices by first visit. `scratch` is one array for all calls with this `base`. O(n log n) for n faces
  /// of the region, but for the first call.
  Status extract(const LevelTopology& base, const RegionPartition& partition, std::uint32_t region,
                 Array<std::uint32_t>& scratch);
  /// The next finer level.
  Status split(const RegionPartition& partition, std::uint32_t region);

  const LevelTopology& topology() const { return topologies_[current_]; }
  std::uint32_t whole_edge_count = 0;  // of this level
  Array<std::uint32_t> edges;  // by their numbers in the whole; below level 0 kNone stands for those that are foreign
  /// What odd vertices join on the next level: the edges of the split, by their numbers in the whole; kNone: foreign.
  Array<std::uint32_t> odd_edges;

 private:
  LevelTopology topologies_[2];  // this level, and one whose memory the next will use
  int current_ = 0;
  /// `numbers`: those of this level's edges in the whole.
  Status number_odd_edges(const RegionPartition& partition, std::uint32_t region,
                          const Array<std::uint32_t>& numbers);
};

}  // namespace nmc

#endif  // NMC_COMMON_REGION_H_
