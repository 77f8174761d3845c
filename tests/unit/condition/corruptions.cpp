// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/condition/corruptions.h"

#include <algorithm>
#include <array>
#include <functional>
#include <limits>

namespace nmc::test {

namespace {

using corpus::Random;

/// One with vertices that exist, as far as a few tries find one.
Triangle& any_triangle(TriangleMesh& mesh, Random& random) {
  for (int tries = 0; tries < 100; ++tries) {
    Triangle& t = mesh.triangles[random.below(mesh.triangle_count())];
    if (*std::max_element(t.begin(), t.end()) < mesh.vertex_count()) return t;
  }
  mesh.triangles[0] = {0, 1, 2};
  return mesh.triangles[0];
}

void delete_triangle(TriangleMesh& mesh, Random& random) {
  mesh.triangles.erase(mesh.triangles.begin() + random.below(mesh.triangle_count()));
}
void double_triangle(TriangleMesh& mesh, Random& random) {
  const Triangle copy = any_triangle(mesh, random);
  mesh.triangles.push_back(copy);
}
void double_triangle_reversed(TriangleMesh& mesh, Random& random) {
  const Triangle t = any_triangle(mesh, random);
  mesh.triangles.push_back({t[0], t[2], t[1]});
}
void turn_triangle(TriangleMesh& mesh, Random& random) {
  Triangle& t = any_triangle(mesh, random);
  std::swap(t[0], t[1]);
}
void make_t_junction(TriangleMesh& mesh, Random& random) {
  Triangle& t = any_triangle(mesh, random);
  const auto middle = static_cast<std::uint32_t>(mesh.vertex_count());
  mesh.positions.push_back(0.5 * (mesh.positions[t[0]] + mesh.positions[t[1]]));
  const Triangle other = {middle, t[1], t[2]};
  t[1] = middle;
  mesh.triangles.push_back(other);
}
void merge_vertices(TriangleMesh& mesh, Random& random) {
  const std::uint32_t from = random.below(mesh.vertex_count()), to = random.below(mesh.vertex_count());
  for (Triangle& t : mesh.triangles)
    for (std::uint32_t& v : t)
      if (v == from) v = to;
}
void unshare_vertex(TriangleMesh& mesh, Random& random) {
  Triangle& t = any_triangle(mesh, random);
  const std::uint32_t corner = random.below(3);
  const Vec3 copy = mesh.positions[t[corner]];
  t[corner] = static_cast<std::uint32_t>(mesh.vertex_count());
  mesh.positions.push_back(copy);
}
void make_nan(TriangleMesh& mesh, Random& random) {
  mesh.positions[random.below(mesh.vertex_count())].y = std::numeric_limits<double>::quiet_NaN();
}
void break_index(TriangleMesh& mesh, Random& random) {
  any_triangle(mesh, random)[random.below(3)] =
      static_cast<std::uint32_t>(mesh.vertex_count()) + random.below(9);
}
void random_triangle(TriangleMesh& mesh, Random& random) {
  const std::uint32_t a = random.below(mesh.vertex_count()), b = random.below(mesh.vertex_count());
  mesh.triangles.push_back({a, b, random.below(mesh.vertex_count())});
}
void insert_cap(TriangleMesh& mesh, Random& random) {
  const Triangle old = any_triangle(mesh, random);
  const auto middle = static_cast<std::uint32_t>(mesh.vertex_count());
  mesh.positions.push_back(0.25 * mesh.positions[old[0]] + 0.75 * mesh.positions[old[1]]);
  mesh.triangles.push_back({old[1], old[0], middle});
}
void move_vertex_onto_another(TriangleMesh& mesh, Random& random) {
  mesh.positions[random.below(mesh.vertex_count())] = mesh.positions[random.below(mesh.vertex_count())];
}

struct Corruption {
  const char* name;
  void (*apply)(TriangleMesh&, Random&);
};
constexpr std::array<Corruption, 12> kCorruptions = {{{"deleted", delete_triangle},
                                                      {"doubled", double_triangle},
                                                      {"doubled reversed", double_triangle_reversed},
                                                      {"turned", turn_triangle},
                                                      {"T-junction", make_t_junction},
                                                      {"merged vertices", merge_vertices},
                                                      {"unshared vertex", unshare_vertex},
                                                      {"NaN", make_nan},
                                                      {"broken index", break_index},
                                                      {"random triangle", random_triangle},
                                                      {"cap", insert_cap},
                                                      {"coincident vertices", move_vertex_onto_another}}};

}  // namespace

std::string corrupt(TriangleMesh& mesh, corpus::Random& random) {
  std::string done;
  const std::uint32_t count = 1 + random.below(6);
  for (std::uint32_t i = 0; i < count; ++i) {
    const Corruption& corruption = kCorruptions[random.below(kCorruptions.size())];
    corruption.apply(mesh, random);
    done += (done.empty() ? "" : ", ") + std::string(corruption.name);
  }
  return done;
}

}  // namespace nmc::test
