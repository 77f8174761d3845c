// SPDX-License-Identifier: Apache-2.0
#include "decoder/write/format_writers.h"
#include "decoder/write/number_text.h"

namespace nmc {

void write_obj(const MeshView& mesh, OutputFile& file) {
  BlockWriter out(file);
  out.block() += "# written by nmc\n";
  const bool has_normals = !mesh.normals.empty();
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    std::string& line = out.block();
    line.push_back('v');
    for (std::size_t k = 3 * i; k < 3 * i + 3; ++k) {
      line.push_back(' ');
      append_coordinate(line, mesh, k);
    }
    for (std::size_t k = 3 * i; k < 3 * i + 3 && !mesh.colors.empty(); ++k) {
      line.push_back(' ');
      append_number(line, static_cast<float>(mesh.colors[k]) / 255.0f);
    }
    line.push_back('\n');
    for (std::size_t k = 3 * i; k < 3 * i + 3 && has_normals; ++k) {
      line += k == 3 * i ? "vn " : " ";
      append_number(line, mesh.normals[k]);
    }
    if (has_normals) line.push_back('\n');
    out.flush_if_full();
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
    std::string& line = out.block();
    line.push_back('f');
    for (std::size_t k = i; k < i + 3; ++k) {
      const std::uint64_t number = std::uint64_t{mesh.triangles[k]} + 1;
      line.push_back(' ');
      append_number(line, number);
      if (has_normals) {
        line += "//";
        append_number(line, number);
      }
    }
    line.push_back('\n');
    out.flush_if_full();
  }
}

}  // namespace nmc
