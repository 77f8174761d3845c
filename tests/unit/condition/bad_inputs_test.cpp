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
  const std::string text = ply_text(input);
  return read_mesh(std::as_bytes(std::span(text)), MeshFormat::kPly, input.name);
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

TEST_CASE("bad inputs: as PLY text hold the defect to the last bit", "[bad-input]") {
  for (const corpus::BadInput& input : corpus::bad_inputs()) {
    if (input.is_file() || input.name.find("index") != std::string::npos ||
        input.name.find("indices_out") != std::string::npos || input.mesh.triangle_count() > 20000)
      continue;
    CAPTURE(input.name);
    const TriangleMesh mesh = read(input);
    CHECK(mesh.triangles == input.mesh.triangles);
    REQUIRE(mesh.vertex_count() == input.mesh.vertex_count());
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
      for (int k = 0; k < 3; ++k) {
        const double read_back = mesh.positions[v][k], original = input.mesh.positions[v][k];
        if (!(read_back == original || (read_back != read_back && original != original)))
          FAIL("coordinate " << k << " of vertex " << v << ": " << read_back << " against " << original);
      }
  }
}
