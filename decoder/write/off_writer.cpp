// SPDX-License-Identifier: Apache-2.0
#include "decoder/write/format_writers.h"
#include "decoder/write/number_text.h"

namespace nmc {

void write_off(const MeshView& mesh, OutputFile& file) {
  BlockWriter out(file);
  std::string& header = out.block();
  if (!mesh.colors.empty()) header.push_back('C');
  if (!mesh.normals.empty()) header.push_back('N');
  header +=
      "OFF\n" + std::to_string(mesh.vertex_count()) + " " + std::to_string(mesh.triangle_count()) + " 0\n";
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    std::string& line = out.block();
    for (std::size_t k = 3 * i; k < 3 * i + 3; ++k) {
      append_coordinate(line, mesh, k);
      line.push_back(' ');
    }
    for (std::size_t k = 3 * i; k < 3 * i + 3 && !mesh.normals.empty(); ++k) {
      append_number(line, mesh.normals[k]);
      line.push_back(' ');
    }
    for (std::size_t k = 3 * i; k < 3 * i + 3 && !mesh.colors.empty(); ++k) {
      append_number(line, static_cast<unsigned>(mesh.colors[k]));
      line.push_back(' ');
    }
    if (!mesh.colors.empty()) line += "255 ";
    line.back() = '\n';
    out.flush_if_full();
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
    std::string& line = out.block();
    line.push_back('3');
    for (std::size_t k = i; k < i + 3; ++k) {
      line.push_back(' ');
      append_number(line, mesh.triangles[k]);
    }
    line.push_back('\n');
    out.flush_if_full();
  }
}

}  // namespace nmc
