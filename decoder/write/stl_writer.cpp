// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>

#include "decoder/write/format_writers.h"
#include "decoder/write/number_text.h"

namespace nmc {

namespace {

using Point = std::array<double, 3>;

Point corner(const MeshView& mesh, std::size_t vertex) {
  return {mesh.coordinate(3 * vertex), mesh.coordinate(3 * vertex + 1), mesh.coordinate(3 * vertex + 2)};
}

/// Of unit length; zero for a triangle without area, which the format allows and readers recompute.
Point facet_normal(const Point& a, const Point& b, const Point& c) {
  const Point u = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, v = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
  const Point n = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
  const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  if (!(length > 0) || !std::isfinite(length)) return {0, 0, 0};
  return {n[0] / length, n[1] / length, n[2] / length};
}

}  // namespace

void write_stl(const MeshView& mesh, OutputFile& file) {
  BlockWriter out(file);
  std::string header = "binary STL written by nmc";  // must not begin with "solid"
  header.resize(80, ' ');
  out.block() += header;
  append_little_endian(out.block(), static_cast<std::uint32_t>(mesh.triangle_count()));
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
    std::string& bytes = out.block();
    const std::array<Point, 3> corners = {corner(mesh, mesh.triangles[i]),
                                          corner(mesh, mesh.triangles[i + 1]),
                                          corner(mesh, mesh.triangles[i + 2])};
    const Point normal = facet_normal(corners[0], corners[1], corners[2]);
    for (const double value : normal) append_little_endian(bytes, static_cast<float>(value));
    for (const Point& point : corners)
      for (const double value : point) append_little_endian(bytes, static_cast<float>(value));
    append_little_endian(bytes, std::uint16_t{0});
    out.flush_if_full();
  }
}

}  // namespace nmc
