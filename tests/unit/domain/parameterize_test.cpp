// SPDX-License-Identifier: Apache-2.0
// The whole way: collapse, insertion, relaxation; and that what comes out is a bijection.
#include "encoder/domain/parameterize.h"

#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <numbers>
#include <string>

#include "corpus/generate/random.h"
#include "corpus/generate/shapes.h"
#include "encoder/condition/condition.h"
#include "encoder/core/error.h"
#include "encoder/domain/certificate.h"
#include "encoder/normal_mesh/surface_atlas.h"
#include "encoder/read/mesh_reader.h"
#include "tests/corpus_mesh.h"

namespace nmc {
namespace {

std::string describe(const Certificate& c) {
  return std::to_string(c.flipped) + " flipped, " + std::to_string(c.degenerate) + " degenerate, " +
         std::to_string(c.inconsistent) + " inconsistent, " + std::to_string(c.wound) + " wound, " +
         std::to_string(c.uncovered) + " uncovered, " + std::to_string(c.off_boundary) + " off the boundary";
}

/// Euler characteristic and number of boundary edges' loops' parity are kept by comparing both numbers.
long euler_characteristic(std::size_t vertex_count, const std::vector<Triangle>& triangles) {
  std::vector<std::array<std::uint32_t, 2>> edges;
  std::vector<std::uint8_t> used(vertex_count, 0);
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      used[t[k]] = 1;
      edges.push_back({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
    }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return std::count(used.begin(), used.end(), 1) - static_cast<long>(edges.size()) +
         static_cast<long>(triangles.size());
}

void check_map(const Parameterization& p, const TriangleMesh& input) {
  const Certificate certificate = certify(p);
  INFO(describe(certificate));
  CHECK(certificate.is_bijective());
  CHECK(certificate.area_ratio == Approx(1).epsilon(1e-9));
  CHECK(p.input_vertex_count == input.vertex_count());
  REQUIRE(p.surface->vertex_count() >= input.vertex_count());
  CHECK(std::equal(input.positions.begin(), input.positions.end(), p.surface->positions.begin()));
  CHECK(surface_area(*p.surface) == Approx(surface_area(input)).epsilon(1e-9));
  CHECK(euler_characteristic(p.domain.vertex_count(), p.domain.faces()) ==
        euler_characteristic(input.vertex_count(), input.triangles));
  for (std::size_t i = 0; i < p.base_vertex_ids.size(); ++i)
    CHECK(p.base_positions[i] == p.surface->positions[p.base_vertex_ids[i]]);
}

TEST_CASE("Every hard shape gets a bijective map onto a base of the same topology") {
  struct Case {
    std::string name;
    TriangleMesh mesh;
    std::vector<int> sizes;
  };
  const Case cases[] = {
      {"icosphere", corpus::icosphere(4), {1, 60}},
      {"spiky ball", corpus::spiky_ball(4), {80}},
      {"torus", corpus::torus(60, 30), {1, 40}},
      {"cylinder of aspect 1000", corpus::long_cylinder(1000, 12, 600), {8, 50}},
      {"torus knot", corpus::torus_knot(2, 3, 300, 12), {60}},
      {"Koch surface", corpus::koch_surface(3), {50}},
      {"gear", corpus::gear(), {100}},
      {"comb", corpus::comb(12, 20), {60}},
      {"disk with 60 holes", corpus::disk_with_holes(60), {250}},
      {"perforated plate", corpus::perforated_plate(4, 3), {160}},
      {"terrain", corpus::terrain(40), {4, 30}},
      {"one triangle", {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, {}, {}, {}}, {1}},
  };
  for (const Case& test : cases) {
    INFO(test.name);
    for (const Parameterization& p : parameterize(test.mesh, test.sizes)) {
      INFO("base of " << p.domain.vertex_count());
      check_map(p, test.mesh);
    }
  }
}

TEST_CASE("Bases reach the sizes asked for and their smallest possible size") {
  const auto sphere = parameterize(corpus::icosphere(3), {100, 30, 1});
  CHECK(sphere[0].domain.vertex_count() == 100);
  CHECK(sphere[1].domain.vertex_count() == 30);
  CHECK(sphere[2].domain.vertex_count() <= 6);
  CHECK(sphere[2].domain.vertex_count() >= 4);
  // A disk can be two triangles, a torus needs seven vertices.
  CHECK(parameterize(corpus::terrain(12), {1})[0].domain.vertex_count() <= 6);
  const auto torus = parameterize(corpus::torus(30, 20), {1});
  CHECK(torus[0].domain.vertex_count() >= 7);
  CHECK(torus[0].domain.vertex_count() <= 12);
  // More than there is: the surface itself.
  const TriangleMesh small = corpus::icosphere(1);
  CHECK(parameterize(small, {1000})[0].domain.face_count() == small.triangle_count());
}

TEST_CASE("The bases of one run are nested, whatever order they are asked in") {
  const TriangleMesh mesh = corpus::torus(60, 30);
  const CollapseHistory history = maps_collapse(mesh, {20, 80, 40});
  CHECK(history.base_step_counts[1] < history.base_step_counts[2]);
  CHECK(history.base_step_counts[2] < history.base_step_counts[0]);
  CHECK(history.surface->vertex_count() - history.base_step_counts[1] == 80);
  const Parameterization alone = parameterize(mesh, {80})[0], among = parameterize(mesh, {20, 80, 40})[1];
  CHECK(alone.domain.vertex_count() == among.domain.vertex_count());
}

TEST_CASE("Components stay components, each with its own topology") {
  TriangleMesh mesh = corpus::icosphere(3);
  TriangleMesh ring = corpus::torus(30, 16);
  corpus::translate(ring, {5, 0, 0});
  corpus::append(mesh, ring);
  TriangleMesh sheet = corpus::terrain(16);
  corpus::translate(sheet, {0, 9, 0});
  corpus::append(mesh, sheet);
  const Parameterization p = parameterize(mesh, {40})[0];
  check_map(p, mesh);
  CHECK(p.domain.component_count() == 3);
}

TEST_CASE("Boundary loops map onto boundary edges, and ears keep area") {
  // A strip of two triangles beside a fan: triangles with all corners on the boundary.
  const TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {0, 1, 0}},
                          {{0, 1, 5}, {1, 4, 5}, {1, 2, 4}, {2, 3, 4}},
                          {},
                          {},
                          {}};
  const Parameterization p = parameterize(mesh, {1})[0];
  check_map(p, mesh);
  CHECK(p.surface->vertex_count() > mesh.vertex_count());  // chords are split
}

TEST_CASE("Creases become base edges") {
  const TriangleMesh mesh = corpus::gear(8, 4);
  CollapseOptions options;
  options.crease_angle_degrees = 40;
  const Parameterization p = parameterize(mesh, {60}, options)[0];
  check_map(p, mesh);
  int creases = 0;
  for (std::uint32_t f = 0; f < p.domain.face_count(); ++f)
    for (int k = 0; k < 3; ++k) creases += p.domain.edge_tag(f, k) == EdgeTag::kCrease;
  CHECK(creases > 0);
  // Every sharp edge of the surface lies on a crease edge of the base: both its ends have a zero coordinate
  // there.
  const auto on_crease = [&p](std::uint32_t v) {
    const DomainPoint& at = p.vertex_points[v];
    if (p.domain.cone_at(at) != kNoVertex) return true;
    const auto b = at.barycentric();
    for (int k = 0; k < 3; ++k)
      if (b[k] == 0 && p.domain.edge_tag(at.face, k) == EdgeTag::kCrease) return true;
    return false;
  };
  std::vector<Vec3> normal_of;
  for (const Triangle& t : p.surface->triangles) {
    const auto& x = p.surface->positions;
    normal_of.push_back(normalized(cross(x[t[1]] - x[t[0]], x[t[2]] - x[t[0]])));
  }
  const CornerTable table(p.surface->vertex_count(), p.surface->triangles);
  std::size_t sharp = 0, kept = 0;
  for (CornerTable::Corner c = 0; c < 3 * table.real_face_count(); ++c) {
    const auto d = table.opposite(c);
    if (d < c || dot(normal_of[c / 3], normal_of[d / 3]) > 0.5) continue;
    ++sharp;
    kept +=
        on_crease(table.vertex(CornerTable::next(c))) && on_crease(table.vertex(CornerTable::previous(c)));
  }
  CHECK(sharp > 100);
  CHECK(kept == sharp);
}

TEST_CASE("Surface points come back from the domain") {
  const TriangleMesh mesh = corpus::torus_knot(2, 3, 200, 12);
  const Parameterization p = parameterize(mesh, {60})[0];
  const SurfaceAtlas atlas(p);
  const double diagonal = bounding_box(mesh).diagonal();
  corpus::Random random(7);
  double worst = 0;
  for (int i = 0; i < 20000; ++i) {
    SurfaceLocation there;
    there.triangle = random.below(p.surface->triangle_count());
    const double a = random.uniform(), b = random.uniform() * (1 - a);
    there.barycentric[0] = 1 - a - b;
    there.barycentric[1] = a;
    there.barycentric[2] = b;
    const SurfaceLocation back = atlas.locate(atlas.domain_point(there));
    const auto position = [&](const SurfaceLocation& at) {
      const Triangle& t = p.surface->triangles[at.triangle];
      Vec3 sum;
      for (std::size_t k = 0; k < 3; ++k) sum += at.barycentric[k] * p.surface->positions[t[k]];
      return sum;
    };
    worst = std::max(worst, distance(position(there), position(back)));
  }
  CHECK(worst <= 1e-9 * diagonal);
}

TEST_CASE("The map does not depend on the number of threads") {
  const TriangleMesh mesh = corpus::spiky_ball(5);
  Parameterization one;
  {
    const oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism, 1);
    one = parameterize(mesh, {100})[0];
  }
  const oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism, 4);
  const Parameterization four = parameterize(mesh, {100})[0];
  REQUIRE(one.domain.faces() == four.domain.faces());
  CHECK(one.base_vertex_ids == four.base_vertex_ids);
  std::size_t different = 0;
  for (std::size_t v = 0; v < one.vertex_points.size(); ++v)
    different += one.vertex_points[v].face != four.vertex_points[v].face ||
                 !(one.vertex_points[v].at == four.vertex_points[v].at);
  CHECK(different == 0);
}

TEST_CASE("Scale and position of the input do not change its base") {
  const TriangleMesh mesh = corpus::torus(40, 20);
  TriangleMesh moved = mesh;
  for (Vec3& p : moved.positions) p = 1024.0 * p;
  const Parameterization a = parameterize(mesh, {40})[0], b = parameterize(moved, {40})[0];
  CHECK(a.domain.faces() == b.domain.faces());
  CHECK(a.base_vertex_ids == b.base_vertex_ids);
}

TEST_CASE("Spikes keep a base vertex near their tips") {
  const TriangleMesh mesh = corpus::spiky_ball(5, 20, 0.8);
  const Parameterization p = parameterize(mesh, {120})[0];
  check_map(p, mesh);
  // The twenty outermost vertices, one per spike.
  double radius = 0;
  for (const Vec3& x : mesh.positions) radius = std::max(radius, norm(x));
  std::vector<Vec3> tips;
  for (const Vec3& x : mesh.positions)
    if (norm(x) > 0.95 * radius &&
        std::none_of(tips.begin(), tips.end(), [&x](const Vec3& t) { return distance(t, x) < 0.3; }))
      tips.push_back(x);
  REQUIRE(tips.size() >= 15);
  int near = 0;
  for (const Vec3& tip : tips)
    near += std::any_of(p.base_positions.begin(), p.base_positions.end(),
                        [&tip](const Vec3& b) { return distance(b, tip) < 0.3; });
  CHECK(near == static_cast<int>(tips.size()));
}

TEST_CASE("Inputs that are no manifold are refused") {
  const TriangleMesh book{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}},
                          {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}},
                          {},
                          {},
                          {}};
  CHECK_THROWS_AS(parameterize(book, {4}), Error);
}

TEST_CASE("Real scans map without folds") {
  for (const auto& [name, size] :
       {std::pair<std::string, int>{"fandisk.obj", 80}, {"bimba.off", 120}, {"boot.obj", 150}}) {
    const auto path = test::corpus_mesh(name);
    if (!path) continue;
    INFO(name);
    const TriangleMesh mesh = condition(read_mesh(*path)).mesh;
    check_map(parameterize(mesh, {size})[0], mesh);
  }
}

}  // namespace
}  // namespace nmc
