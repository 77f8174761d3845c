// SPDX-License-Identifier: Apache-2.0
#include "decoder/adaptive/adaptive_mesh.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "libnmc/common/vec3.h"
#include "tests/unit/common/small_meshes.h"

using namespace nmc;
using namespace nmc::test;

namespace {

/// A level with positions of the test's choice.
struct FullMesh {
  int level = 0;
  std::vector<std::uint32_t> triangles;
  std::vector<double> positions;

  Vec3 point(std::uint32_t v) const { return {positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]}; }
};

/// `base` split `level` times at the middles of edges, then moved by `shape`.
FullMesh make_mesh(const SmallMesh& base, const std::vector<Vec3>& corners, int level,
                   const std::function<Vec3(const Vec3&)>& shape) {
  std::vector<LevelTopology> levels(static_cast<std::size_t>(level) + 1);
  REQUIRE(build(base, levels[0]).ok());
  std::vector<Vec3> points = corners;
  for (std::size_t l = 0; l < static_cast<std::size_t>(level); ++l) {
    for (std::uint32_t e = 0; e < levels[l].edge_count; ++e) {
      points.push_back(0.5 *
                       (points[levels[l].edge_vertices[2 * e]] + points[levels[l].edge_vertices[2 * e + 1]]));
    }
    REQUIRE(subdivide(levels[l], false, levels[l + 1]).ok());
  }
  FullMesh mesh;
  mesh.level = level;
  mesh.triangles.assign(levels.back().face_vertices.begin(), levels.back().face_vertices.end());
  for (const Vec3& p : points) {
    const Vec3 q = shape(p);
    mesh.positions.insert(mesh.positions.end(), {q.x, q.y, q.z});
  }
  return mesh;
}

FullMesh sheet(int level, const std::function<double(double, double)>& height) {
  const SmallMesh base = grid(3, 2, false);
  std::vector<Vec3> corners;
  for (std::uint32_t j = 0; j <= 2; ++j)
    for (std::uint32_t i = 0; i <= 3; ++i) corners.push_back({double(i), double(j), 0});
  return make_mesh(base, corners, level, [&](const Vec3& p) { return Vec3{p.x, p.y, height(p.x, p.y)}; });
}

double bump(double x, double y) {
  const double dx = x - 1.1, dy = y - 0.7;
  return 0.4 * std::exp(-20 * (dx * dx + dy * dy));
}

/// A tetrahedron blown up to a sphere with a dent.
FullMesh dented_sphere(int level) {
  const std::vector<Vec3> corners = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  return make_mesh(tetrahedron(), corners, level, [](const Vec3& p) {
    const Vec3 unit = normalized(p);
    return (1 - 0.3 * std::exp(-30 * squared_norm(unit - normalized(Vec3{1, 0.4, 0.2})))) * unit;
  });
}

/// Directed edges without a partner; an edge that occurs twice in one direction fails.
std::vector<std::pair<std::uint32_t, std::uint32_t>> open_edges(const AdaptiveMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> count;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::pair edge{mesh.triangles[t + k], mesh.triangles[t + (k + 1) % 3]};
      INFO("edge " << edge.first << " to " << edge.second);
      CHECK(++count[edge] == 1);
    }
  }
  std::vector<std::pair<std::uint32_t, std::uint32_t>> open;
  for (const auto& [edge, unused] : count)
    if (!count.count({edge.second, edge.first})) open.push_back(edge);
  return open;
}

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const double length = squared_norm(b - a);
  const double t = length > 0 ? std::clamp(dot(p - a, b - a) / length, 0.0, 1.0) : 0;
  return distance(p, a + t * (b - a));
}

double distance_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 n = cross(b - a, c - a);
  const double area = squared_norm(n);
  const double u = dot(cross(b - p, c - p), n), v = dot(cross(c - p, a - p), n),
               w = dot(cross(a - p, b - p), n);
  if (area > 0 && u >= 0 && v >= 0 && w >= 0) return std::fabs(dot(p - a, n)) / std::sqrt(area);
  return std::min({distance_to_segment(p, a, b), distance_to_segment(p, b, c), distance_to_segment(p, c, a)});
}

using Triangle = std::array<Vec3, 3>;

std::vector<Triangle> triangles_of(const FullMesh& mesh) {
  std::vector<Triangle> out;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3)
    out.push_back({mesh.point(mesh.triangles[t]), mesh.point(mesh.triangles[t + 1]),
                   mesh.point(mesh.triangles[t + 2])});
  return out;
}

std::vector<Triangle> triangles_of(const FullMesh& full, const AdaptiveMesh& mesh) {
  const auto at = [&](std::size_t i) { return full.point(mesh.source_vertices[mesh.triangles[i]]); };
  std::vector<Triangle> out;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) out.push_back({at(t), at(t + 1), at(t + 2)});
  return out;
}

/// Largest distance of a grid of points on `from` to the surface `to`.
double one_sided_distance(const std::vector<Triangle>& from, const std::vector<Triangle>& to, int steps) {
  double largest = 0;
  for (const Triangle& t : from) {
    for (int i = 0; i <= steps; ++i) {
      for (int j = 0; i + j <= steps; ++j) {
        const double u = double(i) / steps, v = double(j) / steps;
        const Vec3 p = u * t[0] + v * t[1] + (1 - u - v) * t[2];
        double nearest = 1e300;
        for (const Triangle& s : to) nearest = std::min(nearest, distance_to_triangle(p, s[0], s[1], s[2]));
        largest = std::max(largest, nearest);
      }
    }
  }
  return largest;
}

}  // namespace

TEST_CASE("a flat surface becomes its base mesh", "[adaptive]") {
  const FullMesh full = sheet(4, [](double x, double y) { return 0.25 * x - 0.5 * y; });
  const AdaptiveMesh mesh = extract_adaptive(full.triangles, full.positions, full.level, 0);
  CHECK(mesh.triangles.size() == 3 * 12);
  CHECK(mesh.source_vertices.size() == 12);
  CHECK(mesh.largest_deviation == 0);
}

TEST_CASE("with a tolerance of zero a curved surface stays as it is", "[adaptive]") {
  const FullMesh full = dented_sphere(3);
  const AdaptiveMesh mesh = extract_adaptive(full.triangles, full.positions, full.level, 0);
  CHECK(mesh.triangles == full.triangles);
  CHECK(mesh.source_vertices.size() == full.positions.size() / 3);
}

TEST_CASE("level 0 has nothing to leave out", "[adaptive]") {
  const FullMesh full = dented_sphere(0);
  CHECK(extract_adaptive(full.triangles, full.positions, 0, 10).triangles == full.triangles);
}

TEST_CASE("a closed surface stays closed and an open one keeps its boundary", "[adaptive]") {
  for (const double tolerance : {0.2, 0.05, 0.02, 0.01, 0.005, 0.002, 0.0005}) {
    INFO("tolerance " << tolerance);
    const FullMesh sphere = dented_sphere(5);
    CHECK(open_edges(extract_adaptive(sphere.triangles, sphere.positions, sphere.level, tolerance)).empty());
    const FullMesh open = sheet(5, bump);
    const AdaptiveMesh mesh = extract_adaptive(open.triangles, open.positions, open.level, tolerance);
    double length = 0;
    for (const auto& [a, b] : open_edges(mesh)) {
      const Vec3 p = open.point(mesh.source_vertices[a]), q = open.point(mesh.source_vertices[b]);
      length += std::hypot(q.x - p.x, q.y - p.y);
    }
    CHECK(length == Approx(10).epsilon(1e-12));
  }
}

TEST_CASE("the deviation told is never passed, both ways, and is within the tolerance", "[adaptive]") {
  for (const double tolerance : {0.1, 0.03, 0.01}) {
    for (const FullMesh& full : {dented_sphere(4), sheet(3, bump)}) {
      const AdaptiveMesh mesh = extract_adaptive(full.triangles, full.positions, full.level, tolerance);
      INFO("tolerance " << tolerance << ", " << mesh.triangles.size() / 3 << " of "
                        << full.triangles.size() / 3);
      CHECK(mesh.triangles.size() < full.triangles.size());
      CHECK(mesh.largest_deviation <= tolerance);
      const auto before = triangles_of(full), after = triangles_of(full, mesh);
      CHECK(one_sided_distance(before, after, 2) <= mesh.largest_deviation * (1 + 1e-12));
      CHECK(one_sided_distance(after, before, 8) <= mesh.largest_deviation * (1 + 1e-12));
    }
  }
}

TEST_CASE("the deviation told is the largest over the cut faces' own edges, not only over vertices",
          "[adaptive]") {
  // One base face beside another, split once. The edge that they share is bent far enough to be split, and
  // the inner edges of the first face keep it from being flat: the face is cut along its median, and the full
  // mesh crosses that cut between vertices.
  SmallMesh base{"two faces", 4, {{0, 1, 2}, {0, 2, 3}}, {}};
  FullMesh full =
      make_mesh(base, {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, 1, [](const Vec3& p) { return p; });
  // The odd vertices of the first face: 4 of the edge (1, 2), 5 of (2, 0), which is shared, 6 of (0, 1).
  full.positions[3 * 4 + 2] = 0.09;
  full.positions[3 * 6 + 2] = 0.09;
  full.positions[3 * 5 + 2] = -0.095;
  // With the shared edge split, the median from corner 1 passes the middle of (4, 6), at height 0.09, at
  // -0.0475.
  const AdaptiveMesh whole = extract_adaptive(full.triangles, full.positions, 1, 0.1);
  CHECK(whole.triangles.size() == 3 * 2);
  CHECK(whole.largest_deviation == Approx(0.095));
  // The other face needs its edges split; the first one would be cut, off by 0.1375 there, and is split
  // instead.
  full.positions[3 * 7 + 2] = full.positions[3 * 8 + 2] = 0.5;
  const AdaptiveMesh split = extract_adaptive(full.triangles, full.positions, 1, 0.1);
  CHECK(split.triangles.size() == 3 * 8);
  const AdaptiveMesh cut = extract_adaptive(full.triangles, full.positions, 1, 0.14);
  CHECK(cut.triangles.size() == 3 * 6);
  CHECK(cut.largest_deviation == Approx(0.1375));
}

TEST_CASE("triangles gather where the detail is", "[adaptive]") {
  const FullMesh full = sheet(6, bump);
  const AdaptiveMesh mesh = extract_adaptive(full.triangles, full.positions, full.level, 0.002);
  std::size_t near = 0;
  for (const std::uint32_t v : mesh.source_vertices) {
    const Vec3 p = full.point(v);
    near += std::hypot(p.x - 1.1, p.y - 0.7) < 0.6;
  }
  INFO(mesh.triangles.size() / 3 << " of " << full.triangles.size() / 3 << " triangles");
  CHECK(mesh.triangles.size() * 10 < full.triangles.size());
  CHECK(near * 10 > mesh.source_vertices.size() * 8);
}

TEST_CASE("a larger tolerance never takes more triangles on a smooth surface", "[adaptive]") {
  const FullMesh full = dented_sphere(5);
  std::size_t before = 0;
  for (const double tolerance : {0.3, 0.1, 0.03, 0.01, 0.003, 0.001}) {
    const AdaptiveMesh mesh = extract_adaptive(full.triangles, full.positions, full.level, tolerance);
    INFO("tolerance " << tolerance);
    CHECK(mesh.triangles.size() >= before);
    before = mesh.triangles.size();
  }
}
