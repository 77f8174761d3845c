// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>
#include <vector>

#include "encoder/read/face_list.h"
#include "encoder/read/format_readers.h"
#include "encoder/read/ply_header.h"
#include "encoder/read/ply_values.h"
#include "encoder/read/vertex_colors.h"

namespace nmc {

namespace {

/// What becomes of one scalar property of the vertices.
struct VertexColumn {
  enum class Target { kPosition, kColorByte, kColorValue, kAttribute, kSkip };
  Target target = Target::kSkip;
  std::size_t index = 0;  // axis, channel, or place in TriangleMesh::attributes
};

int position_axis(std::string_view name) {
  return name.size() == 1 && name[0] >= 'x' && name[0] <= 'z' ? name[0] - 'x' : -1;
}

int color_channel(std::string_view name) {
  static constexpr std::array<std::string_view, 9> kNames = {
      "red", "green", "blue", "diffuse_red", "diffuse_green", "diffuse_blue", "r", "g", "b"};
  const auto found = std::find(kNames.begin(), kNames.end(), name);
  return found == kNames.end() ? -1 : static_cast<int>((found - kNames.begin()) % 3);
}

/// Integer properties are mostly flags and labels, which interpolation would ruin; these are measurements.
bool is_measurement(const PlyProperty& property) {
  return is_real(property.type) || property.name == "quality" || property.name == "confidence" ||
         property.name == "intensity" || property.name.starts_with("scalar_");
}

class VertexPlan {
 public:
  VertexPlan(const Source& source, const PlyElement& element, const ReadOptions& options,
             TriangleMesh& mesh) {
    std::array<const PlyProperty*, 3> axes{}, channels{};
    for (const PlyProperty& property : element.properties) {
      if (property.is_list) continue;
      const int axis = position_axis(property.name), channel = color_channel(property.name);
      if (axis >= 0 && std::exchange(axes[axis], &property) != nullptr)
        source.fail_at_line(element.declared_at,
                            fmt::format("the vertices have two properties '{}'", property.name));
      if (channel >= 0 && channels[channel] == nullptr) channels[channel] = &property;
    }
    for (int axis = 0; axis < 3; ++axis)
      if (axes[axis] == nullptr)
        source.fail_at_line(element.declared_at,
                            fmt::format("the vertices have no property '{}'", static_cast<char>('x' + axis)));
    has_colors_ = std::none_of(channels.begin(), channels.end(), [](const auto* p) { return p == nullptr; });
    colors_are_bytes_ = has_colors_ && std::all_of(channels.begin(), channels.end(),
                                                   [](const auto* p) { return p->type == PlyType::kUint8; });
    colors_are_words_ = has_colors_ && std::all_of(channels.begin(), channels.end(),
                                                   [](const auto* p) { return p->type == PlyType::kUint16; });
    for (const PlyProperty& property : element.properties)
      columns_.push_back(plan(property, axes, channels, options, mesh));
  }

  const std::vector<VertexColumn>& columns() const { return columns_; }
  bool has_colors() const { return has_colors_; }
  bool colors_are_bytes() const { return colors_are_bytes_; }
  bool colors_are_words() const { return colors_are_words_; }

 private:
  using Target = VertexColumn::Target;

  VertexColumn plan(const PlyProperty& property, const std::array<const PlyProperty*, 3>& axes,
                    const std::array<const PlyProperty*, 3>& channels, const ReadOptions& options,
                    TriangleMesh& mesh) const {
    const auto drop = [&](const char* reason) {
      mesh.dropped_properties.push_back(fmt::format("vertex property '{}' ({})", property.name, reason));
      return VertexColumn{};
    };
    if (property.is_list) return drop("a list");
    for (std::size_t k = 0; k < 3; ++k) {
      if (axes[k] == &property) return {Target::kPosition, k};
      if (has_colors_ && channels[k] == &property)
        return {colors_are_bytes_ ? Target::kColorByte : Target::kColorValue, k};
    }
    if (color_channel(property.name) >= 0) return drop("not one complete set of red, green and blue");
    if (property.name == "alpha") return drop("opacity");
    if (!is_measurement(property)) return drop("an integer, taken for a label");
    if (!options.attributes) return drop("attributes are not asked for");
    mesh.attributes.push_back({property.name, 1, {}});
    return {Target::kAttribute, mesh.attributes.size() - 1};
  }

  std::vector<VertexColumn> columns_;
  bool has_colors_ = false, colors_are_bytes_ = false, colors_are_words_ = false;
};

template <class Values>
class PlyBody {
 public:
  PlyBody(const Source& source, const PlyHeader& header, const ReadOptions& options)
      : source_(source), header_(header), options_(options), values_(source, header.body) {}

  TriangleMesh read() {
    for (const PlyElement& element : header_.elements)
      if (element.name == "vertex") vertex_count_ = element.count;
    for (const PlyElement& element : header_.elements) read_element(element);
    if (!has_vertices_) source_.fail("the header declares no vertices");
    faces_.finish(mesh_);
    for (const std::string& file : header_.texture_files)
      mesh_.dropped_properties.push_back(fmt::format("texture file '{}' (textures are not carried)", file));
    if constexpr (Values::kIsText) {
      if (values_.surplus_lines() > 0)
        mesh_.dropped_properties.push_back(
            fmt::format("{} lines with more values than the header announces", values_.surplus_lines()));
    }
    return std::move(mesh_);
  }

 private:
  void read_element(const PlyElement& element) {
    const std::size_t minimum_size = element.minimum_size(Values::kIsText);
    if (minimum_size > 0 && element.count > values_.bytes_left() / minimum_size)
      source_.fail_at_line(
          element.declared_at,
          fmt::format(
              "{} elements '{}' are announced, but the file ends {} bytes after the elements before them",
              element.count, element.name, values_.bytes_left()));
    if (element.name == "vertex") {
      read_vertices(element);
    } else if (element.name == "face") {
      read_faces(element, false);
    } else if (element.name == "tristrips") {
      read_faces(element, true);
    } else {
      if (element.count > 0)
        mesh_.dropped_properties.push_back(
            fmt::format("{} elements '{}' (unknown to nmc)", element.count, element.name));
      skip_rows(element);
    }
  }

  void read_vertices(const PlyElement& element) {
    has_vertices_ = true;
    if (element.count > options_.maximum_vertices)
      source_.fail_at_line(
          element.declared_at,
          fmt::format("{} vertices, above the limit of {}", element.count, options_.maximum_vertices),
          ExitCode::kLimit);
    const VertexPlan plan(source_, element, options_, mesh_);
    const auto count = static_cast<std::size_t>(element.count);
    std::vector<float> color_values;
    mesh_.positions.resize(count);
    for (VertexAttribute& attribute : mesh_.attributes) attribute.values.resize(count);
    if (plan.colors_are_bytes()) mesh_.colors.resize(count);
    if (plan.has_colors() && !plan.colors_are_bytes()) color_values.resize(3 * count);
    for (std::size_t row = 0; row < count; ++row) {
      values_.begin_row();
      for (std::size_t i = 0; i < element.properties.size(); ++i) {
        const PlyProperty& property = element.properties[i];
        const VertexColumn& column = plan.columns()[i];
        switch (column.target) {
          case VertexColumn::Target::kPosition:
            mesh_.positions[row][static_cast<int>(column.index)] = values_.real(property.type);
            break;
          case VertexColumn::Target::kColorByte:
            mesh_.colors[row][column.index] =
                static_cast<std::uint8_t>(std::clamp<std::int64_t>(values_.integer(property.type), 0, 255));
            break;
          case VertexColumn::Target::kColorValue:
            color_values[3 * row + column.index] = static_cast<float>(values_.real(property.type));
            break;
          case VertexColumn::Target::kAttribute:
            mesh_.attributes[column.index].values[row] = static_cast<float>(values_.real(property.type));
            break;
          case VertexColumn::Target::kSkip:
            skip(property);
            break;
        }
      }
      values_.end_row();
    }
    if (color_values.empty()) return;
    if (plan.colors_are_words()) {
      mesh_.colors.resize(count);
      for (std::size_t i = 0; i < 3 * count; ++i)
        mesh_.colors[i / 3][i % 3] = color_byte(color_values[i], 65535);
    } else {
      mesh_.colors = colors_from_unscaled(color_values);
    }
  }

  void read_faces(const PlyElement& element, bool are_strips) {
    const PlyProperty* corners = nullptr;
    for (const PlyProperty& property : element.properties) {
      if (property.is_list && corners == nullptr &&
          (property.name == "vertex_indices" || property.name == "vertex_index")) {
        corners = &property;
      } else if (element.count > 0) {
        mesh_.dropped_properties.push_back(
            fmt::format("{} property '{}' (only vertices carry signals)", element.name, property.name));
      }
    }
    if (corners == nullptr && element.count > 0)
      source_.fail_at_line(element.declared_at,
                           fmt::format("the element '{}' has no list 'vertex_indices'", element.name));
    if (!are_strips) faces_.reserve(static_cast<std::size_t>(element.count));
    std::vector<std::uint32_t> polygon;
    std::vector<std::int64_t> strip;
    for (std::uint64_t row = 0; row < element.count; ++row) {
      values_.begin_row();
      for (const PlyProperty& property : element.properties) {
        if (&property != corners) {
          skip(property);
        } else if (are_strips) {
          read_strip(property, strip);
        } else {
          read_polygon(property, polygon);
        }
      }
      values_.end_row();
      if (faces_.triangle_count() > options_.maximum_triangles)
        source_.fail(fmt::format("more than {} triangles, which is the limit", options_.maximum_triangles),
                     ExitCode::kLimit);
    }
  }

  std::uint64_t list_size(const PlyProperty& property) {
    const std::int64_t count = values_.integer(property.count_type);
    if (count < 0) values_.fail(fmt::format("a list of {} values", count));
    values_.expect(static_cast<std::uint64_t>(count), property.type);
    return static_cast<std::uint64_t>(count);
  }

  std::int64_t vertex_index(const PlyProperty& property, std::int64_t minimum) {
    const std::int64_t index = values_.integer(property.type);
    if (index < minimum || index >= static_cast<std::int64_t>(vertex_count_))
      values_.fail(fmt::format("vertex index {}, but there are {} vertices", index, vertex_count_));
    return index;
  }

  void read_polygon(const PlyProperty& property, std::vector<std::uint32_t>& polygon) {
    polygon.clear();
    for (std::uint64_t left = list_size(property); left > 0; --left)
      polygon.push_back(static_cast<std::uint32_t>(vertex_index(property, 0)));
    faces_.add(polygon);
  }

  void read_strip(const PlyProperty& property, std::vector<std::int64_t>& strip) {
    strip.clear();
    for (std::uint64_t left = list_size(property); left > 0; --left)
      strip.push_back(vertex_index(property, -1));
    faces_.add_strip(strip);
  }

  void skip(const PlyProperty& property) {
    values_.skip(property.is_list ? list_size(property) : 1, property.type);
  }

  void skip_rows(const PlyElement& element) {
    if (element.properties.empty()) return;
    for (std::uint64_t row = 0; row < element.count; ++row) {
      values_.begin_row();
      for (const PlyProperty& property : element.properties) skip(property);
      values_.end_row();
    }
  }

  const Source& source_;
  const PlyHeader& header_;
  const ReadOptions& options_;
  Values values_;
  TriangleMesh mesh_;
  FaceList faces_;
  std::uint64_t vertex_count_ = 0;
  bool has_vertices_ = false;
};

}  // namespace

TriangleMesh read_ply(const Source& source, const ReadOptions& options) {
  const PlyHeader header = parse_ply_header(source);
  switch (header.encoding) {
    case PlyEncoding::kText:
      return PlyBody<PlyTextValues>(source, header, options).read();
    case PlyEncoding::kLittleEndian:
      return PlyBody<PlyBinaryValues<std::endian::little>>(source, header, options).read();
    case PlyEncoding::kBigEndian:
      break;
  }
  return PlyBody<PlyBinaryValues<std::endian::big>>(source, header, options).read();
}

}  // namespace nmc
