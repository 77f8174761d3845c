// SPDX-License-Identifier: Apache-2.0
// glTF accessors as numbers: strided, normalized, quantized and sparse ones alike (glTF 2.0, section 3.6.2).
#ifndef NMC_ENCODER_READ_GLTF_ACCESSOR_H_
#define NMC_ENCODER_READ_GLTF_ACCESSOR_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "encoder/read/gltf_document.h"

namespace nmc {

class GltfAccessor {
 public:
  /// Opens accessor `index` and checks that all its elements lie inside their buffers. `user` is the path of
  /// the object that refers to it.
  GltfAccessor(GltfDocument& document, std::uint64_t index, const std::string& user);

  std::size_t count() const { return count_; }
  std::size_t component_count() const { return component_count_; }
  const std::string& path() const { return path_; }
  bool is_float() const { return component_type_ == ComponentType::kFloat; }
  bool is_unsigned_integer() const {
    return component_type_ == ComponentType::kUint8 || component_type_ == ComponentType::kUint16 ||
           component_type_ == ComponentType::kUint32;
  }
  bool is_normalized() const { return is_normalized_; }

  /// Component `component` of element `i`, mapped to [0, 1] or [-1, 1] where the accessor is normalized;
  /// sparse substitutions are not applied (see sparse_elements).
  double value(std::size_t i, std::size_t component) const {
    return base_.empty() ? 0.0 : value_at(base_.data() + i * stride_, component);
  }

  /// Calls store(i, component, value) for all elements and then again for those that a sparse accessor
  /// replaces.
  template <class Store>
  void for_each(const Store& store) const {
    for (std::size_t i = 0; i < count_; ++i)
      for (std::size_t k = 0; k < component_count_; ++k) store(i, k, value(i, k));
    for (std::size_t s = 0; s < sparse_indices_.size(); ++s)
      for (std::size_t k = 0; k < component_count_; ++k)
        store(sparse_indices_[s], k, value_at(sparse_values_.data() + s * element_size_, k));
  }

 private:
  enum class ComponentType { kInt8 = 5120, kUint8, kInt16, kUint16, kUint32 = 5125, kFloat };

  static std::size_t size_of(ComponentType type);
  ComponentType parse_component_type(const GltfDocument& document, const GltfObject& object) const;
  void open_sparse(GltfDocument& document, const GltfObject& object);
  double value_at(const char* element, std::size_t component) const;
  static double raw_value(const char* at, ComponentType type);

  std::string path_;
  std::size_t count_ = 0;
  std::size_t component_count_ = 0;
  ComponentType component_type_ = ComponentType::kFloat;
  bool is_normalized_ = false;
  std::size_t element_size_ = 0;
  std::size_t stride_ = 0;
  std::span<const char> base_;  // empty: all zeros
  std::vector<std::size_t> sparse_indices_;
  std::span<const char> sparse_values_;
};

}  // namespace nmc

#endif  // NMC_ENCODER_READ_GLTF_ACCESSOR_H_
