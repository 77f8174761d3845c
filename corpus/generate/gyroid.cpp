// SPDX-License-Identifier: Apache-2.0
// Based on: A. Doi, A. Koide. An efficient method of triangulating equi-valued surfaces by using tetrahedral
// cells. IEICE Transactions 1991 (marching tetrahedra, which always give a manifold).
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <unordered_map>

#include "corpus/generate/shapes.h"

namespace nmc::corpus {

namespace {

class MarchingTetrahedra {
 public:
  MarchingTetrahedra(int cells, const std::function<double(const Vec3&)>& field) : cells_(cells) {
    for (int i = 0; i <= cells; ++i)
      for (int j = 0; j <= cells; ++j)
        for (int k = 0; k <= cells; ++k) {
          points_.push_back({2.0 * i / cells - 1, 2.0 * j / cells - 1, 2.0 * k / cells - 1});
          values_.push_back(field(points_.back()));
        }
  }

  /// The surface where the field is zero, looking to where it is positive.
  TriangleMesh run() {
    // Six tetrahedra around the diagonal of each cell; the split agrees on faces shared by cells.
    constexpr std::array<std::array<int, 4>, 6> kTetrahedra = {
        {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}}};
    for (int i = 0; i < cells_; ++i)
      for (int j = 0; j < cells_; ++j)
        for (int k = 0; k < cells_; ++k) {
          std::array<std::uint32_t, 8> corner{};
          for (int c = 0; c < 8; ++c) corner[c] = grid_index(i + (c >> 2), j + (c >> 1 & 1), k + (c & 1));
          for (const auto& t : kTetrahedra)
            add_tetrahedron({corner[t[0]], corner[t[1]], corner[t[2]], corner[t[3]]});
        }
    return std::move(mesh_);
  }

 private:
  std::uint32_t grid_index(int i, int j, int k) const {
    return static_cast<std::uint32_t>((i * (cells_ + 1) + j) * (cells_ + 1) + k);
  }
  bool inside(std::uint32_t p) const { return values_[p] < 0; }

  std::uint32_t crossing(std::uint32_t a, std::uint32_t b) {
    if (a > b) std::swap(a, b);
    const std::uint64_t key = static_cast<std::uint64_t>(a) << 32 | b;
    const auto [place, is_new] =
        crossings_.try_emplace(key, static_cast<std::uint32_t>(mesh_.vertex_count()));
    if (is_new) {
      // Kept off the ends, or the triangles around a grid point on the surface would have no area.
      const double t = std::clamp(values_[a] / (values_[a] - values_[b]), 0.05, 0.95);
      mesh_.positions.push_back(points_[a] + t * (points_[b] - points_[a]));
    }
    return place->second;
  }

  void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c, const Vec3& outward) {
    const Vec3& p = mesh_.positions[a];
    if (dot(cross(mesh_.positions[b] - p, mesh_.positions[c] - p), outward) < 0) std::swap(b, c);
    mesh_.triangles.push_back({a, b, c});
  }

  void add_tetrahedron(const std::array<std::uint32_t, 4>& p) {
    std::vector<std::uint32_t> in, out;
    for (const std::uint32_t v : p) (inside(v) ? in : out).push_back(v);
    if (in.empty() || out.empty()) return;
    Vec3 outward;
    for (const std::uint32_t v : out) outward += points_[v] / static_cast<double>(out.size());
    for (const std::uint32_t v : in) outward -= points_[v] / static_cast<double>(in.size());
    if (in.size() == 2) {
      const std::uint32_t a = crossing(in[0], out[0]), b = crossing(in[0], out[1]),
                          c = crossing(in[1], out[1]), d = crossing(in[1], out[0]);
      add_triangle(a, b, c, outward);
      add_triangle(a, c, d, outward);
    } else {
      const std::uint32_t tip = in.size() == 1 ? in[0] : out[0];
      const std::vector<std::uint32_t>& base = in.size() == 1 ? out : in;
      add_triangle(crossing(tip, base[0]), crossing(tip, base[1]), crossing(tip, base[2]), outward);
    }
  }

  int cells_;
  std::vector<Vec3> points_;
  std::vector<double> values_;
  std::unordered_map<std::uint64_t, std::uint32_t> crossings_;
  TriangleMesh mesh_;
};

}  // namespace

TriangleMesh gyroid(int cells, double periods) {
  const double k = std::numbers::pi * periods;
  return MarchingTetrahedra(cells,
                            [k](const Vec3& p) {
                              const double wave = std::sin(k * p.x) * std::cos(k * p.y) +
                                                  std::sin(k * p.y) * std::cos(k * p.z) +
                                                  std::sin(k * p.z) * std::cos(k * p.x);
                              return std::max(wave / k, norm(p) - 0.93);
                            })
      .run();
}

}  // namespace nmc::corpus
