// SPDX-License-Identifier: Apache-2.0
// What a conditioned mesh promises, checked by other means than the code under test.
#ifndef NMC_TESTS_UNIT_CONDITION_ORIENTED_MANIFOLD_H_
#define NMC_TESTS_UNIT_CONDITION_ORIENTED_MANIFOLD_H_

#include <string>

#include "encoder/condition/condition.h"

namespace nmc::test {

/// The first way in which the mesh is not an oriented manifold without unused vertices, or "" if it is.
/// OpenMesh, which refuses what it cannot represent, is asked too.
std::string manifold_fault(const TriangleMesh& mesh);

/// The first way in which the maps, fates and counts do not account for every vertex and triangle of the
/// input, or
/// "" if they do.
std::string accounting_fault(const TriangleMesh& input, const ConditionedMesh& output);

/// The first difference of positions or triangles, or "".
std::string difference(const TriangleMesh& a, const TriangleMesh& b);

/// A mesh of the shared corpus, found through NMC_CORPUS or beside the source tree. Missing files fail the
/// test where the environment says CI, and are reported otherwise.
bool read_corpus_mesh(const std::string& file, TriangleMesh& mesh);

}  // namespace nmc::test

#endif  // NMC_TESTS_UNIT_CONDITION_ORIENTED_MANIFOLD_H_
