// SPDX-License-Identifier: Apache-2.0
// Based on: Khronos. glTF 2.0 Specification, 2021, sections 3.6 (buffers, accessors), 3.7.2 (meshes: COLOR_0
// is linear) and 4.4 (GLB container).
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "decoder/write/format_writers.h"
#include "decoder/write/number_text.h"

namespace nmc {

namespace {

constexpr std::uint64_t kMaximumSize = 0xffffffffu;
constexpr std::size_t kPositionSize = 12, kNormalSize = 12, kColorSize = 8, kIndexSize = 4;

/// Coordinates this many diagonals away from the origin lose four bits or more in single precision.
constexpr double kFarInDiagonals = 16;

using Point = std::array<double, 3>;

struct Layout {
  std::uint64_t positions = 0, normals = 0, colors = 0, indices = 0, stream = 0,
                end = 0;  // byte offsets in the binary chunk

  Layout(const MeshView& mesh, const ProgressiveStream* progressive) {
    const std::uint64_t count = mesh.vertex_count();
    normals = positions + kPositionSize * count;
    colors = normals + (mesh.normals.empty() ? 0 : kNormalSize * count);
    indices = colors + (mesh.colors.empty() ? 0 : kColorSize * count);
    stream = indices + kIndexSize * mesh.triangles.size();
    end = stream + (progressive ? (progressive->bytes.size() + 3) / 4 * 4 : 0);
  }
};

/// Where positions are stored relative to: the origin, or the centre of a box far away from it. Beside a
/// stream always the origin, since its positions are in model units, and viewers swap one mesh for the other.
Point stored_origin(const MeshView& mesh, const ProgressiveStream* progressive) {
  if (!mesh.is_double() || progressive) return {0, 0, 0};
  Point minimum, maximum;
  minimum.fill(std::numeric_limits<double>::infinity());
  maximum.fill(-std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < mesh.positions_double.size(); ++i) {
    minimum[i % 3] = std::min(minimum[i % 3], mesh.positions_double[i]);
    maximum[i % 3] = std::max(maximum[i % 3], mesh.positions_double[i]);
  }
  double diagonal = 0, distance = 0;
  Point center;
  for (std::size_t k = 0; k < 3; ++k) {
    center[k] = 0.5 * minimum[k] + 0.5 * maximum[k];
    diagonal += (maximum[k] - minimum[k]) * (maximum[k] - minimum[k]);
    distance += center[k] * center[k];
  }
  if (std::sqrt(distance) <= kFarInDiagonals * std::sqrt(diagonal)) return {0, 0, 0};
  return center;
}

float stored_coordinate(const MeshView& mesh, const Point& origin, std::size_t i) {
  return mesh.is_double() ? static_cast<float>(mesh.positions_double[i] - origin[i % 3])
                          : mesh.positions_single[i];
}

/// IEC 61966-2-1, as 16 bits, which keeps all 256 values apart.
std::array<std::uint16_t, 256> linear_from_srgb() {
  std::array<std::uint16_t, 256> table{};
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double encoded = static_cast<double>(i) / 255;
    const double linear = encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
    table[i] = static_cast<std::uint16_t>(std::lround(linear * 65535));
  }
  return table;
}

template <class Number>
void append_vector(std::string& json, const std::array<Number, 3>& values) {
  json.push_back('[');
  for (std::size_t k = 0; k < 3; ++k) {
    if (k > 0) json.push_back(',');
    append_number(json, values[k]);
  }
  json.push_back(']');
}

/// The JSON chunk's arrays of buffer views and accessors, which grow in step.
class AccessorList {
 public:
  void add(std::uint64_t offset, std::uint64_t size, bool is_indices, std::uint64_t count,
           const char* type_members) {
    const char* const separator = count_ == 0 ? "" : ",";
    views_ += separator;
    views_ += R"({"buffer":0,"byteOffset":)" + std::to_string(offset) + R"(,"byteLength":)" +
              std::to_string(size) + R"(,"target":)" + (is_indices ? "34963}" : "34962}");
    accessors_ += separator;
    accessors_ += R"({"bufferView":)" + std::to_string(count_) + R"(,"count":)" + std::to_string(count) +
                  "," + type_members + bounds_ + "}";
    bounds_.clear();
    ++count_;
  }

  /// For the next add(): glTF wants the exact bounds of positions.
  void set_bounds(const std::array<float, 3>& minimum, const std::array<float, 3>& maximum) {
    bounds_ = R"(,"min":)";
    append_vector(bounds_, minimum);
    bounds_ += R"(,"max":)";
    append_vector(bounds_, maximum);
  }

  std::size_t count() const { return count_; }
  const std::string& views() const { return views_; }
  const std::string& accessors() const { return accessors_; }

 private:
  std::size_t count_ = 0;
  std::string bounds_, views_, accessors_;
};

/// The extension of a primitive whose stream is buffer view `view` (docs/NMC_progressive_mesh).
std::string progressive_extension(const ProgressiveStream& stream, std::size_t view, bool has_colors) {
  std::string json = R"(,"extensions":{"NMC_progressive_mesh":{"bufferView":)" + std::to_string(view);
  json += R"(,"attributes":["POSITION","NORMAL")" + std::string(has_colors ? R"(,"COLOR_0")" : "") + "]";
  json += R"(,"bounds":{"min":)";
  append_vector(json, stream.box_minimum);
  json += R"(,"max":)";
  append_vector(json, stream.box_maximum);
  json += R"(},"layers":[)";
  bool is_first = true;
  for (const ProgressiveLayer& layer : stream.layers) {
    if (!is_first) json.push_back(',');
    is_first = false;
    json += R"({"byteLength":)" + std::to_string(layer.byte_length) + R"(,"triangles":)" +
            std::to_string(layer.triangle_count);
    if (layer.has_error) {
      json += R"(,"geometricError":)";
      append_number(json, layer.maximum_error);
    }
    json.push_back('}');
  }
  return json + "]}}";
}

std::string json_chunk(const MeshView& mesh, const Layout& layout, const Point& origin,
                       const ProgressiveStream* progressive) {
  std::string json = R"({"asset":{"version":"2.0","generator":"nmc"},"scene":0,)";
  if (progressive) json += R"("extensionsUsed":["NMC_progressive_mesh"],)";
  if (mesh.triangles.empty()) {
    // An accessor cannot have zero elements, so a mesh without triangles is a scene without nodes.
    json += R"("scenes":[{}]})";
    return json;
  }
  const std::uint64_t count = mesh.vertex_count();
  AccessorList list;
  std::array<float, 3> minimum, maximum;
  for (std::size_t k = 0; k < 3; ++k) minimum[k] = maximum[k] = stored_coordinate(mesh, origin, k);
  for (std::size_t i = 3; i < 3 * mesh.vertex_count(); ++i) {
    const float value = stored_coordinate(mesh, origin, i);
    minimum[i % 3] = std::min(minimum[i % 3], value);
    maximum[i % 3] = std::max(maximum[i % 3], value);
  }
  std::string attributes = R"("POSITION":0)";
  list.set_bounds(minimum, maximum);
  list.add(layout.positions, kPositionSize * count, false, count, R"("componentType":5126,"type":"VEC3")");
  if (!mesh.normals.empty()) {
    attributes += R"(,"NORMAL":)" + std::to_string(list.count());
    list.add(layout.normals, kNormalSize * count, false, count, R"("componentType":5126,"type":"VEC3")");
  }
  if (!mesh.colors.empty()) {
    attributes += R"(,"COLOR_0":)" + std::to_string(list.count());
    list.add(layout.colors, kColorSize * count, false, count,
             R"("componentType":5123,"normalized":true,"type":"VEC4")");
  }
  const std::string indices = std::to_string(list.count());
  list.add(layout.indices, kIndexSize * mesh.triangles.size(), true, mesh.triangles.size(),
           R"("componentType":5125,"type":"SCALAR")");

  json += R"("scenes":[{"nodes":[0]}],"nodes":[{"mesh":0)";
  if (origin != Point{0, 0, 0}) {
    json += R"(,"translation":)";
    append_vector(json, origin);
  }
  // The default material is a metal, which is black wherever a viewer has no environment to mirror.
  json += R"(}],"materials":[{"pbrMetallicRoughness":{"metallicFactor":0},"doubleSided":true}],)";
  json += R"("meshes":[{"primitives":[{"attributes":{)" + attributes + R"(},"indices":)" + indices +
          R"(,"material":0)";
  std::string views = list.views();
  if (progressive) {
    json += progressive_extension(*progressive, list.count(), !mesh.colors.empty());
    views += R"(,{"buffer":0,"byteOffset":)" + std::to_string(layout.stream) + R"(,"byteLength":)" +
             std::to_string(progressive->bytes.size()) + "}";
  }
  json += "}]}],";
  json += R"("buffers":[{"byteLength":)" + std::to_string(layout.end) + R"(}],"bufferViews":[)" + views +
          R"(],"accessors":[)" + list.accessors() + "]}";
  return json;
}

void write_binary_chunk(const MeshView& mesh, const Point& origin, const ProgressiveStream* progressive,
                        BlockWriter& out) {
  for (std::size_t i = 0; i < 3 * mesh.vertex_count(); ++i) {
    append_little_endian(out.block(), stored_coordinate(mesh, origin, i));
    out.flush_if_full();
  }
  for (const float value : mesh.normals) {
    append_little_endian(out.block(), value);
    out.flush_if_full();
  }
  if (!mesh.colors.empty()) {
    const std::array<std::uint16_t, 256> linear = linear_from_srgb();
    for (std::size_t i = 0; i < mesh.colors.size(); i += 3) {
      for (std::size_t k = i; k < i + 3; ++k) append_little_endian(out.block(), linear[mesh.colors[k]]);
      append_little_endian(out.block(), std::uint16_t{65535});
      out.flush_if_full();
    }
  }
  for (const std::uint32_t index : mesh.triangles) {
    append_little_endian(out.block(), index);
    out.flush_if_full();
  }
  if (!progressive) return;
  const std::size_t size = progressive->bytes.size();
  for (std::size_t i = 0; i < (size + 3) / 4 * 4; ++i) {
    append_little_endian(out.block(), i < size ? progressive->bytes[i] : std::uint8_t{0});
    out.flush_if_full();
  }
}

}  // namespace

std::string reason_against_glb(const MeshView& mesh, const ProgressiveStream* progressive) {
  if (mesh.triangles.empty()) return {};
  constexpr std::uint64_t kRoomForJson = 4096, kRoomPerLayer = 128;
  const std::uint64_t layer_count = progressive ? progressive->layers.size() : 0;
  if (Layout(mesh, progressive).end > kMaximumSize - kRoomForJson - kRoomPerLayer * layer_count)
    return "GLB files end at 4 GiB, and this mesh needs more";
  const Point origin = stored_origin(mesh, progressive);
  for (std::size_t i = 0; i < 3 * mesh.vertex_count(); ++i)
    if (!std::isfinite(stored_coordinate(mesh, origin, i)))
      return "glTF cannot hold a coordinate that is not finite in single precision";
  return {};
}

void write_glb(const MeshView& mesh, const ProgressiveStream* progressive, OutputFile& file) {
  const Layout layout(mesh, progressive);
  const bool has_binary_chunk = !mesh.triangles.empty();
  const Point origin = has_binary_chunk ? stored_origin(mesh, progressive) : Point{0, 0, 0};
  std::string json = json_chunk(mesh, layout, origin, progressive);
  json.resize((json.size() + 3) / 4 * 4, ' ');
  BlockWriter out(file);
  std::string& bytes = out.block();
  const std::uint64_t size = 12 + 8 + json.size() + (has_binary_chunk ? 8 + layout.end : 0);
  bytes += "glTF";
  append_little_endian(bytes, std::uint32_t{2});
  append_little_endian(bytes, static_cast<std::uint32_t>(size));
  append_little_endian(bytes, static_cast<std::uint32_t>(json.size()));
  bytes += "JSON" + json;
  if (!has_binary_chunk) return;
  append_little_endian(bytes, static_cast<std::uint32_t>(layout.end));
  bytes += std::string("BIN\0", 4);
  write_binary_chunk(mesh, origin, progressive, out);
}

}  // namespace nmc
