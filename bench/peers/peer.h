// SPDX-License-Identifier: Apache-2.0
// What a user could do instead of nmc: codecs that keep every triangle, and simplifiers to put before them.
//
// A codec takes a mesh and a precision and gives the bytes and what comes back out of them. Everything is
// used as its own documentation recommends for the smallest file.
#ifndef NMC_BENCH_PEERS_PEER_H_
#define NMC_BENCH_PEERS_PEER_H_

#include <cstddef>
#include <memory>
#include <string>

#include "encoder/core/triangle_mesh.h"

namespace nmc::bench {

struct CodecResult {
  std::size_t bytes = 0;
  TriangleMesh decoded;
  double encode_seconds = 0;
  double decode_seconds = 0;
};

/// Draco, edgebreaker, speed 0 (smallest), positions only. Throws Error(kUnsupported) where Draco refuses the
/// mesh.
CodecResult code_with_draco(const TriangleMesh& mesh, int position_bits);

/// meshoptimizer's index and vertex codecs on 16-bit integers that use `position_bits` of them, then zstd
/// -19: what gltfpack -cc makes of geometry, without the glTF around it.
CodecResult code_with_meshopt(const TriangleMesh& mesh, int position_bits);

/// OpenCTM's MG2 at compression level 9 with a grid of 2^position_bits cells along the longest side.
CodecResult code_with_openctm(const TriangleMesh& mesh, int position_bits);

/// Float positions and 32-bit indices through zstd -19.
CodecResult code_raw_with_zstd(const TriangleMesh& mesh);

/// One mesh at a falling number of triangles. A simplifier that can go on from its last result does so.
class Simplifier {
 public:
  virtual ~Simplifier() = default;
  /// At most `triangle_count` triangles where the simplifier gets that far; call with falling counts.
  virtual TriangleMesh simplify(std::size_t triangle_count) = 0;
};

class MeshoptSimplifier final : public Simplifier {
 public:
  explicit MeshoptSimplifier(const TriangleMesh& mesh) : mesh_(mesh) {}
  TriangleMesh simplify(std::size_t triangle_count) override;

 private:
  const TriangleMesh& mesh_;
};

class OpenMeshSimplifier final : public Simplifier {
 public:
  explicit OpenMeshSimplifier(const TriangleMesh& mesh);
  ~OpenMeshSimplifier() override;
  TriangleMesh simplify(std::size_t triangle_count) override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

#ifdef NMC_BENCH_GPL
/// CGAL's edge collapse with the cost and placement of Lindstrom and Turk, "Fast and memory efficient
/// polygonal simplification", 1998: memoryless, so going on from the last result equals starting anew.
class LindstromTurkSimplifier final : public Simplifier {
 public:
  explicit LindstromTurkSimplifier(const TriangleMesh& mesh);
  ~LindstromTurkSimplifier() override;
  TriangleMesh simplify(std::size_t triangle_count) override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};
#endif

/// Vertices of equal position made one, unused vertices and triangles with two equal corners removed: peers
/// get a connected mesh also from formats that store none (STL). Keeps order. O(n).
TriangleMesh weld_equal_positions(const TriangleMesh& mesh);

/// Wall-clock seconds since construction.
class Stopwatch {
 public:
  Stopwatch();
  double seconds() const;

 private:
  double start_;
};

}  // namespace nmc::bench

#endif  // NMC_BENCH_PEERS_PEER_H_
