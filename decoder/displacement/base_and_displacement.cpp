// SPDX-License-Identifier: Apache-2.0
#include "decoder/displacement/base_and_displacement.h"

#include <algorithm>
#include <filesystem>

#include "decoder/adaptive/face_hierarchy.h"
#include "decoder/displacement/exr_writer.h"
#include "decoder/write/number_text.h"
#include "libnmc/common/vec3.h"

namespace nmc {

namespace {

using std::uint32_t;

/// Displacements of one base face, row b1 of column b0 at [b1 * (side + 1) + b0].
std::vector<Vec3> tile_of_face(const FaceHierarchy& hierarchy, const FaceLattice& lattice, uint32_t face,
                               std::span<const double> positions) {
  const auto point = [&](uint32_t vertex) {
    const double* p = positions.data() + std::size_t{3} * vertex;
    return Vec3{p[0], p[1], p[2]};
  };
  const uint32_t side = lattice.side(), row = side + 1;
  Vec3 corners[3];
  for (int k = 0; k < 3; ++k) corners[k] = point(hierarchy.corner(0, face, k));
  std::vector<Vec3> tile(std::size_t{row} * row);
  const double unit = 1.0 / side;
  for (uint32_t b0 = 0; b0 <= side; ++b0) {
    for (uint32_t b1 = 0; b0 + b1 <= side; ++b1) {
      const Vec3 flat =
          ((b0 * unit) * corners[0] + (b1 * unit) * corners[1]) + ((side - b0 - b1) * unit) * corners[2];
      tile[std::size_t{b1} * row + b0] = point(hierarchy.vertex_at(0, face, lattice, b0, b1)) - flat;
    }
  }
  for (uint32_t b0 = 1; b0 <= side; ++b0) {
    const std::size_t beyond = std::size_t{side + 1 - b0} * row + b0;
    tile[beyond] = (tile[beyond - 1] + tile[beyond - row]) - tile[beyond - row - 1];
  }
  return tile;
}

/// Tiles beside each other in the image: as many as above each other, or one more.
uint32_t column_count(uint32_t face_count) {
  uint32_t columns = 1;
  while (std::uint64_t{columns} * columns < face_count) ++columns;
  return columns;
}

}  // namespace

bool fits_in_image(uint32_t base_face_count, int level) {
  return std::uint64_t{column_count(base_face_count)} * ((1u << level) + 1) <= kLargestImageSide;
}

BaseAndDisplacement make_base_and_displacement(std::span<const uint32_t> triangles,
                                               std::span<const double> positions, int level) {
  const FaceHierarchy hierarchy(triangles, level);
  const uint32_t face_count = hierarchy.face_count(0), texels = (1u << level) + 1;
  const uint32_t columns = column_count(face_count), rows = (face_count + columns - 1) / columns;
  BaseAndDisplacement result;
  result.image_width = columns * texels;
  result.image_height = rows * texels;
  result.displacement.assign(std::size_t{3} * result.image_width * result.image_height, 0.0f);
  const FaceLattice lattice(level);
  for (uint32_t face = 0; face < face_count; ++face) {
    const uint32_t left = face % columns * texels, top = face / columns * texels;
    const std::vector<Vec3> tile = tile_of_face(hierarchy, lattice, face, positions);
    for (uint32_t y = 0; y < texels; ++y) {
      float* out = result.displacement.data() + 3 * ((std::size_t{top} + y) * result.image_width + left);
      for (uint32_t x = 0; x < texels; ++x) {
        for (int i = 0; i < 3; ++i) *out++ = static_cast<float>(tile[std::size_t{y} * texels + x][i]);
      }
    }
    const uint32_t corner_texels[3][2] = {{texels - 1, 0}, {0, texels - 1}, {0, 0}};
    for (int k = 0; k < 3; ++k) {
      const uint32_t vertex = hierarchy.corner(0, face, k);
      result.base_triangles.push_back(vertex);
      result.base_vertex_count = std::max(result.base_vertex_count, vertex + 1);
      result.texture_coordinates.push_back((left + corner_texels[k][0] + 0.5) / result.image_width);
      result.texture_coordinates.push_back(1 - (top + corner_texels[k][1] + 0.5) / result.image_height);
    }
  }
  return result;
}

WriteStatus write_base_and_displacement(const std::string& prefix, const BaseAndDisplacement& data,
                                        std::span<const double> positions, int level) {
  const std::string image_path = prefix + ".exr";
  const WriteStatus image = write_exr(image_path, data.image_width, data.image_height, data.displacement);
  if (!image.is_ok()) return image;
  OutputFile file(prefix + ".obj");
  {
    BlockWriter out(file);
    out.block() += "# written by nmc: a base mesh; its displacements are in " +
                   std::filesystem::path(image_path).filename().string() + "\n# split each face into 4^" +
                   std::to_string(level) +
                   " flat ones, then add the image: vector displacement, object space, scale 1, middle 0,\n"
                   "# not colour managed. Texture coordinates are not to be smoothed.\n";
    for (std::size_t v = 0; v < data.base_vertex_count; ++v) {
      out.block().push_back('v');
      for (std::size_t i = 3 * v; i < 3 * v + 3; ++i) {
        out.block().push_back(' ');
        append_number(out.block(), positions[i]);
      }
      out.block().push_back('\n');
      out.flush_if_full();
    }
    for (std::size_t i = 0; i < data.texture_coordinates.size(); i += 2) {
      out.block() += "vt ";
      append_number(out.block(), data.texture_coordinates[i]);
      out.block().push_back(' ');
      append_number(out.block(), data.texture_coordinates[i + 1]);
      out.block().push_back('\n');
      out.flush_if_full();
    }
    for (std::size_t i = 0; i < data.base_triangles.size(); ++i) {
      out.block() += i % 3 == 0 ? "f " : " ";
      append_number(out.block(), std::uint64_t{data.base_triangles[i]} + 1);
      out.block().push_back('/');
      append_number(out.block(), std::uint64_t{i} + 1);
      if (i % 3 == 2) out.block().push_back('\n');
      out.flush_if_full();
    }
  }
  if (!file.commit()) return {WriteOutcome::kInputOutput, file.error()};
  return {};
}

}  // namespace nmc
