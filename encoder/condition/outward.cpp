// SPDX-License-Identifier: Apache-2.0
#include "encoder/condition/outward.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

#include "encoder/condition/pieces.h"
#include "encoder/condition/sides.h"
#include "encoder/core/parallel.h"
#include "encoder/spatial/surface_index.h"

namespace nmc::conditioning {

namespace {

/// Up to this many closed components, boxes are compared pairwise to see which can hold another at all; with
/// more, all are indexed.
constexpr std::size_t kPairwiseLimit = 4000;
constexpr int kMaximumCrossings = 1 << 14;
/// Places on a piece that are tried until one does not touch another piece.
constexpr std::size_t kOrigins = 8;

bool box_holds(const BoundingBox& outer, const BoundingBox& inner) {
  for (int k = 0; k < 3; ++k)
    if (outer.minimum[k] > inner.minimum[k] || outer.maximum[k] < inner.maximum[k]) return false;
  return true;
}

/// The closed pieces around `inner`, one of them, by the parity of three rays from one of its triangles.
std::vector<std::uint32_t> pieces_around(const WorkingMesh& mesh, const SurfaceIndex& walls,
                                         const std::vector<std::uint32_t>& piece_of_wall,
                                         const std::vector<std::uint32_t>& triangles, std::uint32_t inner) {
  // Directions that no modelled face or edge is likely to follow.
  const std::array<Vec3, 3> directions = {Vec3{0.8191, 0.3217, 0.4752}, Vec3{-0.2857, 0.7643, -0.5781},
                                          Vec3{0.4139, -0.6043, 0.6808}};
  const double touching = 1e-9 * mesh.report.diagonal;
  std::vector<SurfacePoint> hits;
  for (std::size_t attempt = 0; attempt < kOrigins; ++attempt) {
    const Triangle& t = mesh.triangles[triangles[attempt * triangles.size() / kOrigins]];
    // Added so that the triangle turned around, (0, 2, 1), has the same origin to the last bit.
    const Vec3 origin = (mesh.positions[t[0]] + (mesh.positions[t[1]] + mesh.positions[t[2]])) / 3;
    std::vector<std::uint32_t> inside;  // one entry per ray and piece
    bool on_wall = false;
    for (const Vec3& direction : directions) {
      walls.all_hits(origin, direction, -touching, std::numeric_limits<double>::infinity(), kMaximumCrossings,
                     hits);
      std::vector<std::uint32_t> crossed;
      for (const SurfacePoint& hit : hits) {
        const std::uint32_t piece = piece_of_wall[hit.triangle];
        if (piece == inner) continue;
        on_wall = on_wall || hit.t < touching;
        crossed.push_back(piece);
      }
      std::sort(crossed.begin(), crossed.end());
      for (std::size_t a = 0; a < crossed.size();) {
        const auto b = static_cast<std::size_t>(std::upper_bound(crossed.begin(), crossed.end(), crossed[a]) -
                                                crossed.begin());
        if ((b - a) % 2 == 1) inside.push_back(crossed[a]);
        a = b;
      }
    }
    if (on_wall) continue;  // on the surface of another piece there is no inside
    std::sort(inside.begin(), inside.end());
    std::vector<std::uint32_t> majority;
    for (std::size_t k = 0; k + 1 < inside.size(); ++k)
      if (inside[k] == inside[k + 1] && (majority.empty() || majority.back() != inside[k]))
        majority.push_back(inside[k]);
    return majority;
  }
  return {};
}

/// For every piece the closed piece of the largest box that it lies in, or kNone.
std::vector<std::uint32_t> outermost_containers(const WorkingMesh& mesh, const Pieces& pieces) {
  const std::size_t piece_count = pieces.list.size();
  std::vector<std::uint32_t> container(piece_count, kNone);
  std::vector<std::uint32_t> closed;
  for (std::uint32_t p = 0; p < piece_count; ++p)
    if (pieces.list[p].is_closed) closed.push_back(p);
  if (closed.size() < 2) return container;

  std::vector<std::uint8_t> may_hold(piece_count, closed.size() > kPairwiseLimit);
  std::vector<std::uint8_t> may_be_held(piece_count, closed.size() > kPairwiseLimit);
  if (closed.size() <= kPairwiseLimit)
    for (const std::uint32_t outer : closed)
      for (const std::uint32_t inner : closed)
        if (outer != inner && box_holds(pieces.list[outer].box, pieces.list[inner].box))
          may_hold[outer] = may_be_held[inner] = 1;

  std::vector<Triangle> walls;
  std::vector<std::uint32_t> piece_of_wall;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint32_t p = pieces.of_triangle[t];
    if (!pieces.list[p].is_closed || !may_hold[p]) continue;
    walls.push_back(mesh.triangles[t]);
    piece_of_wall.push_back(p);
  }
  if (walls.empty()) return container;
  const SurfaceIndex index(mesh.positions, walls);

  std::vector<std::vector<std::uint32_t>> triangles_of(piece_count);  // of pieces that may be held
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    if (may_be_held[pieces.of_triangle[t]]) triangles_of[pieces.of_triangle[t]].push_back(t);

  // Largest first.
  const auto rank = [&](std::uint32_t p) {
    return std::pair(-squared_norm(pieces.list[p].box.maximum - pieces.list[p].box.minimum), p);
  };
  parallel_for(closed.size(), [&](std::size_t i) {
    const std::uint32_t inner = closed[i];
    if (!may_be_held[inner]) return;
    for (const std::uint32_t piece : pieces_around(mesh, index, piece_of_wall, triangles_of[inner], inner))
      if (rank(piece) < rank(inner) && box_holds(pieces.list[piece].box, pieces.list[inner].box) &&
          (container[inner] == kNone || rank(piece) < rank(container[inner])))
        container[inner] = piece;
  });
  return container;
}

}  // namespace

std::vector<std::uint8_t> turn_outward(WorkingMesh& mesh, std::vector<std::uint32_t>& opposite) {
  const Pieces pieces = find_pieces(mesh, opposite);
  std::vector<std::uint8_t> turned(pieces.list.size(), 0);
  const bool any_negative = std::any_of(pieces.list.begin(), pieces.list.end(),
                                        [](const Piece& p) { return p.is_closed && p.volume < 0; });
  if (!any_negative) return turned;
  const std::vector<std::uint32_t> container = outermost_containers(mesh, pieces);
  const auto is_inside_out = [&](std::uint32_t p) {
    const Piece& piece = pieces.list[p];
    const double extent = piece.box.diagonal();
    // A volume below rounding (a sheet folded onto itself) has no sign.
    return piece.is_closed && piece.volume < -1e-12 * extent * piece.area;
  };
  for (std::uint32_t p = 0; p < pieces.list.size(); ++p) {
    // Containers are larger than what they hold, so the chain ends. It has more than one link only where rays
    // disagree, as between components that cross each other.
    std::uint32_t decisive = p;
    while (container[decisive] != kNone) decisive = container[decisive];
    turned[p] = is_inside_out(decisive);
    if (!turned[p]) continue;
    ++mesh.report.turned_components;
    mesh.note(Defect::kInsideOut, [&] {
      return fmt::format("the closed component of triangle {} is inside out",
                         mesh.source[pieces.list[p].first_triangle]);
    });
  }
  if (mesh.report.turned_components == 0) return turned;
  std::vector<std::uint8_t> turn(mesh.triangles.size());
  for (std::size_t t = 0; t < turn.size(); ++t) turn[t] = turned[pieces.of_triangle[t]];
  turn_triangles(mesh, opposite, turn);
  return turned;
}

}  // namespace nmc::conditioning
