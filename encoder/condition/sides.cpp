// SPDX-License-Identifier: Apache-2.0
#include "encoder/condition/sides.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "encoder/condition/disjoint_sets.h"

namespace nmc::conditioning {

namespace {

/// 1 where the two triangles of a pair run the same way along their edge.
std::uint32_t disagrees(const WorkingMesh& mesh, std::uint32_t a, std::uint32_t b) {
  return tail_of(mesh.triangles, a) == tail_of(mesh.triangles, b) ? 1u : 0u;
}

/// Pairs left over when the others are united, those that agree first; as the lower half-edge of each,
/// ascending.
std::vector<std::uint32_t> stored_seam(const WorkingMesh& mesh, const std::vector<std::uint32_t>& pairs) {
  ParitySets sets(mesh.triangles.size());
  std::vector<std::uint32_t> disagreeing, seam;
  for (std::uint32_t h = 0; h < pairs.size(); ++h) {
    if (pairs[h] == kNone || pairs[h] < h) continue;
    if (disagrees(mesh, h, pairs[h]))
      disagreeing.push_back(h);
    else
      sets.unite(h / 3, pairs[h] / 3, 0);
  }
  for (const std::uint32_t h : disagreeing)
    if (!sets.unite(h / 3, pairs[h] / 3, 1)) seam.push_back(h);
  return seam;
}

/// Pairs of the piece of `seed` at which a breadth-first walk meets itself on the wrong side, as the lower
/// half-edge of each. `side` must hold kUnseen for the piece.
constexpr std::uint8_t kUnseen = 2;
std::vector<std::uint32_t> walked_seam(const WorkingMesh& mesh, const std::vector<std::uint32_t>& pairs,
                                       std::uint32_t seed, std::vector<std::uint8_t>& side) {
  std::vector<std::uint32_t> seam, walk = {seed};
  side[seed] = 0;
  for (std::size_t next = 0; next < walk.size(); ++next) {
    const std::uint32_t t = walk[next];
    // Neighbours in the order of their numbers: that of the half-edges would change when t is turned.
    std::array<std::uint32_t, 3> around = {3 * t, 3 * t + 1, 3 * t + 2};
    std::sort(around.begin(), around.end(),
              [&](std::uint32_t a, std::uint32_t b) { return pairs[a] < pairs[b]; });
    for (const std::uint32_t h : around) {
      const std::uint32_t other = pairs[h];
      if (other == kNone) continue;
      const auto wanted = static_cast<std::uint8_t>(side[t] ^ disagrees(mesh, h, other));
      if (side[other / 3] == kUnseen) {
        side[other / 3] = wanted;
        walk.push_back(other / 3);
      } else if (side[other / 3] != wanted && h < other) {
        seam.push_back(h);  // met from both ends; taken once
      }
    }
  }
  return seam;
}

}  // namespace

Sides::Sides(const WorkingMesh& mesh, const std::vector<std::uint32_t>& pairs)
    : sets_(mesh.triangles.size()), turned_root_(mesh.triangles.size(), 0), area_(mesh.triangles.size(), 0) {
  for (std::uint32_t h = 0; h < pairs.size(); ++h)
    if (pairs[h] != kNone && h < pairs[h]) sets_.unite(h / 3, pairs[h] / 3, disagrees(mesh, h, pairs[h]));
  std::vector<double> turned_area(mesh.triangles.size(), 0);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const ParitySets::Place place = sets_.find(t);
    const double area = norm(mesh.area_normal(t));
    area_[place.root] += area;
    if (place.side) turned_area[place.root] += area;
  }
  for (std::size_t t = 0; t < area_.size(); ++t) turned_root_[t] = turned_area[t] > 0.5 * area_[t];
}

void Sides::join(std::uint32_t a, std::uint32_t b, bool turn_one) {
  ParitySets::Place place_a = sets_.find(a), place_b = sets_.find(b);
  if (place_a.root == place_b.root) return;
  if (place_a.root > place_b.root) {
    std::swap(a, b);
    std::swap(place_a, place_b);
  }
  if (turn_one) {
    const bool first_is_smaller = area_[place_a.root] < area_[place_b.root];
    turned_root_[first_is_smaller ? place_a.root : place_b.root] ^= 1;
  }
  // Root b hangs under root a and keeps its own state relative to the file.
  sets_.unite(place_a.root, place_b.root, turned_root_[place_a.root] ^ turned_root_[place_b.root]);
  area_[place_a.root] += area_[place_b.root];
}

CutEdges open_contradictory_pairs(WorkingMesh& mesh, std::vector<std::uint32_t>& pairs) {
  const std::vector<std::uint32_t> stored = stored_seam(mesh, pairs);
  CutEdges cut;
  if (stored.empty()) return cut;
  DisjointSets pieces(mesh.triangles.size());
  for (std::uint32_t h = 0; h < pairs.size(); ++h)
    if (pairs[h] != kNone && h < pairs[h]) pieces.unite(h / 3, pairs[h] / 3);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> by_piece;  // piece, half-edge
  for (const std::uint32_t h : stored) by_piece.push_back({pieces.find(h / 3), h});
  std::sort(by_piece.begin(), by_piece.end());

  std::vector<std::uint8_t> side(mesh.triangles.size(), kUnseen);
  for (std::size_t i = 0; i < by_piece.size();) {
    std::size_t j = i;
    std::vector<std::uint32_t> seam;
    for (; j < by_piece.size() && by_piece[j].first == by_piece[i].first; ++j)
      seam.push_back(by_piece[j].second);
    const std::vector<std::uint32_t> walked = walked_seam(mesh, pairs, by_piece[i].first, side);
    if (2 * walked.size() < seam.size()) seam = walked;
    mesh.note(Defect::kNotOrientable, [&] {
      return fmt::format("the surface cannot be oriented; opened at the edge between vertices {} and {}",
                         tail_of(mesh.stored, seam[0]), head_of(mesh.stored, seam[0]));
    });
    cut.edges += seam.size();
    ++cut.pieces;
    for (const std::uint32_t h : seam) pairs[h] = pairs[pairs[h]] = kNone;
    i = j;
  }
  return cut;
}

void turn_triangles(WorkingMesh& mesh, std::vector<std::uint32_t>& pairs,
                    const std::vector<std::uint8_t>& turn) {
  // (a, b, c) becomes (a, c, b): half-edge ab (0) is now ba, the last one; bc (1) is now cb, still the middle
  // one.
  const auto renamed = [&](std::uint32_t h) {
    if (h == kNone || !turn[h / 3]) return h;
    return h % 3 == 0 ? h + 2 : h % 3 == 2 ? h - 2 : h;
  };
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    std::array<std::uint32_t, 3> partners = {renamed(pairs[3 * t]), renamed(pairs[3 * t + 1]),
                                             renamed(pairs[3 * t + 2])};
    if (turn[t]) {
      std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
      std::swap(mesh.stored[t][1], mesh.stored[t][2]);
      mesh.is_turned[t] ^= 1;
      std::swap(partners[0], partners[2]);
    }
    for (std::uint32_t k = 0; k < 3; ++k) pairs[3 * t + k] = partners[k];
  }
}

}  // namespace nmc::conditioning
