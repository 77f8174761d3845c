// SPDX-License-Identifier: Apache-2.0
#include "decoder/write/format_writers.h"
#include "decoder/write/number_text.h"

namespace nmc {

namespace {

std::string header(const MeshView& mesh, bool as_text) {
  const std::string coordinate = mesh.is_double() ? "property double " : "property float ";
  std::string text = "ply\nformat ";
  text += as_text ? "ascii" : "binary_little_endian";
  text += " 1.0\ncomment written by nmc\nelement vertex " + std::to_string(mesh.vertex_count()) + "\n";
  for (const char* axis : {"x", "y", "z"}) text += coordinate + axis + "\n";
  if (!mesh.normals.empty())
    for (const char* axis : {"nx", "ny", "nz"}) text += std::string("property float ") + axis + "\n";
  if (!mesh.colors.empty())
    for (const char* channel : {"red", "green", "blue"})
      text += std::string("property uchar ") + channel + "\n";
  text += "element face " + std::to_string(mesh.triangle_count()) +
          "\nproperty list uchar int vertex_indices\nend_header\n";
  return text;
}

void write_text_body(const MeshView& mesh, BlockWriter& out) {
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

void write_binary_body(const MeshView& mesh, BlockWriter& out) {
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    std::string& bytes = out.block();
    for (std::size_t k = 3 * i; k < 3 * i + 3; ++k) {
      if (mesh.is_double()) {
        append_little_endian(bytes, mesh.positions_double[k]);
      } else {
        append_little_endian(bytes, mesh.positions_single[k]);
      }
    }
    for (std::size_t k = 3 * i; k < 3 * i + 3 && !mesh.normals.empty(); ++k)
      append_little_endian(bytes, mesh.normals[k]);
    for (std::size_t k = 3 * i; k < 3 * i + 3 && !mesh.colors.empty(); ++k)
      append_little_endian(bytes, mesh.colors[k]);
    out.flush_if_full();
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
    std::string& bytes = out.block();
    bytes.push_back(3);
    for (std::size_t k = i; k < i + 3; ++k) append_little_endian(bytes, mesh.triangles[k]);
    out.flush_if_full();
  }
}

}  // namespace

void write_ply(const MeshView& mesh, bool as_text, OutputFile& file) {
  file.write(header(mesh, as_text));
  BlockWriter out(file);
  if (as_text) {
    write_text_body(mesh, out);
  } else {
    write_binary_body(mesh, out);
  }
}

}  // namespace nmc
