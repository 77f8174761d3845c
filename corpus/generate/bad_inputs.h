// SPDX-License-Identifier: Apache-2.0
// Inputs that break programs: what nmc must encode or refuse with a reason, never crash on.
#ifndef NMC_CORPUS_GENERATE_BAD_INPUTS_H_
#define NMC_CORPUS_GENERATE_BAD_INPUTS_H_

#include <string>
#include <vector>

#include "encoder/core/triangle_mesh.h"

namespace nmc::corpus {

/// What a tool has to do with the file of an input.
enum class Expected {
  kEncoded,  // there is a surface in it
  kRefused,  // exit code 3 and a reason
};

struct BadInput {
  std::string name;  // also the file's name without ".ply"
  Expected expected;
  /// Text of a PLY file where the defect is in the file itself; otherwise empty and `mesh` has the defect.
  std::string file_text;
  TriangleMesh mesh;
  bool is_file() const { return mesh.positions.empty() && mesh.triangles.empty(); }
};

/// The input as a PLY file, with every defect in it: NaN, infinity and indices without a vertex included.
std::string ply_text(const BadInput& input);

/// All of them; about 300,000 triangles together. Deterministic.
std::vector<BadInput> bad_inputs();

}  // namespace nmc::corpus

#endif  // NMC_CORPUS_GENERATE_BAD_INPUTS_H_
