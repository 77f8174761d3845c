// SPDX-License-Identifier: Apache-2.0
// The header of a PLY file: which elements follow, and how each of their properties is stored.
#ifndef NMC_ENCODER_READ_PLY_HEADER_H_
#define NMC_ENCODER_READ_PLY_HEADER_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "encoder/read/source.h"

namespace nmc {

enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

std::size_t size_of(PlyType type);
inline bool is_real(PlyType type) { return type == PlyType::kFloat32 || type == PlyType::kFloat64; }

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat32;  // of the value, or of a list's items
  bool is_list = false;
  PlyType count_type = PlyType::kUint8;  // lists only; never a real type
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
  const char* declared_at = nullptr;  // its line in the header

  /// The fewest bytes one such element takes: lists empty, text values of one digit and a separator.
  std::size_t minimum_size(bool is_text) const;
};

enum class PlyEncoding { kText, kLittleEndian, kBigEndian };

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kText;
  std::vector<PlyElement> elements;
  std::vector<std::string> texture_files;  // from "comment TextureFile NAME"
  const char* body = nullptr;              // the first byte after the header
};

/// Throws nmc::Error naming the line for everything that is not a well-formed header. Does not judge the
/// counts.
PlyHeader parse_ply_header(const Source& source);

}  // namespace nmc

#endif  // NMC_ENCODER_READ_PLY_HEADER_H_
