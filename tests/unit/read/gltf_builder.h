// SPDX-License-Identifier: Apache-2.0
// glTF documents for the tests: a .glb around any JSON, and base64 for .gltf.
#ifndef NMC_TESTS_UNIT_READ_GLTF_BUILDER_H_
#define NMC_TESTS_UNIT_READ_GLTF_BUILDER_H_

#include <cstdint>
#include <string>
#include <string_view>

#include "tests/unit/read/byte_builder.h"

namespace nmc::test {

/// A .glb container; both chunks are padded to four bytes as the format demands.
inline std::string glb(std::string json, std::string binary = {}) {
  json.resize((json.size() + 3) / 4 * 4, ' ');
  binary.resize((binary.size() + 3) / 4 * 4, '\0');
  const std::size_t size = 12 + 8 + json.size() + (binary.empty() ? 0 : 8 + binary.size());
  Bytes bytes;
  bytes.text("glTF").number(std::uint32_t{2}).number(static_cast<std::uint32_t>(size));
  bytes.number(static_cast<std::uint32_t>(json.size())).text("JSON").text(json);
  if (!binary.empty()) {
    bytes.number(static_cast<std::uint32_t>(binary.size())).text(std::string_view("BIN\0", 4)).text(binary);
  }
  return bytes.string();
}

inline std::string base64(std::string_view bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k)
      bits = (bits << 8) | (i + k < bytes.size() ? static_cast<std::uint8_t>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      text.push_back(i + k <= bytes.size() ? kDigits[(bits >> (18 - 6 * k)) & 63] : '=');
  }
  return text;
}

}  // namespace nmc::test

#endif  // NMC_TESTS_UNIT_READ_GLTF_BUILDER_H_
