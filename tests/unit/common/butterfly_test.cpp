// SPDX-License-Identifier: Apache-2.0
#include "libnmc/common/butterfly.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <utility>

#include "libnmc/common/local_frame.h"
#include "libnmc/common/reconstruct.h"
#include "tests/unit/common/small_meshes.h"

namespace nmc {
namespace {

using test::SmallMesh;

struct Levels {
  LevelTopology base, level;
  RingWeights ring_weights;
};

Levels build_levels(const SmallMesh& mesh, int level) {
  Levels levels;
  REQUIRE(test::build(mesh, levels.base).ok());
  REQUIRE(levels.ring_weights.build(levels.base).ok());
  REQUIRE(test::build(mesh, levels.level).ok());
  for (int l = 0; l < level; ++l) {
    LevelTopology fine;
    REQUIRE(subdivide(levels.level, false, fine).ok());
    levels.level = std::move(fine);
  }
  return levels;
}

std::map<std::uint32_t, double> stencil(const Levels& levels, std::uint32_t edge, double tension) {
  std::map<std::uint32_t, double> weights;
  visit_stencil(levels.level, levels.ring_weights, edge, Tension{tension},
                [&](std::uint32_t vertex, double weight) { weights[vertex] += weight; });
  return weights;
}

std::uint32_t edge_between(const LevelTopology& t, std::uint32_t a, std::uint32_t b) {
  for (std::uint32_t e = 0; e < t.edge_count; ++e) {
    const std::uint32_t p = t.edge_vertices[2 * e], q = t.edge_vertices[2 * e + 1];
    if ((p == a && q == b) || (p == b && q == a)) return e;
  }
  return kNone;
}

TEST_CASE("butterfly: the stencil as weights agrees with the prediction, and sums to 1", "[butterfly]") {
  test::Random random(1);
  for (const SmallMesh& mesh : test::all_small_meshes()) {
    for (int l = 0; l <= 2; ++l) {
      const Levels levels = build_levels(mesh, l);
      std::vector<Vec3> x(levels.level.vertex_count);
      for (Vec3& p : x) p = random.point();
      double worst = 0, worst_sum = 0;
      for (std::uint32_t e = 0; e < levels.level.edge_count; ++e) {
        for (const double tension : {0.0, 0.25, 0.75, 1.0}) {
          Vec3 sum;
          double total = 0;
          for (const auto& [vertex, weight] : stencil(levels, e, tension)) {
            sum += weight * x[vertex];
            total += weight;
          }
          const Vec3 p = predict_odd_vertex(levels.level, levels.ring_weights, e, Tension{tension}, x.data());
          worst = std::max(worst, distance(p, sum));
          worst_sum = std::max(worst_sum, std::abs(total - 1));
        }
      }
      INFO(mesh.name << ", level " << l);
      CHECK(worst < 1e-14);
      CHECK(worst_sum < 1e-14);
    }
  }
}

TEST_CASE("butterfly: midpoint at zero tension, to the last bit", "[butterfly]") {
  test::Random random(2);
  const Levels levels = build_levels(test::creased_bipyramid(), 1);
  std::vector<Vec3> x(levels.level.vertex_count);
  for (Vec3& p : x) p = random.point();
  for (std::uint32_t e = 0; e < levels.level.edge_count; ++e) {
    const Vec3 middle =
        0.5 * (x[levels.level.edge_vertices[2 * e]] + x[levels.level.edge_vertices[2 * e + 1]]);
    CHECK(predict_odd_vertex(levels.level, levels.ring_weights, e, Tension{0}, x.data()) == middle);
  }
}

TEST_CASE("butterfly: a regular grid reproduces cubic polynomials", "[butterfly]") {
  const std::uint32_t n = 8;
  const Levels levels = build_levels(test::grid(n, n, false), 0);
  const auto cubic = [](double u, double v) {
    return 0.3 + u - 2 * v + u * u - u * v + 0.5 * v * v + u * u * u - 2 * u * u * v + 0.7 * u * v * v -
           v * v * v;
  };
  std::vector<Vec3> x;
  for (std::uint32_t j = 0; j <= n; ++j)
    for (std::uint32_t i = 0; i <= n; ++i) x.push_back({double(i), double(j), cubic(i, j)});
  int checked = 0;
  for (std::uint32_t e = 0; e < levels.level.edge_count; ++e) {
    const Vec3 a = x[levels.level.edge_vertices[2 * e]], b = x[levels.level.edge_vertices[2 * e + 1]];
    const Vec3 middle = 0.5 * (a + b);
    if (middle.x < 2 || middle.y < 2 || middle.x > n - 2 || middle.y > n - 2) continue;
    const Vec3 p = predict_odd_vertex(levels.level, levels.ring_weights, e, Tension{1}, x.data());
    CHECK(p.x == Approx(middle.x).margin(1e-12));
    CHECK(p.y == Approx(middle.y).margin(1e-12));
    CHECK(p.z == Approx(cubic(middle.x, middle.y)).margin(1e-10));
    ++checked;
  }
  CHECK(checked > 40);
}

TEST_CASE("butterfly: the weights around an extraordinary vertex are those of the paper", "[butterfly]") {
  for (const std::uint32_t n : {3u, 4u, 5u, 7u, 8u, 12u, 13u, 100u, 255u, 256u}) {
    const Levels levels =
        build_levels(test::bipyramid(n), 1);  // level 1: the other ends of the spokes are regular
    const std::uint32_t spoke =
        edge_between(levels.level, 0, levels.base.vertex_count + edge_between(levels.base, 0, 1));
    REQUIRE(spoke != kNone);
    const auto weights = stencil(levels, spoke, 1);
    CHECK(levels.ring_weights.valence(0) == n);
    for (std::uint32_t i = 0; i < n; ++i) {
      const double turn = 2 * std::acos(-1.0) * i / n;
      double expected = (0.25 + std::cos(turn) + 0.5 * std::cos(2 * turn)) / n;
      if (n == 3) expected = i == 0 ? 5.0 / 12 : -1.0 / 12;
      if (n == 4) expected = i == 0 ? 3.0 / 8 : i == 2 ? -1.0 / 8 : 0;
      const std::uint32_t neighbor = levels.base.vertex_count + edge_between(levels.base, 0, 1 + i);
      const double weight = weights.count(neighbor) ? weights.at(neighbor) : 0;
      INFO("valence " << n << ", neighbour " << i << ": " << weight << ", expected " << expected);
      CHECK(std::abs(weight - expected) < 4e-16);
    }
    CHECK(weights.at(0) == Approx(0.75).margin(1e-13));
  }
}

TEST_CASE("butterfly: between two extraordinary vertices the mean of both rings", "[butterfly]") {
  const Levels levels = build_levels(test::bipyramid(5), 0);  // apex 5, rim 4
  const auto weights = stencil(levels, edge_between(levels.level, 0, 1), 1);
  // Apex ring: 1, 2, ... 5 from vertex 1. Rim ring of vertex 1: 0 first, then two places on its opposite,
  // vertex 6.
  const double c1 = std::cos(2 * std::acos(-1.0) / 5), c2 = std::cos(4 * std::acos(-1.0) / 5);
  CHECK(weights.at(0) == Approx(0.5 * (0.75 + 0.375)));
  CHECK(weights.at(1) == Approx(0.5 * (1.75 / 5 + 0.75)));
  CHECK(weights.at(2) == Approx(0.5 * (0.25 + c1 + 0.5 * c2) / 5).margin(1e-15));
  CHECK(weights.at(3) == Approx(0.5 * (0.25 + c2 + 0.5 * c1) / 5).margin(1e-15));
  CHECK(weights.at(6) == Approx(0.5 * -0.125));
}

TEST_CASE("butterfly: curves use the four-point rule and its one-sided form", "[butterfly]") {
  const Levels levels = build_levels(test::creased_bipyramid(), 2);
  const LevelTopology& t = levels.level;
  int four_point = 0, one_sided = 0;
  for (std::uint32_t e = 0; e < t.edge_count; ++e) {
    if (!t.is_curve(e)) continue;
    const std::uint32_t a = t.edge_vertices[2 * e], b = t.edge_vertices[2 * e + 1];
    const auto weights = stencil(levels, e, 1);
    const int smooth_ends = (t.curve_degree(a) == 2) + (t.curve_degree(b) == 2);
    if (smooth_ends == 2) {
      ++four_point;
      CHECK(weights.size() == 4);
      CHECK(weights.at(a) == 9.0 / 16);
      CHECK(weights.at(b) == 9.0 / 16);
      for (const auto& [vertex, weight] : weights) {
        CHECK(t.curve_degree(vertex) > 0);
        if (vertex != a && vertex != b) CHECK(weight == -1.0 / 16);
      }
    } else if (smooth_ends == 1) {
      ++one_sided;
      CHECK(weights.size() == 3);
      CHECK(weights.at(t.curve_degree(a) == 2 ? b : a) == 0.375);
      CHECK(weights.at(t.curve_degree(a) == 2 ? a : b) == 0.75);
    }
  }
  CHECK(four_point > 10);
  CHECK(one_sided >= 4);
}

TEST_CASE("butterfly: a boundary reproduces cubics along itself and quadratics at a corner", "[butterfly]") {
  // A strip whose corners are smooth for the four-point rule: all boundary vertices have two curve edges.
  const Levels levels = build_levels(test::grid(8, 2, false), 0);
  std::vector<Vec3> x;
  const auto cubic = [](double u) { return 1 - u + 0.5 * u * u - 0.1 * u * u * u; };
  for (int j = 0; j <= 2; ++j)
    for (int i = 0; i <= 8; ++i) x.push_back({double(i), double(j), cubic(i)});
  for (std::uint32_t i = 2; i < 6; ++i) {
    const std::uint32_t e = edge_between(levels.level, i, i + 1);
    const Vec3 p = predict_odd_vertex(levels.level, levels.ring_weights, e, Tension{1}, x.data());
    CHECK(p.z == Approx(cubic(i + 0.5)).margin(1e-12));
  }
  // At a corner of creases the one-sided rule is exact for quadratics.
  SmallMesh creased = test::grid(4, 4, false);
  creased.creases = {{12, 13}, {13, 14}, {12, 17}, {12, 7}};  // three at vertex 12, the middle of the sheet
  const Levels crease_levels = build_levels(creased, 0);
  std::vector<Vec3> y;
  const auto quadratic = [](double u, double v) { return u * u - 2 * u + v * v; };
  for (int j = 0; j <= 4; ++j)
    for (int i = 0; i <= 4; ++i) y.push_back({double(i), double(j), quadratic(i, j)});
  const std::uint32_t e = edge_between(crease_levels.level, 12, 13);
  const Vec3 p = predict_odd_vertex(crease_levels.level, crease_levels.ring_weights, e, Tension{1}, y.data());
  CHECK(p.z == Approx(quadratic(2.5, 2)).margin(1e-12));
}

TEST_CASE("butterfly: reflection at curves keeps a plane plane and its grid a grid", "[butterfly]") {
  SmallMesh sheet = test::grid(4, 4, false);
  sheet.creases = {{10, 11}, {11, 12}, {12, 17}};
  Levels levels = build_levels(sheet, 0);
  std::vector<Vec3> x;
  for (int j = 0; j <= 4; ++j)
    for (int i = 0; i <= 4; ++i) x.push_back({i + 0.25 * j, 2.0 * j, 3 + i - 0.5 * j});
  double worst = 0;
  for (std::uint32_t e = 0; e < levels.level.edge_count; ++e) {
    const std::uint32_t a = levels.level.edge_vertices[2 * e], b = levels.level.edge_vertices[2 * e + 1];
    const std::uint32_t corners[] = {0, 4, 20, 24};  // the four-point rule rounds the sheet's own corners off
    bool near_corner = false;
    for (const std::uint32_t corner : corners) near_corner = near_corner || a == corner || b == corner;
    if (levels.level.is_curve(e) && near_corner) continue;
    const Vec3 p = predict_odd_vertex(levels.level, levels.ring_weights, e, Tension{1}, x.data());
    if (levels.level.is_boundary(e)) continue;
    if (levels.level.is_curve(e)) {  // bent creases round off too, but stay in the plane
      CHECK(dot(p - x[0], cross(x[1] - x[0], x[5] - x[0])) == Approx(0).margin(1e-12));
      continue;
    }
    worst = std::max(worst, distance(p, 0.5 * (x[a] + x[b])));
  }
  CHECK(worst < 1e-14);
}

TEST_CASE("butterfly: nothing beyond a crease has a part in the prediction", "[butterfly]") {
  SmallMesh sheet = test::grid(4, 4, false);
  for (std::uint32_t i = 0; i < 4; ++i) sheet.creases.push_back({10 + i, 11 + i});  // the middle row
  const Levels levels = build_levels(sheet, 0);
  for (std::uint32_t e = 0; e < levels.level.edge_count; ++e) {
    const std::uint32_t row_a = levels.level.edge_vertices[2 * e] / 5,
                        row_b = levels.level.edge_vertices[2 * e + 1] / 5;
    if (row_a == 2 && row_b == 2) continue;
    for (const auto& [vertex, weight] : stencil(levels, e, 1)) {
      INFO("edge " << e << " vertex " << vertex << " weight " << weight);
      CHECK((row_a <= 2 && row_b <= 2 ? vertex / 5 <= 2 : vertex / 5 >= 2));
    }
  }
}

TEST_CASE("local frame: orthonormal, along the edge, across into the left face", "[local_frame]") {
  test::Random random(3);
  for (const SmallMesh& mesh : test::all_small_meshes()) {
    const Levels levels = build_levels(mesh, 1);
    std::vector<Vec3> x(levels.level.vertex_count);
    for (Vec3& p : x) p = random.point();
    for (std::uint32_t e = 0; e < levels.level.edge_count; ++e) {
      const LocalFrame frame = odd_vertex_frame(levels.level, e, x.data());
      const Vec3 a = x[levels.level.edge_vertices[2 * e]], b = x[levels.level.edge_vertices[2 * e + 1]];
      INFO(mesh.name << ", edge " << e);
      CHECK(norm(frame.normal) == Approx(1));
      CHECK(norm(frame.across) == Approx(1));
      CHECK(dot(frame.normal, frame.along) == Approx(0).margin(1e-12));
      CHECK(dot(frame.along, b - a) == Approx(distance(a, b)));
      if (!levels.level.is_boundary(e)) continue;
      const Vec3 c = x[levels.level.opposite_vertex(e, levels.level.edge_faces[2 * e])];
      CHECK(dot(frame.normal, cross(b - a, c - a)) > 0);
      CHECK(dot(frame.across, c - a) > 0);
    }
  }
}

TEST_CASE("local frame: degenerate neighbourhoods give a fixed normal", "[local_frame]") {
  const Levels levels = build_levels(test::tetrahedron(), 0);
  const std::vector<Vec3> x(4, Vec3{1, 2, 3});
  const LocalFrame frame = odd_vertex_frame(levels.level, 0, x.data());
  CHECK(frame.normal == Vec3{0, 0, 1});
  CHECK(frame.along == Vec3{1, 0, 0});
  CHECK(frame.across == Vec3{0, 1, 0});
}

TEST_CASE("reconstruct: ranges of edges give the same bits as one pass", "[reconstruct]") {
  test::Random random(4);
  const Levels levels = build_levels(test::bipyramid(7), 2);
  const std::uint32_t V = levels.level.vertex_count, E = levels.level.edge_count;
  LevelCoefficients coefficients;
  REQUIRE(coefficients.normal.resize(E));
  for (std::uint32_t e = 0; e < E; ++e) {
    coefficients.normal[e] = static_cast<std::int32_t>(random.uniform(-9, 9));
    if (e % 5 == 3) REQUIRE(coefficients.tangential.push_back({e, static_cast<std::int32_t>(e % 7) - 3, 2}));
  }
  const LevelQuantizer quantizer{0.01, 0.04, Tension{0.75}};
  std::vector<Vec3> whole(V + E), parts(V + E);
  for (std::uint32_t v = 0; v < V; ++v) whole[v] = parts[v] = random.point();
  reconstruct_odd_vertices(levels.level, levels.ring_weights, quantizer, &coefficients, 0, E, whole.data());
  for (std::uint32_t first = 0; first < E; first += 17) {
    reconstruct_odd_vertices(levels.level, levels.ring_weights, quantizer, &coefficients, first,
                             std::min(E, first + 17), parts.data());
  }
  for (std::uint32_t v = 0; v < V + E; ++v) CHECK(whole[v] == parts[v]);

  const LocalFrame frame = odd_vertex_frame(levels.level, 3, whole.data());
  const Vec3 detail = whole[V + 3] - predict_odd_vertex(levels.level, levels.ring_weights, 3,
                                                        quantizer.tension, whole.data());
  CHECK(dot(detail, frame.normal) == Approx(coefficients.normal[3] * 0.01).margin(1e-14));
  CHECK(dot(detail, frame.along) == Approx(coefficients.tangential[0].along * 0.04).margin(1e-14));
  CHECK(dot(detail, frame.across) == Approx(coefficients.tangential[0].across * 0.04).margin(1e-14));
}

TEST_CASE("reconstruct: by way of the coarser level, in any ranges, the same bits", "[reconstruct]") {
  for (const test::SmallMesh& base :
       {test::tetrahedron(), test::bipyramid(7), test::grid(3, 4, true), test::grid(5, 4, false),
        test::creased_tetrahedron(), test::creased_bipyramid(), test::fan(5, true), test::fan(3, false)}) {
    for (const double tension : {0.0, 0.75, 1.0}) {
      test::Random random(9);
      std::vector<LevelTopology> levels(4);
      REQUIRE(test::build(base, levels[0]).ok());
      RingWeights ring_weights;
      REQUIRE(ring_weights.build(levels[0]).ok());
      std::vector<Vec3> x;
      for (std::uint32_t v = 0; v < base.vertex_count; ++v) x.push_back(random.point());
      for (std::size_t l = 0; l + 1 < levels.size(); ++l) {
        const LevelTopology& level = levels[l];
        const std::uint32_t V = level.vertex_count, E = level.edge_count;
        LevelCoefficients coefficients;
        REQUIRE(coefficients.normal.resize(E));
        for (std::uint32_t e = 0; e < E; ++e) {
          coefficients.normal[e] = static_cast<std::int32_t>(random.uniform(-3, 3));
          if (e % 5 == 3)
            REQUIRE(coefficients.tangential.push_back({e, 2, static_cast<std::int32_t>(e % 7) - 3}));
        }
        const LevelQuantizer quantizer{0.01, 0.04, Tension{tension}};
        x.resize(V + E);
        std::vector<Vec3> other = x;
        reconstruct_odd_vertices(level, ring_weights, quantizer, &coefficients, 0, E, x.data());
        if (l > 0) {
          for (std::uint32_t first = 0; first < E; first += 19) {
            reconstruct_odd_vertices_of_split(levels[l - 1], level, ring_weights, quantizer, &coefficients,
                                              first, std::min(E, first + 19), other.data());
          }
          for (std::uint32_t v = 0; v < V + E; ++v) {
            INFO(base.name << " tension " << tension << " level " << l << " vertex " << v);
            CHECK(std::memcmp(&x[v], &other[v], sizeof(Vec3)) == 0);
          }
        }
        REQUIRE(subdivide(level, false, levels[l + 1]).ok());
      }
    }
  }
}

}  // namespace
}  // namespace nmc
