// SPDX-License-Identifier: Apache-2.0
#include "encoder/condition/orient.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace nmc::conditioning {

void turn_triangles(WorkingMesh& mesh, std::vector<std::uint32_t>& opposite,
                    const std::vector<std::uint8_t>& turn) {
  // (a, b, c) becomes (a, c, b): half-edge ab (0) is now ba, the last one; bc (1) is now cb, still the middle
  // one.
  const auto renamed = [&](std::uint32_t h) {
    if (h == kNone || !turn[h / 3]) return h;
    return h % 3 == 0 ? h + 2 : h % 3 == 2 ? h - 2 : h;
  };
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    std::array<std::uint32_t, 3> partners = {renamed(opposite[3 * t]), renamed(opposite[3 * t + 1]),
                                             renamed(opposite[3 * t + 2])};
    if (turn[t]) {
      std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
      std::swap(mesh.stored[t][1], mesh.stored[t][2]);
      std::swap(partners[0], partners[2]);
    }
    for (std::uint32_t k = 0; k < 3; ++k) opposite[3 * t + k] = partners[k];
  }
}

void orient(WorkingMesh& mesh, std::vector<std::uint32_t>& opposite) {
  const std::size_t triangle_count = mesh.triangles.size();
  bool all_agree = true;
  for (std::uint32_t h = 0; h < opposite.size() && all_agree; ++h)
    all_agree = opposite[h] == kNone || tail_of(mesh.triangles, h) != tail_of(mesh.triangles, opposite[h]);
  if (all_agree) return;

  enum : std::uint8_t { kAsStored = 0, kTurned = 1, kUnseen = 2 };
  std::vector<std::uint8_t> side(triangle_count, kUnseen);
  std::vector<std::uint32_t> piece;  // the triangles of one piece in breadth-first order
  for (std::uint32_t seed = 0; seed < triangle_count; ++seed) {
    if (side[seed] != kUnseen) continue;
    piece.assign(1, seed);
    side[seed] = kAsStored;
    bool orientable = true;
    for (std::size_t next = 0; next < piece.size(); ++next) {
      const std::uint32_t t = piece[next];
      // Neighbours in the order of their numbers: the order of half-edges would change when t is turned.
      std::array<std::uint32_t, 3> around = {3 * t, 3 * t + 1, 3 * t + 2};
      std::sort(around.begin(), around.end(),
                [&](std::uint32_t a, std::uint32_t b) { return opposite[a] < opposite[b]; });
      for (const std::uint32_t h : around) {
        const std::uint32_t other = opposite[h];
        if (other == kNone) continue;
        const bool same_way = tail_of(mesh.triangles, h) == tail_of(mesh.triangles, other);
        const auto wanted = static_cast<std::uint8_t>(side[t] ^ (same_way ? 1 : 0));
        if (side[other / 3] == kUnseen) {
          side[other / 3] = wanted;
          piece.push_back(other / 3);
        } else if (side[other / 3] != wanted) {
          if (mesh.report.cut_edges == 0)
            mesh.note(
                fmt::format("the surface cannot be oriented; opened at the edge between vertices {} and {}",
                            tail_of(mesh.stored, h), head_of(mesh.stored, h)));
          ++mesh.report.cut_edges;
          orientable = false;
          opposite[h] = opposite[other] = kNone;
        }
      }
    }
    mesh.report.non_orientable_components += !orientable;
    double turned_area = 0, kept_area = 0;
    for (const std::uint32_t t : piece)
      (side[t] == kTurned ? turned_area : kept_area) += norm(mesh.area_normal(t));
    if (turned_area > kept_area)
      for (const std::uint32_t t : piece) side[t] ^= 1;
  }

  for (std::uint32_t t = 0; t < triangle_count; ++t) {
    if (side[t] != kTurned) continue;
    if (mesh.report.reoriented_triangles++ == 0)
      mesh.note(fmt::format("triangle {} is oriented against its neighbours", mesh.source[t]));
  }
  turn_triangles(mesh, opposite, side);
}

}  // namespace nmc::conditioning
