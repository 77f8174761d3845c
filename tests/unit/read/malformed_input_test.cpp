// SPDX-License-Identifier: Apache-2.0
// Every prefix and every single-byte change of a tiny file of each format. A reader may refuse or accept
// them, but it must end, in a mesh that is consistent or in nmc::Error with a position; the sanitizer builds
// see the rest.
#include "tests/unit/read/read_test_tools.h"
#include "tests/unit/read/tiny_meshes.h"

namespace nmc {
namespace {

void check_ends_well(const test::TinyMesh& tiny, std::string_view bytes) {
  try {
    const TriangleMesh mesh = test::read_bytes(tiny.format, bytes);
    for (const Triangle& triangle : mesh.triangles)
      for (const std::uint32_t corner : triangle)
        if (corner >= mesh.vertex_count()) FAIL_CHECK("a triangle refers to vertex " << corner);
    if (!mesh.colors.empty() && mesh.colors.size() != mesh.vertex_count())
      FAIL_CHECK("colours are incomplete");
    for (const VertexAttribute& attribute : mesh.attributes)
      if (attribute.values.size() != mesh.vertex_count())
        FAIL_CHECK("attribute " << attribute.name << " is incomplete");
  } catch (const Error& error) {
    const std::string message = error.what();
    if (!message.starts_with("mesh: ")) FAIL_CHECK("no file name in: " << message);
    if (error.code() != ExitCode::kInvalidInput && error.code() != ExitCode::kUnsupported &&
        error.code() != ExitCode::kInputOutput && error.code() != ExitCode::kLimit)
      FAIL_CHECK("exit code " << static_cast<int>(error.code()) << " for: " << message);
  }
}

TEST_CASE("malformed: every prefix of a file ends in an error, or in a mesh where the format has no counts",
          "[malformed]") {
  for (const test::TinyMesh& tiny : test::tiny_meshes()) {
    for (std::size_t size = 1; size < tiny.bytes.size(); ++size) {
      CAPTURE(tiny.name, size);
      const std::string_view prefix = std::string_view(tiny.bytes).substr(0, size);
      check_ends_well(tiny, prefix);
      if (size < tiny.first_complete_prefix && !test::failure_of(tiny.format, prefix))
        FAIL_CHECK("a cut file was accepted");
    }
  }
}

TEST_CASE("malformed: every change of one byte ends well", "[malformed]") {
  for (const test::TinyMesh& tiny : test::tiny_meshes()) {
    for (std::size_t i = 0; i < tiny.bytes.size(); ++i) {
      for (const int change : {0x01, 0x10, 0x80, 0xff, 0x1000, 0x1001, 0x1002}) {
        std::string bytes = tiny.bytes;
        // Above 0xff: replace by a byte that means something to the parsers.
        bytes[i] = change < 0x100 ? static_cast<char>(bytes[i] ^ change) : "\n-9"[change - 0x1000];
        CAPTURE(tiny.name, i, change);
        check_ends_well(tiny, bytes);
      }
    }
  }
}

TEST_CASE("malformed: garbage of every length is refused in every format", "[malformed]") {
  std::uint32_t state = 12345;
  for (const test::TinyMesh& tiny : test::tiny_meshes()) {
    for (std::size_t size = 1; size < 300; size += 7) {
      std::string bytes;
      for (std::size_t i = 0; i < size; ++i) {
        state = state * 1664525 + 1013904223;
        bytes.push_back(static_cast<char>(state >> 24));
      }
      CAPTURE(tiny.name, size);
      check_ends_well(tiny, bytes);
    }
  }
}

}  // namespace
}  // namespace nmc
