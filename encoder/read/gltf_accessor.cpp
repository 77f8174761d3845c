// SPDX-License-Identifier: Apache-2.0
#include "encoder/read/gltf_accessor.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "encoder/read/binary_load.h"

namespace nmc {

namespace {

/// 0 for the matrix types, which no vertex attribute has.
std::size_t component_count_of(const std::string& type) {
  if (type == "SCALAR") return 1;
  if (type == "VEC2") return 2;
  if (type == "VEC3") return 3;
  if (type == "VEC4") return 4;
  return 0;
}

/// The bytes of `count` elements, the last of which need not fill its stride.
bool fits(std::uint64_t count, std::uint64_t offset, std::size_t stride, std::size_t element_size,
          std::size_t size) {
  if (offset > size) return false;
  if (count == 0) return true;
  const std::uint64_t available = size - offset;
  return element_size <= available && count - 1 <= (available - element_size) / stride;
}

}  // namespace

GltfAccessor::GltfAccessor(GltfDocument& document, std::uint64_t index, const std::string& user) {
  const GltfObject object = document.element("accessors", index, user);
  path_ = object.path;
  const std::uint64_t count = document.unsigned_member(object, "count");
  component_count_ = component_count_of(document.string_member(object, "type"));
  if (component_count_ == 0) document.fail(path_, "its type is neither a scalar nor a vector");
  component_type_ = parse_component_type(document, object);
  is_normalized_ = document.boolean_member(object, "normalized") && !is_float();
  element_size_ = component_count_ * size_of(component_type_);
  const std::uint64_t offset = document.unsigned_member(object, "byteOffset", 0);
  const bool is_sparse = document.member(object, "sparse") != nullptr;

  if (document.member(object, "bufferView") != nullptr) {
    const GltfBufferView view = document.buffer_view(document.unsigned_member(object, "bufferView"), path_);
    stride_ = view.stride == 0 ? element_size_ : view.stride;
    if (stride_ < element_size_)
      document.fail(path_, fmt::format("elements of {} bytes at a stride of {}", element_size_, stride_));
    if (!fits(count, offset, stride_, element_size_, view.data.size()))
      document.fail(path_, fmt::format("{} elements from byte {} on do not fit in a buffer view of {} bytes",
                                       count, offset, view.data.size()));
    base_ = view.data.subspan(offset);
  } else if (!is_sparse) {
    document.fail(path_, "has no data: neither a bufferView nor sparse values");
  } else if (count > document.byte_count()) {
    document.fail(path_,
                  fmt::format("{} elements are announced, far more than the file has data for", count));
  }
  count_ = static_cast<std::size_t>(count);
  if (is_sparse) open_sparse(document, object);
}

std::size_t GltfAccessor::size_of(ComponentType type) {
  switch (type) {
    case ComponentType::kInt8:
    case ComponentType::kUint8:
      return 1;
    case ComponentType::kInt16:
    case ComponentType::kUint16:
      return 2;
    case ComponentType::kUint32:
    case ComponentType::kFloat:
      return 4;
  }
  return 0;
}

GltfAccessor::ComponentType GltfAccessor::parse_component_type(const GltfDocument& document,
                                                               const GltfObject& object) const {
  const std::uint64_t type = document.unsigned_member(object, "componentType");
  if (type < 5120 || type > 5126 || type == 5124)
    document.fail(object.path, fmt::format("componentType {} does not exist", type));
  return static_cast<ComponentType>(type);
}

void GltfAccessor::open_sparse(GltfDocument& document, const GltfObject& object) {
  const GltfObject sparse{document.member(object, "sparse"), path_ + ".sparse"};
  const std::uint64_t count = document.unsigned_member(sparse, "count");
  const auto part = [&](const char* name) {
    GltfObject found{document.member(sparse, name), sparse.path + "." + name};
    if (found.json == nullptr || !found.json->is_object()) document.fail(found.path, "missing");
    return found;
  };
  const GltfObject indices = part("indices"), values = part("values");
  const ComponentType index_type = parse_component_type(document, indices);
  if (index_type != ComponentType::kUint8 && index_type != ComponentType::kUint16 &&
      index_type != ComponentType::kUint32)
    document.fail(indices.path, "its componentType is not an unsigned integer");
  const auto bytes_of = [&](const GltfObject& part_object, std::size_t size) {
    const GltfBufferView view =
        document.buffer_view(document.unsigned_member(part_object, "bufferView"), part_object.path);
    const std::uint64_t offset = document.unsigned_member(part_object, "byteOffset", 0);
    if (!fits(count, offset, size, size, view.data.size()))
      document.fail(part_object.path, fmt::format("{} elements do not fit in a buffer view of {} bytes",
                                                  count, view.data.size()));
    return view.data.subspan(offset);
  };
  const std::size_t index_size = size_of(index_type);
  const std::span<const char> index_bytes = bytes_of(indices, index_size);
  sparse_values_ = bytes_of(values, element_size_);
  sparse_indices_.reserve(count);
  for (std::size_t s = 0; s < count; ++s) {
    const auto element = static_cast<std::size_t>(raw_value(index_bytes.data() + s * index_size, index_type));
    if (element >= count_)
      document.fail(indices.path, fmt::format("replaces element {}, but there are {}", element, count_));
    sparse_indices_.push_back(element);
  }
}

double GltfAccessor::raw_value(const char* at, ComponentType type) {
  switch (type) {
    case ComponentType::kInt8:
      return load<std::int8_t>(at, std::endian::little);
    case ComponentType::kUint8:
      return load<std::uint8_t>(at, std::endian::little);
    case ComponentType::kInt16:
      return load<std::int16_t>(at, std::endian::little);
    case ComponentType::kUint16:
      return load<std::uint16_t>(at, std::endian::little);
    case ComponentType::kUint32:
      return load<std::uint32_t>(at, std::endian::little);
    case ComponentType::kFloat:
      return load<float>(at, std::endian::little);
  }
  return 0;
}

double GltfAccessor::value_at(const char* element, std::size_t component) const {
  const double raw = raw_value(element + component * size_of(component_type_), component_type_);
  if (!is_normalized_) return raw;
  switch (component_type_) {
    case ComponentType::kInt8:
      return std::max(raw / 127, -1.0);
    case ComponentType::kUint8:
      return raw / 255;
    case ComponentType::kInt16:
      return std::max(raw / 32767, -1.0);
    case ComponentType::kUint16:
      return raw / 65535;
    default:
      return raw;
  }
}

}  // namespace nmc
