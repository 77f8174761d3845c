// SPDX-License-Identifier: Apache-2.0
// nmc-bench-peers MESH... --csv FILE: runs every peer on every mesh and appends what FILE does not hold yet.
#include <fmt/core.h>
#include <oneapi/tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>

#include "bench/peers/peer_sweep.h"
#include "encoder/core/error.h"
#include "encoder/read/mesh_reader.h"

namespace {

void run_mesh(const std::string& path, const std::vector<std::string>& chosen,
              nmc::bench::ResultTable& table) {
  const std::string name = std::filesystem::path(path).filename().string();
  std::optional<nmc::bench::BenchMesh> mesh;
  for (const nmc::bench::Peer& peer : nmc::bench::all_peers()) {
    const bool wanted = chosen.empty() || std::find(chosen.begin(), chosen.end(), peer.name) != chosen.end();
    if (!wanted || table.contains(name, peer.name)) continue;
    if (!mesh) mesh.emplace(nmc::read_mesh(path));
    const nmc::bench::Stopwatch watch;
    try {
      const auto rows = peer.run(*mesh);
      table.append(name, peer.name, rows);
      fmt::print("{} {}: {} settings, {:.1f} s\n", name, peer.name, rows.size(), watch.seconds());
    } catch (const nmc::Error& error) {
      fmt::print("{} {}: {}\n", name, peer.name, error.what());
    }
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Runs every peer codec on the given meshes and appends bytes, errors and times to a CSV file.");
  std::vector<std::string> meshes;
  std::vector<std::string> peers;
  std::string csv;
  std::size_t threads = 0;
  app.add_option("mesh", meshes, "mesh files")->required();
  app.add_option("--csv", csv, "results; rows already there are not made again")->required();
  app.add_option("--peer", peers, "only these peers");
  app.add_option("--threads", threads, "for measuring errors; 0: all processors");
  CLI11_PARSE(app, argc, argv);
  try {
    std::optional<oneapi::tbb::global_control> limit;
    if (threads != 0) limit.emplace(oneapi::tbb::global_control::max_allowed_parallelism, threads);
    nmc::bench::ResultTable table(csv);
    for (const std::string& mesh : meshes) run_mesh(mesh, peers, table);
  } catch (const nmc::Error& error) {
    fmt::print(stderr, "nmc-bench-peers: {}\n", error.what());
    return static_cast<int>(error.code());
  }
  return 0;
}
