// SPDX-License-Identifier: Apache-2.0
// How fast streams decode, against Draco and meshoptimizer: at equal error, with a simplifier before them as
// a user would have it, and on the very same triangles.
//
// Usage: nmc-bench-decode [--csv] [--runs N] STREAM.nmc[=ORIGINAL]...
//
// With the mesh that a stream was made of, its error is measured, and the peers get the fewest triangles and
// bits with which Draco keeps it. On the same triangles they get as many bits as keep their rounding below
// the error.
#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "bench/decode/equal_error.h"
#include "bench/decode/timed_codecs.h"
#include "decoder/tool/stream_source.h"
#include "decoder/tool/tool_error.h"
#include "encoder/core/error.h"
#include "encoder/read/mesh_reader.h"

namespace {

using namespace nmc;
using namespace nmc::bench;

struct Report {
  bool csv = false;
  std::string file;
  double own_rate = 0;  // triangles per second of nmc

  void begin() const {
    if (csv)
      std::printf(
          "file,triangles_of,codec,triangles,bytes,seconds,million_triangles_per_s,mb_per_s,bytes_per_"
          "triangle\n");
  }
  void add(const char* triangles_of, const char* codec, std::size_t triangle_count,
           const DecodeTime& time) const {
    const double rate = static_cast<double>(triangle_count) / time.seconds;
    const double output = rate * 18 / 1e6;  // 12 bytes of indices, and half a vertex of 12
    if (csv) {
      std::printf("%s,%s,%s,%zu,%zu,%.6f,%.3f,%.1f,%.1f\n", file.c_str(), triangles_of, codec, triangle_count,
                  time.bytes, time.seconds, rate / 1e6, output, time.memory_per_triangle);
      return;
    }
    std::printf("    %-14s %8zu triangles %8zu bytes %8.2f ms %7.2f Mtriangles/s %7.1f MB/s", codec,
                triangle_count, time.bytes, time.seconds * 1e3, rate / 1e6, output);
    if (time.memory_per_triangle > 0)
      std::printf("  %.1f bytes of memory per triangle\n", time.memory_per_triangle);
    else
      std::printf("  nmc: %.2f of its triangles/s\n", own_rate / rate);
  }
  void add_peers(const char* triangles_of, const FloatMesh& mesh, int bits, int runs) const {
    add(triangles_of, "draco -cl 7", mesh.triangle_count(), time_draco(mesh, bits, 3, runs));
    add(triangles_of, "draco -cl 10", mesh.triangle_count(), time_draco(mesh, bits, 0, runs));
    add(triangles_of, "meshoptimizer", mesh.triangle_count(), time_meshopt(mesh, bits, runs));
  }
};

void run(Report& report, const std::string& argument, int runs) {
  const std::size_t split = argument.find('=');
  const std::string path = argument.substr(0, split);
  const std::vector<std::uint8_t> stream = read_file(path);
  FloatMesh mesh;
  nmc_layer layer{};
  nmc_info info{};
  const DecodeTime own = time_nmc(stream, runs, mesh, layer, info);
  report.file = path.substr(path.rfind('/') + 1);
  report.own_rate = static_cast<double>(mesh.triangle_count()) / own.seconds;
  double rms = (layer.has_error ? layer.rms_error : info.diagonal * 1e-4) / info.diagonal;
  EqualErrorMesh equal;
  if (split != std::string::npos) {
    const BenchMesh original(read_mesh(argument.substr(split + 1)));
    rms = relative_rms(original, mesh);
    equal = mesh_of_equal_error(original, rms);
  }
  if (!report.csv) std::printf("%s: RMS %.5f %% of the diagonal\n", report.file.c_str(), 100 * rms);
  report.add("itself", "nmc", mesh.triangle_count(), own);
  if (!equal.mesh.indices.empty()) {
    if (!report.csv) {
      std::printf("  at equal error: %s, %d bits, RMS %.5f %%\n", equal.simplifier.c_str(),
                  equal.position_bits, 100 * equal.rms);
    }
    report.add_peers("simplifier", equal.mesh, equal.position_bits, runs);
  }
  double side = 0;
  for (int k = 0; k < 3; ++k) side = std::max(side, info.box_max[k] - info.box_min[k]);
  const double bits = std::ceil(std::log2(side / (rms * info.diagonal * std::sqrt(12.0))));
  const int same_bits = std::clamp(static_cast<int>(bits), 10, 16);
  if (!report.csv) std::printf("  on the same triangles, %d bits\n", same_bits);
  report.add_peers("nmc", mesh, same_bits, runs);
}

}  // namespace

int main(int argc, char** argv) {
  // Freed memory stays with the process: page faults of the system are not what is measured.
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  mallopt(M_TRIM_THRESHOLD, 2000000000);
  Report report;
  int runs = 7;
  try {
    std::vector<std::string> streams;
    for (int i = 1; i < argc; ++i) {
      const std::string argument = argv[i];
      if (argument == "--csv") {
        report.csv = true;
      } else if (argument == "--runs" && i + 1 < argc) {
        runs = std::max(1, std::atoi(argv[++i]));
      } else {
        streams.push_back(argument);
      }
    }
    if (streams.empty())
      throw ToolError(ToolExit::kUsage,
                      "usage: nmc-bench-decode [--csv] [--runs N] STREAM.nmc[=ORIGINAL]...");
    report.begin();
    for (const std::string& stream : streams) run(report, stream, runs);
  } catch (const ToolError& error) {
    std::fprintf(stderr, "nmc-bench-decode: %s\n", error.what());
    return static_cast<int>(error.code());
  } catch (const Error& error) {
    std::fprintf(stderr, "nmc-bench-decode: %s\n", error.what());
    return 2;
  }
  return 0;
}
