// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>

#include "corpus/generate/random.h"
#include "corpus/generate/shapes.h"

namespace nmc::corpus {

namespace {
using std::numbers::pi;
constexpr std::uint32_t kUnused = 0xffffffffu;

/// Drops vertices that no triangle uses.
void compact(TriangleMesh& mesh) {
  std::vector<std::uint32_t> renamed(mesh.vertex_count(), kUnused);
  std::vector<Vec3> positions;
  for (Triangle& t : mesh.triangles)
    for (std::uint32_t& v : t) {
      if (renamed[v] == kUnused) {
        renamed[v] = static_cast<std::uint32_t>(positions.size());
        positions.push_back(mesh.positions[v]);
      }
      v = renamed[v];
    }
  mesh.positions = std::move(positions);
}
}  // namespace

TriangleMesh disk_with_holes(int hole_count) {
  // Blocks of 5 x 5 cells, each with a hole of 2 x 2 cells, on a square that is then rounded to a disk.
  const int blocks = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(hole_count))));
  const int cells = 5 * blocks + 1;
  TriangleMesh mesh;
  for (int i = 0; i <= cells; ++i)
    for (int j = 0; j <= cells; ++j) {
      const double x = 2.0 * i / cells - 1, y = 2.0 * j / cells - 1;
      const double u = x * std::sqrt(1 - y * y / 2), v = y * std::sqrt(1 - x * x / 2);
      mesh.positions.push_back({u, v, 0.2 * (u * u + v * v)});
    }
  const auto vertex = [&](int i, int j) { return static_cast<std::uint32_t>(i * (cells + 1) + j); };
  for (int i = 0; i < cells; ++i)
    for (int j = 0; j < cells; ++j) {
      const int block = (i / 5) * blocks + j / 5;
      const bool in_block = i / 5 < blocks && j / 5 < blocks;
      const bool in_hole = (i % 5 == 2 || i % 5 == 3) && (j % 5 == 2 || j % 5 == 3);
      if (in_block && in_hole && block < hole_count) continue;
      // The diagonal turns with the quadrant, or the corners of the disk would get flat triangles.
      if ((2 * i < cells) == (2 * j < cells)) {
        mesh.triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i, j + 1)});
        mesh.triangles.push_back({vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
      } else {
        mesh.triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)});
        mesh.triangles.push_back({vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
      }
    }
  compact(mesh);
  return mesh;
}

TriangleMesh thin_sheets(int sheet_count, int cells, double thickness, double gap) {
  TriangleMesh mesh;
  for (int sheet = 0; sheet < sheet_count; ++sheet) {
    TriangleMesh plate = voxel_surface(cells, cells, 1, [](int, int, int) { return true; },
                                       {1.0 / cells, 1.0 / cells, thickness});
    for (Vec3& p : plate.positions)
      p.z += sheet * (thickness + gap) + 0.1 * std::sin(2 * pi * p.x) * std::cos(2 * pi * p.y);
    append(mesh, plate);
  }
  return mesh;
}

TriangleMesh loose_triangles(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  TriangleMesh mesh;
  // A third of the mean distance between neighbours, so that few overlap.
  const double size = 0.3 / std::cbrt(static_cast<double>(count) + 1);
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 center = random.in_cube(0.5);
    const auto first = static_cast<std::uint32_t>(mesh.vertex_count());
    const Vec3 a = random.in_cube(size), b = random.in_cube(size);
    mesh.positions.push_back(center);
    mesh.positions.push_back(center + a);
    mesh.positions.push_back(center + b);
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

TriangleMesh terrain(int cells, std::uint64_t seed) {
  // Waves of doubling frequency and falling height in random directions.
  Random random(seed);
  struct Wave {
    double kx, ky, phase, height;
  };
  std::vector<Wave> waves;
  for (int octave = 0; octave < 8; ++octave)
    for (int i = 0; i < 4; ++i) {
      const double angle = random.uniform(0, 2 * pi),
                   frequency = 2 * pi * (1 << octave) * random.uniform(0.7, 1.4);
      const double phase = random.uniform(0, 2 * pi);
      waves.push_back(
          {frequency * std::cos(angle), frequency * std::sin(angle), phase, 0.05 * std::pow(0.45, octave)});
    }
  TriangleMesh mesh;
  for (int i = 0; i <= cells; ++i)
    for (int j = 0; j <= cells; ++j) {
      const double x = static_cast<double>(i) / cells, y = static_cast<double>(j) / cells;
      double z = 0;
      for (const Wave& w : waves) z += w.height * std::sin(w.kx * x + w.ky * y + w.phase);
      mesh.positions.push_back({x, y, z});
    }
  const auto vertex = [&](int i, int j) { return static_cast<std::uint32_t>(i * (cells + 1) + j); };
  for (int i = 0; i < cells; ++i)
    for (int j = 0; j < cells; ++j) {
      mesh.triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)});
      mesh.triangles.push_back({vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
    }
  return mesh;
}

}  // namespace nmc::corpus
