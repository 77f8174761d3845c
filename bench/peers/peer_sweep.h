// SPDX-License-Identifier: Apache-2.0
// Which settings of which peer are run on a mesh.
#ifndef NMC_BENCH_PEERS_PEER_SWEEP_H_
#define NMC_BENCH_PEERS_PEER_SWEEP_H_

#include <functional>
#include <string>
#include <vector>

#include "bench/peers/peer.h"
#include "bench/peers/result_table.h"
#include "encoder/spatial/surface_index.h"

namespace nmc::bench {

/// A mesh with everything that is computed once per mesh.
struct BenchMesh {
  explicit BenchMesh(TriangleMesh original_mesh);
  TriangleMesh original;  // what errors are measured against
  TriangleMesh welded;    // what the peers are given
  SurfaceIndex index;     // of the original
  BoundingBox box;
};

/// The RMS range, relative to the diagonal, outside of which simplified meshes are not coded.
inline constexpr double kFinestRms = 1.2e-5;
inline constexpr double kCoarsestRms = 2.5e-3;

struct Peer {
  std::string name;
  std::function<std::vector<ResultRow>(const BenchMesh&)> run;
};

/// "draco", "meshopt+zstd", "openctm", "raw+zstd", and for each simplifier "SIMPLIFIER+draco".
std::vector<Peer> all_peers();

}  // namespace nmc::bench

#endif  // NMC_BENCH_PEERS_PEER_SWEEP_H_
