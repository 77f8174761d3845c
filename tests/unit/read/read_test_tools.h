// SPDX-License-Identifier: Apache-2.0
// Meshes in memory for the tests of the readers.
#ifndef NMC_TESTS_UNIT_READ_READ_TEST_TOOLS_H_
#define NMC_TESTS_UNIT_READ_READ_TEST_TOOLS_H_

#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include "encoder/core/error.h"
#include "encoder/core/triangle_mesh.h"
#include "encoder/read/mesh_reader.h"
#include "tests/unit/read/byte_builder.h"

namespace nmc {

inline std::ostream& operator<<(std::ostream& out, const Vec3& p) {
  return out << '(' << p.x << ", " << p.y << ", " << p.z << ')';
}

namespace test {

/// Reads from a heap block of exactly the size of `bytes`, so that a sanitizer sees every overread.
inline TriangleMesh read_bytes(MeshFormat format, std::string_view bytes, const ReadOptions& options = {}) {
  const auto copy = std::make_unique<std::byte[]>(bytes.size());
  std::copy_n(reinterpret_cast<const std::byte*>(bytes.data()), bytes.size(), copy.get());
  return read_mesh(std::span<const std::byte>(copy.get(), bytes.size()), format, "mesh", options);
}

struct Failure {
  ExitCode code;
  std::string message;
};

/// How reading ends: nothing where it succeeds.
inline std::optional<Failure> failure_of(MeshFormat format, std::string_view bytes,
                                         const ReadOptions& options = {}) {
  try {
    read_bytes(format, bytes, options);
  } catch (const Error& error) {
    return Failure{error.code(), error.what()};
  }
  return std::nullopt;
}

inline void require_failure(MeshFormat format, std::string_view bytes, ExitCode code,
                            const std::string& message_part) {
  const std::optional<Failure> failure = failure_of(format, bytes);
  CAPTURE(std::string(bytes.substr(0, 300)));
  REQUIRE(failure.has_value());
  CAPTURE(failure->message);
  CHECK(failure->code == code);
  CHECK_THAT(failure->message, Catch::Matchers::Contains(message_part));
}

inline bool mentions(const std::vector<std::string>& lines, std::string_view part) {
  return std::any_of(lines.begin(), lines.end(),
                     [&](const std::string& line) { return line.find(part) != std::string::npos; });
}

}  // namespace test
}  // namespace nmc

#endif  // NMC_TESTS_UNIT_READ_READ_TEST_TOOLS_H_
