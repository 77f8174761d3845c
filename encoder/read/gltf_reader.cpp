// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "encoder/read/format_readers.h"
#include "encoder/read/gltf_accessor.h"
#include "encoder/read/gltf_document.h"
#include "encoder/read/gltf_transform.h"
#include "encoder/read/vertex_colors.h"

namespace nmc {

namespace {

using nlohmann::json;

constexpr std::uint64_t kModeTriangles = 4, kModeTriangleStrip = 5, kModeTriangleFan = 6;
constexpr std::uint64_t kMissing = ~std::uint64_t{0};

class GltfReader {
 public:
  GltfReader(const Source& source, const ReadOptions& options) : document_(source), options_(options) {}

  TriangleMesh read() {
    if (document_.count("nodes") == 0) {
      // A library of meshes without any scene: each once, as it is stored.
      for (std::size_t i = 0; i < document_.count("meshes"); ++i) add_mesh(i, "meshes", AffineTransform());
    } else {
      walk_scene();
    }
    if (!mesh_.colors.empty()) mesh_.colors.resize(mesh_.positions.size(), {255, 255, 255});
    report_dropped();
    return std::move(mesh_);
  }

 private:
  struct PendingNode {
    std::uint64_t index;
    AffineTransform parent;
    std::string user;
  };

  std::vector<std::uint64_t> indices_member(const GltfObject& object, const char* key) const {
    std::vector<std::uint64_t> indices;
    const json* const array = document_.member(object, key);
    if (array == nullptr) return indices;
    if (!array->is_array()) document_.fail(object.path, fmt::format("'{}' is not an array", key));
    for (const json& entry : *array) {
      if (!entry.is_number_unsigned()) document_.fail(object.path, fmt::format("'{}' holds no index", key));
      indices.push_back(entry.get<std::uint64_t>());
    }
    return indices;
  }

  /// The nodes of the default scene, else of the first one, else all that are nobody's child.
  std::vector<PendingNode> root_nodes() const {
    std::vector<PendingNode> roots;
    const GltfObject root{&document_.root(), "glTF"};
    if (document_.count("scenes") > 0) {
      const GltfObject scene =
          document_.element("scenes", document_.unsigned_member(root, "scene", 0), "scene");
      for (const std::uint64_t index : indices_member(scene, "nodes"))
        roots.push_back({index, {}, scene.path});
      return roots;
    }
    const std::size_t count = document_.count("nodes");
    std::vector<bool> is_child(count, false);
    for (std::size_t i = 0; i < count; ++i)
      for (const std::uint64_t child : indices_member(document_.element("nodes", i, "nodes"), "children"))
        if (child < count) is_child[child] = true;
    for (std::size_t i = 0; i < count; ++i)
      if (!is_child[i]) roots.push_back({i, {}, "nodes"});
    return roots;
  }

  /// Depth first, in the order of the file. The specification demands a forest; a node met twice is refused,
  /// so that neither a cycle nor a tower of shared children can multiply the work.
  void walk_scene() {
    std::vector<PendingNode> pending = root_nodes();
    std::reverse(pending.begin(), pending.end());
    std::vector<bool> visited(document_.count("nodes"), false);
    while (!pending.empty()) {
      const PendingNode next = std::move(pending.back());
      pending.pop_back();
      const GltfObject node = document_.element("nodes", next.index, next.user);
      if (visited[next.index]) document_.fail(node.path, "is reached twice, but nodes form a tree");
      visited[next.index] = true;
      const AffineTransform transform = next.parent * node_transform(node);
      add_node(node, transform);
      const std::vector<std::uint64_t> children = indices_member(node, "children");
      for (auto child = children.rbegin(); child != children.rend(); ++child)
        pending.push_back({*child, transform, node.path});
    }
  }

  AffineTransform node_transform(const GltfObject& node) const {
    if (const auto matrix = document_.numbers_member(node, "matrix", 16))
      return AffineTransform::from_matrix(*matrix);
    const auto translation =
        document_.numbers_member(node, "translation", 3).value_or(std::vector<double>{0, 0, 0});
    const auto rotation =
        document_.numbers_member(node, "rotation", 4).value_or(std::vector<double>{0, 0, 0, 1});
    const auto scale = document_.numbers_member(node, "scale", 3).value_or(std::vector<double>{1, 1, 1});
    return AffineTransform::from_parts({translation[0], translation[1], translation[2]},
                                       {rotation[0], rotation[1], rotation[2], rotation[3]},
                                       {scale[0], scale[1], scale[2]});
  }

  void add_node(const GltfObject& node, const AffineTransform& transform) {
    if (document_.member(node, "mesh") == nullptr) return;
    const std::uint64_t mesh = document_.unsigned_member(node, "mesh");
    if (document_.member(node, "skin") != nullptr) {
      // A skinned mesh takes its place from its joints alone (section 3.7.3.3); the bind pose is in model
      // space.
      ++skinned_meshes_;
      add_mesh(mesh, node.path, AffineTransform());
    } else if (document_.has_extension(node, "EXT_mesh_gpu_instancing")) {
      for (const AffineTransform& instance : instance_transforms(node))
        add_mesh(mesh, node.path, transform * instance);
    } else {
      add_mesh(mesh, node.path, transform);
    }
  }

  std::vector<AffineTransform> instance_transforms(const GltfObject& node) {
    const std::string path = node.path + ".extensions.EXT_mesh_gpu_instancing";
    const GltfObject extension{&(*node.json)["extensions"]["EXT_mesh_gpu_instancing"], path};
    const GltfObject attributes = object_member(extension, "attributes");
    std::array<std::vector<std::vector<double>>, 3> parts;
    constexpr std::array<std::pair<const char*, std::size_t>, 3> kParts = {
        {{"TRANSLATION", 3}, {"ROTATION", 4}, {"SCALE", 3}}};
    std::size_t count = 0;
    for (std::size_t p = 0; p < kParts.size(); ++p) {
      const auto [name, size] = kParts[p];
      const std::uint64_t index = document_.unsigned_member(attributes, name, kMissing);
      if (index == kMissing) continue;
      const GltfAccessor accessor(document_, index, attributes.path);
      if (accessor.component_count() != size || (count > 0 && accessor.count() != count))
        document_.fail(accessor.path(), fmt::format("does not fit as {} of instances", name));
      count = accessor.count();
      parts[p].assign(count, std::vector<double>(size));
      accessor.for_each([&](std::size_t i, std::size_t k, double value) { parts[p][i][k] = value; });
    }
    std::vector<AffineTransform> transforms;
    for (std::size_t i = 0; i < count; ++i) {
      const auto vector_of = [&](std::size_t p, double fallback) {
        return parts[p].empty() ? Vec3{fallback, fallback, fallback}
                                : Vec3{parts[p][i][0], parts[p][i][1], parts[p][i][2]};
      };
      std::array<double, 4> rotation = {0, 0, 0, 1};
      if (!parts[1].empty()) std::copy(parts[1][i].begin(), parts[1][i].end(), rotation.begin());
      transforms.push_back(AffineTransform::from_parts(vector_of(0, 0), rotation, vector_of(2, 1)));
    }
    return transforms;
  }

  GltfObject object_member(const GltfObject& object, const char* key) const {
    GltfObject found{document_.member(object, key), object.path + "." + key};
    if (found.json == nullptr || !found.json->is_object()) document_.fail(found.path, "missing");
    return found;
  }

  void add_mesh(std::uint64_t index, const std::string& user, const AffineTransform& transform) {
    const GltfObject mesh = document_.element("meshes", index, user);
    const json* const primitives = document_.member(mesh, "primitives");
    if (primitives == nullptr || !primitives->is_array()) document_.fail(mesh.path, "has no primitives");
    first_vertices_.clear();
    for (std::size_t i = 0; i < primitives->size(); ++i) {
      const GltfObject primitive{&(*primitives)[i], fmt::format("{}.primitives[{}]", mesh.path, i)};
      if (!primitive.json->is_object()) document_.fail(primitive.path, "not an object");
      add_primitive(primitive, transform);
    }
  }

  void add_primitive(const GltfObject& primitive, const AffineTransform& transform) {
    const std::uint64_t mode = document_.unsigned_member(primitive, "mode", kModeTriangles);
    if (mode > kModeTriangleFan) document_.fail(primitive.path, fmt::format("mode {} does not exist", mode));
    if (mode < kModeTriangles) {
      ++dropped_["primitives of points or lines"];
      return;
    }
    const GltfObject attributes = object_member(primitive, "attributes");
    const std::uint64_t position = document_.unsigned_member(attributes, "POSITION", kMissing);
    const std::uint64_t indices = document_.unsigned_member(primitive, "indices", kMissing);
    if (document_.has_extension(primitive, "KHR_draco_mesh_compression"))
      expect_uncompressed_copy(primitive, position, indices);
    if (position == kMissing) {
      ++dropped_["primitives without positions"];
      return;
    }
    note_unused(primitive, attributes);
    const std::uint64_t color = document_.unsigned_member(attributes, "COLOR_0", kMissing);
    const auto [first, count] = add_vertices(position, color, attributes.path, transform);
    add_triangles(mode, indices, primitive.path, first, count, transform.mirrors());
  }

  void expect_uncompressed_copy(const GltfObject& primitive, std::uint64_t position,
                                std::uint64_t indices) const {
    for (const std::uint64_t index : {position, indices}) {
      if (index == kMissing) continue;
      if (document_.member(document_.element("accessors", index, primitive.path), "bufferView") == nullptr)
        document_.fail(
            primitive.path,
            "compressed with KHR_draco_mesh_compression, which nmc does not read; decompress the file first",
            ExitCode::kUnsupported);
    }
  }

  void note_unused(const GltfObject& primitive, const GltfObject& attributes) {
    for (const auto& [name, accessor] : attributes.json->items())
      if (name != "POSITION" && name != "COLOR_0")
        ++dropped_[fmt::format("primitives with the attribute '{}'", name.substr(0, 40))];
    if (document_.member(primitive, "material") != nullptr) ++dropped_["primitives with a material"];
    if (document_.member(primitive, "targets") != nullptr)
      ++dropped_["primitives with morph targets (the shape without them is taken)"];
  }

  /// Appends the vertices of one instance of a mesh, once for all of its primitives that share them.
  std::pair<std::uint32_t, std::size_t> add_vertices(std::uint64_t position, std::uint64_t color,
                                                     const std::string& user,
                                                     const AffineTransform& transform) {
    const GltfAccessor positions(document_, position, user);
    const auto [known, is_new] = first_vertices_.try_emplace({position, color}, mesh_.positions.size());
    const auto first = static_cast<std::uint32_t>(known->second);
    if (!is_new) return {first, positions.count()};
    if (positions.component_count() != 3)
      document_.fail(positions.path(), "positions do not have three components");
    if (positions.count() > options_.maximum_vertices - mesh_.positions.size())
      document_.fail(positions.path(),
                     fmt::format("more than {} vertices, which is the limit", options_.maximum_vertices),
                     ExitCode::kLimit);
    mesh_.positions.resize(first + positions.count());
    positions.for_each([&](std::size_t i, std::size_t k, double value) {
      mesh_.positions[first + i][static_cast<int>(k)] = value;
    });
    for (std::size_t i = first; i < mesh_.positions.size(); ++i)
      mesh_.positions[i] = transform(mesh_.positions[i]);
    if (color != kMissing) add_colors(GltfAccessor(document_, color, user), first, positions.count());
    return {first, positions.count()};
  }

  void add_colors(const GltfAccessor& colors, std::size_t first, std::size_t count) {
    if (colors.component_count() < 3 || colors.count() != count ||
        !(colors.is_float() || colors.is_normalized()))
      document_.fail(colors.path(), "not a colour for each vertex");
    mesh_.colors.resize(first, {255, 255, 255});
    mesh_.colors.resize(first + count);
    bool is_opaque = true;
    colors.for_each([&](std::size_t i, std::size_t k, double value) {
      if (k < 3) mesh_.colors[first + i][k] = srgb_byte_from_linear(value);
      if (k == 3 && !(value >= 1)) is_opaque = false;
    });
    if (!is_opaque) ++dropped_["primitives with vertex opacities"];
  }

  void add_triangles(std::uint64_t mode, std::uint64_t indices, const std::string& user, std::uint32_t first,
                     std::size_t vertex_count, bool mirrored) {
    std::vector<std::uint32_t> corners;
    if (indices == kMissing) {
      corners.resize(vertex_count);
      for (std::size_t i = 0; i < vertex_count; ++i) corners[i] = static_cast<std::uint32_t>(i);
    } else {
      const GltfAccessor accessor(document_, indices, user);
      if (accessor.component_count() != 1 || !accessor.is_unsigned_integer() || accessor.is_normalized())
        document_.fail(accessor.path(), "indices are not plain unsigned integers");
      corners.resize(accessor.count());
      accessor.for_each(
          [&](std::size_t i, std::size_t, double value) { corners[i] = static_cast<std::uint32_t>(value); });
      for (std::size_t i = 0; i < corners.size(); ++i)
        if (corners[i] >= vertex_count)
          document_.fail(accessor.path(), fmt::format("element {} is vertex {}, but there are {}", i,
                                                      corners[i], vertex_count));
    }
    if (mode == kModeTriangles && corners.size() % 3 != 0)
      document_.fail(user, fmt::format("{} corners are not whole triangles", corners.size()));
    const std::size_t step = mode == kModeTriangles ? 3 : 1;
    // Joints count too: a strip of nothing but joints, shown a million times, must end as well.
    triangles_seen_ += corners.size() / step;
    if (triangles_seen_ > options_.maximum_triangles)
      document_.fail(user,
                     fmt::format("more than {} triangles, which is the limit", options_.maximum_triangles),
                     ExitCode::kLimit);
    for (std::size_t i = 2; i < corners.size(); i += step) {
      Triangle triangle = {corners[i - 2], corners[i - 1], corners[i]};
      if (mode == kModeTriangleFan) triangle = {corners[i - 1], corners[i], corners[0]};
      if (mode == kModeTriangleStrip && i % 2 == 1) std::swap(triangle[1], triangle[2]);
      // Two equal corners join strips; in a list of triangles they are a fault of the mesh, and
      // conditioning's.
      const bool is_joint =
          mode != kModeTriangles &&
          (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0]);
      if (is_joint) continue;
      if (mirrored) std::swap(triangle[1], triangle[2]);
      for (std::uint32_t& corner : triangle) corner += first;
      mesh_.triangles.push_back(triangle);
    }
  }

  void report_dropped() {
    for (const auto& [what, count] : dropped_)
      mesh_.dropped_properties.push_back(fmt::format("{} {}", count, what));
    if (skinned_meshes_ > 0)
      mesh_.dropped_properties.push_back(fmt::format("{} skins (the bind pose is taken)", skinned_meshes_));
    if (document_.count("animations") > 0)
      mesh_.dropped_properties.push_back(fmt::format("{} animations", document_.count("animations")));
  }

  GltfDocument document_;
  const ReadOptions& options_;
  TriangleMesh mesh_;
  std::map<std::pair<std::uint64_t, std::uint64_t>, std::size_t>
      first_vertices_;  // of one instance of a mesh
  std::map<std::string, std::uint64_t> dropped_;
  std::uint64_t skinned_meshes_ = 0;
  std::uint64_t triangles_seen_ = 0;
};

}  // namespace

TriangleMesh read_gltf(const Source& source, const ReadOptions& options) {
  return GltfReader(source, options).read();
}

}  // namespace nmc
