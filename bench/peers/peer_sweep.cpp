// SPDX-License-Identifier: Apache-2.0
#include "bench/peers/peer_sweep.h"

#include <fmt/core.h>

#include <chrono>
#include <cmath>
#include <map>
#include <memory>

#include "encoder/core/error.h"
#include "encoder/measure/compare_meshes.h"

namespace nmc::bench {
namespace {

// Triangle counts fall by this factor. Between two neighbours the envelope is interpolated; at half this step
// it was lower by less than 1 %.
constexpr double kTriangleFactor = 0.7071;
constexpr std::size_t kFewestTriangles = 40;
constexpr int kFewestBits = 7;
constexpr int kMostBits = 16;

// The depths worth running after a simplifier with an error of its own: a grid much finer than that error
// wastes bytes, a much coarser one wastes triangles. Bounds on the grid's RMS (step / sqrt(12)) over the
// simplifier's.
constexpr double kFinestGrid = 0.12;
constexpr double kCoarsestGrid = 3.0;

struct Measured {
  double rms, maximum, normal_degrees;
};

Measured measure(const BenchMesh& mesh, const TriangleMesh& decoded) {
  CompareOptions options;
  options.original_index = &mesh.index;
  options.colors = false;
  const CompareResult compared = compare_meshes(mesh.original, decoded, options);
  return {compared.relative_rms(), compared.relative_maximum(), compared.normal_mean_degrees};
}

ResultRow to_row(const BenchMesh& mesh, const std::string& settings, const CodecResult& coded) {
  const Measured measured = measure(mesh, coded.decoded);
  return {settings,
          coded.bytes,
          measured.rms,
          measured.maximum,
          measured.normal_degrees,
          coded.decoded.triangle_count(),
          coded.encode_seconds,
          coded.decode_seconds};
}

template <class Codec>
std::vector<ResultRow> sweep_bits(const BenchMesh& mesh, const Codec& codec) {
  std::vector<ResultRow> rows;
  for (int bits = kFewestBits; bits <= kMostBits; ++bits) {
    rows.push_back(to_row(mesh, fmt::format("bits={}", bits), codec(mesh.welded, bits)));
  }
  return rows;
}

double grid_rms(const BenchMesh& mesh, int bits) {
  const Vec3 size = mesh.box.maximum - mesh.box.minimum;
  return std::max({size.x, size.y, size.z}) / ((1 << bits) - 1) / std::sqrt(12.0) / mesh.box.diagonal();
}

std::vector<ResultRow> sweep_triangles(const BenchMesh& mesh, Simplifier& simplifier) {
  std::vector<ResultRow> rows;
  const double total = static_cast<double>(mesh.welded.triangle_count());
  double simplify_seconds = 0;
  std::size_t previous_triangles = mesh.welded.triangle_count();
  for (double count = total * kTriangleFactor; count >= kFewestTriangles; count *= kTriangleFactor) {
    const Stopwatch watch;
    const TriangleMesh simplified = simplifier.simplify(static_cast<std::size_t>(count));
    simplify_seconds += watch.seconds();
    const bool stuck = simplified.triangle_count() >= previous_triangles;
    if (simplified.triangles.empty() || stuck) break;
    previous_triangles = simplified.triangle_count();
    const double own_rms = measure(mesh, simplified).rms;
    if (own_rms > kCoarsestRms) break;
    for (int bits = kFewestBits; bits <= kMostBits; ++bits) {
      const double grid = grid_rms(mesh, bits);
      if (grid > kCoarsestGrid * own_rms || grid < kFinestGrid * own_rms) continue;
      if (std::hypot(own_rms, grid) < kFinestRms) continue;
      ResultRow row = to_row(mesh, fmt::format("triangles={} bits={}", simplified.triangle_count(), bits),
                             code_with_draco(simplified, bits));
      row.encode_seconds += simplify_seconds;
      rows.push_back(row);
    }
  }
  return rows;
}

}  // namespace

BenchMesh::BenchMesh(TriangleMesh original_mesh)
    : original(std::move(original_mesh)),
      welded(weld_equal_positions(original)),
      index(original),
      box(bounding_box(original)) {}

std::vector<Peer> all_peers() {
  std::vector<Peer> peers;
#ifdef NMC_BENCH_GPL
  peers.push_back({"lindstrom-turk+draco", [](const BenchMesh& mesh) {
                     LindstromTurkSimplifier simplifier(mesh.welded);
                     return sweep_triangles(mesh, simplifier);
                   }});
#endif
  peers.push_back({"draco", [](const BenchMesh& mesh) { return sweep_bits(mesh, code_with_draco); }});
  peers.push_back({"meshopt-simplify+draco", [](const BenchMesh& mesh) {
                     MeshoptSimplifier simplifier(mesh.welded);
                     return sweep_triangles(mesh, simplifier);
                   }});
  peers.push_back({"openmesh-quadric+draco", [](const BenchMesh& mesh) {
                     OpenMeshSimplifier simplifier(mesh.welded);
                     return sweep_triangles(mesh, simplifier);
                   }});
  peers.push_back(
      {"meshopt+zstd", [](const BenchMesh& mesh) { return sweep_bits(mesh, code_with_meshopt); }});
  peers.push_back({"openctm", [](const BenchMesh& mesh) { return sweep_bits(mesh, code_with_openctm); }});
  peers.push_back({"raw+zstd", [](const BenchMesh& mesh) {
                     return std::vector<ResultRow>{to_row(mesh, "level=19", code_raw_with_zstd(mesh.welded))};
                   }});
  return peers;
}

TriangleMesh weld_equal_positions(const TriangleMesh& mesh) {
  const auto less = [](const Vec3& a, const Vec3& b) {
    return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
  };
  std::map<Vec3, std::uint32_t, decltype(less)> index_of(less);
  TriangleMesh welded;
  for (const Triangle& triangle : mesh.triangles) {
    Triangle mapped{};
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3& p = mesh.positions[triangle[i]];
      const auto [entry, inserted] =
          index_of.try_emplace(p, static_cast<std::uint32_t>(welded.positions.size()));
      if (inserted) welded.positions.push_back(p);
      mapped[i] = entry->second;
    }
    if (mapped[0] != mapped[1] && mapped[1] != mapped[2] && mapped[2] != mapped[0])
      welded.triangles.push_back(mapped);
  }
  return welded;
}

Stopwatch::Stopwatch()
    : start_(std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count()) {}

double Stopwatch::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count() - start_;
}

}  // namespace nmc::bench
