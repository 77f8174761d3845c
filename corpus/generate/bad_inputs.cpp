// SPDX-License-Identifier: Apache-2.0
#include "corpus/generate/bad_inputs.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "corpus/generate/random.h"
#include "corpus/generate/shapes.h"

namespace nmc::corpus {

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A strip of triangles through the given points, three at a time.
TriangleMesh strip(std::vector<Vec3> points) {
  TriangleMesh mesh;
  mesh.positions = std::move(points);
  for (std::uint32_t i = 0; i + 2 < mesh.vertex_count(); ++i)
    mesh.triangles.push_back(i % 2 == 0 ? Triangle{i, i + 1, i + 2} : Triangle{i + 1, i, i + 2});
  return mesh;
}

std::vector<Vec3> points_on_line(int count) {
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) points.push_back({0.5 * i, 0.25 * i, -1.0 * i});
  return points;
}

TriangleMesh with_some_positions(TriangleMesh mesh, double value, std::uint64_t seed) {
  Random random(seed);
  for (int i = 0; i < 20; ++i) mesh.positions[random.below(mesh.vertex_count())][i % 3] = value;
  return mesh;
}

TriangleMesh plane(int cells) {
  TriangleMesh mesh = terrain(cells);
  for (Vec3& p : mesh.positions) p = {p.x, p.y, p.x};
  return mesh;
}

/// A sphere of 1.5 m at UTM-like coordinates with detail of millimetres.
TriangleMesh georeferenced() {
  TriangleMesh mesh = noisy_sphere(5, 0.002);
  translate(mesh, {1.0e7, 5.5e6, 432.1});
  return mesh;
}

TriangleMesh crossing_spheres() {
  TriangleMesh mesh = icosphere(4);
  TriangleMesh other = icosphere(4);
  translate(other, {0.7, 0.1, 0.2});
  append(mesh, other);
  return mesh;
}

TriangleMesh triangle_soup(const TriangleMesh& mesh) {
  TriangleMesh soup;
  for (const Triangle& t : mesh.triangles) {
    const auto first = static_cast<std::uint32_t>(soup.vertex_count());
    for (const std::uint32_t v : t) soup.positions.push_back(mesh.positions[v]);
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  return soup;
}

TriangleMesh randomly_turned(TriangleMesh mesh, std::uint64_t seed) {
  Random random(seed);
  for (Triangle& t : mesh.triangles)
    if (random.below(2)) std::swap(t[1], t[2]);
  return mesh;
}

TriangleMesh random_indices() {
  Random random(7);
  TriangleMesh mesh;
  for (int i = 0; i < 200; ++i) mesh.positions.push_back(random.in_cube(1));
  for (int i = 0; i < 4000; ++i)
    mesh.triangles.push_back({random.below(200), random.below(200), random.below(200)});
  return mesh;
}

/// Triangles that all share one edge.
TriangleMesh book(int page_count) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {0, 0, 1}};
  for (int i = 0; i < page_count; ++i) {
    const double angle = 6.283185307179586 * i / page_count;
    mesh.triangles.push_back({0, 1, static_cast<std::uint32_t>(mesh.vertex_count())});
    mesh.positions.push_back({std::cos(angle), std::sin(angle), 0.5});
  }
  return mesh;
}

std::string ply(const std::string& counts_and_body) { return "ply\nformat ascii 1.0\n" + counts_and_body; }

}  // namespace

std::string ply_text(const BadInput& input) {
  if (input.is_file()) return input.file_text;
  std::string text = fmt::format(
      "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n"
      "element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
      input.mesh.vertex_count(), input.mesh.triangle_count());
  for (const Vec3& p : input.mesh.positions) text += fmt::format("{} {} {}\n", p.x, p.y, p.z);
  for (const Triangle& t : input.mesh.triangles) text += fmt::format("3 {} {} {}\n", t[0], t[1], t[2]);
  return text;
}

std::vector<BadInput> bad_inputs() {
  std::vector<BadInput> inputs;
  const auto file = [&](const char* name, Expected expected, std::string text) {
    inputs.push_back({name, expected, std::move(text), {}});
  };
  const auto mesh = [&](const char* name, Expected expected, TriangleMesh m) {
    inputs.push_back({name, expected, {}, std::move(m)});
  };
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  const std::string faces = "property list uchar int vertex_indices\nend_header\n";

  file("empty_file", Expected::kRefused, "");
  file("header_only", Expected::kRefused, ply("element vertex 0\n" + xyz + "element face 0\n" + faces));
  file("no_faces", Expected::kRefused,
       ply("element vertex 3\n" + xyz + "element face 0\n" + faces + "0 0 0\n1 0 0\n0 1 0\n"));
  file("cut_off", Expected::kRefused,
       ply("element vertex 3\n" + xyz + "element face 1\n" + faces + "0 0 0\n1 0"));
  file("count_too_large", Expected::kRefused,
       ply("element vertex 4000000000\n" + xyz + "element face 4000000000\n" + faces + "0 0 0\n"));

  mesh("single_triangle", Expected::kEncoded, strip({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
  mesh("plane", Expected::kEncoded, plane(40));
  mesh("all_points_on_a_line", Expected::kRefused, strip(points_on_line(50)));
  mesh("all_points_equal", Expected::kRefused, strip(std::vector<Vec3>(30, Vec3{1, 2, 3})));
  mesh("all_nan", Expected::kRefused, strip(std::vector<Vec3>(30, Vec3{kNan, kNan, kNan})));
  mesh("some_nan", Expected::kEncoded, with_some_positions(icosphere(4), kNan, 5));
  mesh("some_infinite", Expected::kEncoded, with_some_positions(icosphere(4), -kInfinity, 6));
  {
    TriangleMesh broken = icosphere(3);
    broken.triangles[17][1] = 4000000000u;
    mesh("index_out_of_range", Expected::kRefused, std::move(broken));
  }
  {
    TriangleMesh only_bad = icosphere(1);
    for (Triangle& t : only_bad.triangles) t[2] = 1000000;
    mesh("all_indices_out_of_range", Expected::kRefused, std::move(only_bad));
  }
  {
    TriangleMesh repeated = icosphere(2);
    for (Triangle& t : repeated.triangles) t[2] = t[1];
    mesh("all_triangles_degenerate", Expected::kRefused, std::move(repeated));
  }
  {
    TriangleMesh huge = icosphere(3);
    for (Vec3& p : huge.positions) p *= 1e200;
    mesh("beyond_measure", Expected::kRefused, std::move(huge));
  }
  mesh("moebius_strip", Expected::kEncoded, moebius_strip(60, 4));
  mesh("klein_bottle", Expected::kEncoded, klein_bottle(40, 20));
  mesh("self_intersecting", Expected::kEncoded, crossing_spheres());
  mesh("loose_triangles_100000", Expected::kEncoded, loose_triangles(100000));
  mesh("georeferenced", Expected::kEncoded, georeferenced());
  mesh("holes_300", Expected::kEncoded, disk_with_holes(300));
  mesh("genus_100", Expected::kEncoded, perforated_plate(10, 10));
  mesh("triangle_soup", Expected::kEncoded, triangle_soup(icosphere(4)));
  mesh("random_orientation", Expected::kEncoded, randomly_turned(torus(40, 20), 8));
  mesh("book_of_20000_pages", Expected::kEncoded, book(20000));
  mesh("random_indices", Expected::kEncoded, random_indices());
  {
    TriangleMesh twice = icosphere(3);
    append(twice, icosphere(3));
    mesh("everything_twice", Expected::kEncoded, std::move(twice));
  }
  {
    TriangleMesh two_sided = terrain(20);
    TriangleMesh back = two_sided;
    turn_around(back);
    append(two_sided, back);
    mesh("front_and_back", Expected::kEncoded, std::move(two_sided));
  }
  mesh("cells_touching_along_edges", Expected::kEncoded,
       voxel_surface(6, 6, 6, [](int x, int y, int z) { return (x + y + z) % 2 == 0; }));
  return inputs;
}

}  // namespace nmc::corpus
