// SPDX-License-Identifier: Apache-2.0
// Random damage of the kinds that real files have.
#ifndef NMC_TESTS_UNIT_CONDITION_CORRUPTIONS_H_
#define NMC_TESTS_UNIT_CONDITION_CORRUPTIONS_H_

#include <string>

#include "corpus/generate/random.h"
#include "encoder/core/triangle_mesh.h"

namespace nmc::test {

/// Does one to six random things to the mesh and says which: triangles deleted, doubled, turned, split at one
/// edge only (T-junction), vertices merged, unshared, made NaN, indices out of range or random, slivers
/// inserted.
std::string corrupt(TriangleMesh& mesh, corpus::Random& random);

}  // namespace nmc::test

#endif  // NMC_TESTS_UNIT_CONDITION_CORRUPTIONS_H_
