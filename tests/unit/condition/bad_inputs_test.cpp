// SPDX-License-Identifier: Apache-2.0
#include "corpus/generate/bad_inputs.h"

#include <catch2/catch.hpp>
#include <span>

#include "encoder/condition/condition.h"
#include "encoder/core/error.h"
#include "encoder/read/mesh_reader.h"
#include "tests/unit/condition/oriented_manifold.h"

using namespace nmc;

namespace {
TriangleMesh read(const corpus::BadInput& input) {
  if (!input.is_file()) return input.mesh;
  return read_mesh(std::as_bytes(std::span(input.file_text)), MeshFormat::kPly, input.name);
}
}  // namespace

TEST_CASE("condition: encodes or refuses every bad input as its description asks", "[condition][bad-input]") {
  for (const corpus::BadInput& input : corpus::bad_inputs()) {
    CAPTURE(input.name);
    std::string refusal;
    try {
      const TriangleMesh mesh = read(input);
      const ConditionedMesh result = condition(mesh);
      CHECK(test::manifold_fault(result.mesh) == "");
      CHECK(test::accounting_fault(mesh, result) == "");
    } catch (const Error& error) {
      refusal = error.what();
      CHECK(error.code() == ExitCode::kInvalidInput);
      CHECK(refusal.size() > 10);
    }
    CAPTURE(refusal);
    CHECK(refusal.empty() == (input.expected == corpus::Expected::kEncoded));
  }
}

TEST_CASE("bad inputs: as PLY text are read back as they are", "[bad-input]") {
  for (const corpus::BadInput& input : corpus::bad_inputs()) {
    if (input.is_file() || input.mesh.triangle_count() > 20000) continue;
    CAPTURE(input.name);
    const std::string text = ply_text(input);
    try {
      const TriangleMesh mesh = read_mesh(std::as_bytes(std::span(text)), MeshFormat::kPly, input.name);
      CHECK(mesh.vertex_count() == input.mesh.vertex_count());
      CHECK(mesh.triangle_count() == input.mesh.triangle_count());
    } catch (const Error& error) {
      // A reader may refuse an index without a vertex itself.
      CHECK(std::string(error.what()).find("ind") != std::string::npos);
    }
  }
}
