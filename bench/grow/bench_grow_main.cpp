// SPDX-License-Identifier: Apache-2.0
// nmc-bench-grow MESH --splits K -o OUT.ply: a scan with 4^K times the triangles, for measuring growth.
//
// Each split cuts every triangle into four at its edges' middles. At the end every new vertex is moved along
// the surface normal by noise of a tenth of the edge length (fixed seed), as a scanner would: a smooth
// surface would be easier for nmc than real data of that size.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <unordered_map>

#include "decoder/write/mesh_writer.h"
#include "encoder/core/error.h"
#include "encoder/read/mesh_reader.h"

namespace {

using nmc::Triangle;
using nmc::TriangleMesh;
using nmc::Vec3;

constexpr double kNoisePerEdge = 0.1;

TriangleMesh split(const TriangleMesh& mesh) {
  TriangleMesh finer;
  finer.positions = mesh.positions;
  finer.triangles.reserve(4 * mesh.triangle_count());
  std::unordered_map<std::uint64_t, std::uint32_t> middle_of;
  middle_of.reserve(2 * mesh.triangle_count());
  for (const Triangle& t : mesh.triangles) {
    std::uint32_t middle[3];
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint64_t a = std::min(t[i], t[(i + 1) % 3]), b = std::max(t[i], t[(i + 1) % 3]);
      const auto next = static_cast<std::uint32_t>(finer.positions.size());
      const auto [entry, inserted] = middle_of.try_emplace(a << 32 | b, next);
      if (inserted) finer.positions.push_back(0.5 * (mesh.positions[a] + mesh.positions[b]));
      middle[i] = entry->second;
    }
    finer.triangles.push_back({t[0], middle[0], middle[2]});
    finer.triangles.push_back({t[1], middle[1], middle[0]});
    finer.triangles.push_back({t[2], middle[2], middle[1]});
    finer.triangles.push_back({middle[0], middle[1], middle[2]});
  }
  return finer;
}

// SplitMix64 (Steele, Lea, Flood 2014) of the vertex number, uniform in [-1, 1).
double noise(std::uint64_t number) {
  std::uint64_t z = (number + 1) * 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-52 - 1;
}

void add_noise(TriangleMesh& mesh, std::size_t first_vertex) {
  const double edge =
      std::sqrt(surface_area(mesh) / static_cast<double>(mesh.triangle_count()) * 4 / std::sqrt(3.0));
  const std::vector<Vec3> normals = vertex_normals(mesh);
  for (std::size_t v = first_vertex; v < mesh.vertex_count(); ++v) {
    mesh.positions[v] += (kNoisePerEdge * edge * noise(v)) * normals[v];
  }
}

void write(const TriangleMesh& mesh, const std::string& path) {
  std::vector<float> positions;
  positions.reserve(3 * mesh.vertex_count());
  for (const Vec3& p : mesh.positions) {
    for (int i = 0; i < 3; ++i) positions.push_back(static_cast<float>(p[i]));
  }
  std::vector<std::uint32_t> triangles;
  triangles.reserve(3 * mesh.triangle_count());
  for (const Triangle& t : mesh.triangles) triangles.insert(triangles.end(), t.begin(), t.end());
  nmc::MeshView view;
  view.positions_single = positions;
  view.triangles = triangles;
  const nmc::WriteStatus status = write_mesh(path, view, nmc::OutputFormat::kPly);
  if (!status.is_ok()) throw nmc::Error(nmc::ExitCode::kInputOutput, status.message);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Makes a large, noisy mesh of a scan: every triangle cut into four, several times.");
  std::string input, output;
  int splits = 1;
  app.add_option("mesh", input)->required();
  app.add_option("--splits", splits, "how often the triangles are cut into four")->check(CLI::Range(0, 8));
  app.add_option("-o,--output", output, "PLY file")->required();
  CLI11_PARSE(app, argc, argv);
  try {
    TriangleMesh mesh = nmc::read_mesh(input);
    const std::size_t original_vertices = mesh.vertex_count();
    for (int i = 0; i < splits; ++i) mesh = split(mesh);
    add_noise(mesh, original_vertices);
    write(mesh, output);
    fmt::print("{}: {} triangles\n", output, mesh.triangle_count());
  } catch (const nmc::Error& error) {
    fmt::print(stderr, "nmc-bench-grow: {}\n", error.what());
    return static_cast<int>(error.code());
  }
  return 0;
}
