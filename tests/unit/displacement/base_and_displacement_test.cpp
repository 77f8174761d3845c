// SPDX-License-Identifier: Apache-2.0
#include "decoder/displacement/base_and_displacement.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "decoder/displacement/exr_writer.h"
#include "libnmc/common/vec3.h"
#include "tests/unit/common/small_meshes.h"

using namespace nmc;
using namespace nmc::test;

namespace {

struct FullMesh {
  LevelTopology base;
  std::vector<std::uint32_t> triangles;
  std::vector<double> positions;
  Vec3 point(std::uint32_t v) const { return {positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]}; }
};

/// A base mesh split `level` times, every vertex somewhere.
FullMesh random_mesh(const SmallMesh& small, int level) {
  FullMesh mesh;
  REQUIRE(build(small, mesh.base).ok());
  std::vector<LevelTopology> levels(static_cast<std::size_t>(level) + 1);
  REQUIRE(build(small, levels[0]).ok());
  for (std::size_t l = 0; l < static_cast<std::size_t>(level); ++l)
    REQUIRE(subdivide(levels[l], false, levels[l + 1]).ok());
  mesh.triangles.assign(levels.back().face_vertices.begin(), levels.back().face_vertices.end());
  Random random(7);
  for (std::size_t i = 0; i < std::size_t{3} * levels.back().vertex_count; ++i)
    mesh.positions.push_back(random.uniform(-1, 1));
  return mesh;
}

/// What a renderer finds at (u, v): bilinear between the centres of texels, v upwards.
Vec3 look_up(const BaseAndDisplacement& data, double u, double v) {
  const double x = u * data.image_width - 0.5, y = (1 - v) * data.image_height - 0.5;
  const double left = std::floor(x), top = std::floor(y);
  Vec3 sum;
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      const double weight = (i ? x - left : 1 - (x - left)) * (j ? y - top : 1 - (y - top));
      const double column = std::clamp(left + i, 0.0, data.image_width - 1.0);
      const double row = std::clamp(top + j, 0.0, data.image_height - 1.0);
      const float* texel =
          data.displacement.data() + 3 * static_cast<std::size_t>(row * data.image_width + column);
      sum += weight * Vec3{texel[0], texel[1], texel[2]};
    }
  }
  return sum;
}

struct Lookup {
  Vec3 flat, displaced;
};

Lookup at(const BaseAndDisplacement& data, const FullMesh& mesh, std::size_t face, const double (&b)[3]) {
  double u = 0, v = 0;
  Lookup result;
  for (std::size_t k = 0; k < 3; ++k) {
    u += b[k] * data.texture_coordinates[6 * face + 2 * k];
    v += b[k] * data.texture_coordinates[6 * face + 2 * k + 1];
    result.flat += b[k] * mesh.point(data.base_triangles[3 * face + k]);
  }
  result.displaced = result.flat + look_up(data, u, v);
  return result;
}

}  // namespace

TEST_CASE("splitting the base faces and adding the image gives every decoded vertex", "[displacement]") {
  for (const SmallMesh& small : {tetrahedron(), grid(3, 3, false), bipyramid(5)}) {
    for (const int level : {0, 1, 3}) {
      const FullMesh mesh = random_mesh(small, level);
      const BaseAndDisplacement data = make_base_and_displacement(mesh.triangles, mesh.positions, level);
      CHECK(data.base_vertex_count == small.vertex_count);
      CHECK(data.base_triangles.size() == 3 * small.faces.size());
      // Splitting flat triangles by hand, in the order of the format, visits the decoded triangles in theirs.
      struct Corners {
        double b[3][3];
      };
      for (std::size_t face = 0; face < small.faces.size(); ++face) {
        std::vector<Corners> parts = {{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}};
        for (int l = 0; l < level; ++l) {
          std::vector<Corners> finer;
          for (const Corners& c : parts) {
            double m[3][3];
            for (int k = 0; k < 3; ++k)
              for (int i = 0; i < 3; ++i) m[k][i] = 0.5 * (c.b[(k + 1) % 3][i] + c.b[(k + 2) % 3][i]);
            const double* children[4][3] = {
                {c.b[0], m[2], m[1]}, {m[2], c.b[1], m[0]}, {m[1], m[0], c.b[2]}, {m[0], m[1], m[2]}};
            for (const auto& child : children) {
              Corners next{};
              for (int k = 0; k < 3; ++k)
                for (int i = 0; i < 3; ++i) next.b[k][i] = child[k][i];
              finer.push_back(next);
            }
          }
          parts = finer;
        }
        for (std::size_t t = 0; t < parts.size(); ++t) {
          for (std::size_t k = 0; k < 3; ++k) {
            const Vec3 expected = mesh.point(mesh.triangles[3 * (face * parts.size() + t) + k]);
            const Vec3 found = at(data, mesh, face, parts[t].b[k]).displaced;
            INFO(small.name << " level " << level << " face " << face << " part " << t << " corner " << k);
            CHECK(distance(expected, found) < 1e-6);
          }
        }
      }
    }
  }
}

TEST_CASE("neighbours agree along their edge at any rate of dicing", "[displacement]") {
  const FullMesh mesh = random_mesh(tetrahedron(), 2);
  const BaseAndDisplacement data = make_base_and_displacement(mesh.triangles, mesh.positions, 2);
  const auto point_on_edge = [&](std::size_t face, std::uint32_t from, double t, std::uint32_t to) {
    double b[3] = {0, 0, 0};
    for (std::size_t k = 0; k < 3; ++k) {
      if (data.base_triangles[3 * face + k] == from) b[k] = 1 - t;
      if (data.base_triangles[3 * face + k] == to) b[k] = t;
    }
    return at(data, mesh, face, b).displaced;
  };
  for (std::uint32_t e = 0; e < mesh.base.edge_count; ++e) {
    const std::uint32_t a = mesh.base.edge_vertices[2 * e], b = mesh.base.edge_vertices[2 * e + 1];
    for (int i = 0; i <= 23; ++i) {
      INFO("edge " << e << " at " << i << "/23");
      CHECK(distance(point_on_edge(mesh.base.edge_faces[2 * e], a, i / 23.0, b),
                     point_on_edge(mesh.base.edge_faces[2 * e + 1], a, i / 23.0, b)) < 2e-6);
    }
  }
}

TEST_CASE("an image that no renderer reads is refused", "[displacement]") {
  // 64 * 64 base faces at level 9 would take 64 * 513 = 32832 columns; at level 8 they take 16448.
  CHECK(!fits_in_image(64 * 64, 9));
  CHECK(fits_in_image(64 * 64, 8));
}

TEST_CASE("exr: header, table and planes lie where the format has them", "[displacement]") {
  std::string pattern = (std::filesystem::temp_directory_path() / "nmc-exr-XXXXXX").string();
  REQUIRE(mkdtemp(pattern.data()) != nullptr);
  const std::string path = pattern + "/image.exr";
  std::vector<float> rgb;
  for (int i = 0; i < 3 * 5 * 4; ++i) rgb.push_back(static_cast<float>(i) + 0.25f);
  REQUIRE(write_exr(path, 5, 4, rgb).is_ok());
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  const std::string bytes = text.str();
  std::filesystem::remove_all(pattern);
  const auto u32 = [&](std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t k = 0; k < 4; ++k)
      value |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes.at(at + k))) << (8 * k);
    return value;
  };
  CHECK(u32(0) == 20000630);
  CHECK(u32(4) == 2);
  const std::size_t image_size = 4 * (8 + 8 + 5 * 12), header_size = bytes.size() - image_size;
  CHECK(bytes.at(header_size - 1) == '\0');
  for (std::uint32_t y = 0; y < 4; ++y) {
    const std::uint32_t line = u32(header_size + 8 * y);
    CHECK(u32(line) == y);
    CHECK(u32(line + 4) == 5 * 12);
    for (std::uint32_t x = 0; x < 5; ++x) {
      for (std::uint32_t channel = 0; channel < 3; ++channel) {  // planes B, G, R
        const std::uint32_t bits = u32(line + 8 + 4 * (5 * (2 - channel) + x));
        float value = 0;
        std::memcpy(&value, &bits, sizeof value);
        INFO("x " << x << " y " << y << " channel " << channel);
        CHECK(value == rgb[3 * (5 * y + x) + channel]);
      }
    }
  }
}
