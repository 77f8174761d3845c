// SPDX-License-Identifier: Apache-2.0
// Directed edges of a base mesh by binary search, for the connectivity coder.
#ifndef NMC_ENCODE_BASE_FACE_LOOKUP_H_
#define NMC_ENCODE_BASE_FACE_LOOKUP_H_

#include "libnmc/common/base_mesh_coder.h"

namespace nmc {

class BaseFaceLookup final : public FaceLookup {
 public:
  explicit BaseFaceLookup(Memory* memory) : edges_(memory), seeds_(memory) {}
  Status build(const std::uint32_t* face_vertices, std::uint32_t face_count, std::uint32_t vertex_count,
               Memory* memory);
  std::uint32_t third_corner(std::uint32_t u, std::uint32_t v) const override;
  /// Three corners of the first face of each component, components in order of their first face.
  const std::uint32_t* seeds() const { return seeds_.data(); }

 private:
  struct Edge {
    std::uint32_t from, to, third;
  };
  Array<Edge> edges_;
  Array<std::uint32_t> seeds_;
};

}  // namespace nmc

#endif  // NMC_ENCODE_BASE_FACE_LOOKUP_H_
