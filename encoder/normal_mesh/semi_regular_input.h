// SPDX-License-Identifier: Apache-2.0
// Inputs that are semi-regular already: finds the base mesh and the levels from the connectivity of the
// finest mesh, and reads the identity parameterization off it.
//
// Based on: Taubin, "Detecting and reconstructing subdivision connectivity" (The Visual Computer 18, 2002): a
// mesh is the 1-to-4 split of another one when it is tiled by groups of four triangles, a middle one and its
// three neighbours. One group decides about all others of its component, so at most four guesses have to be
// tried. Friedel, section 2.3 (the input as a hierarchy of meshes R^0 ... R^L).
#ifndef NMC_ENCODER_NORMAL_MESH_SEMI_REGULAR_INPUT_H_
#define NMC_ENCODER_NORMAL_MESH_SEMI_REGULAR_INPUT_H_

#include <optional>
#include <vector>

#include "encoder/core/subdivision_hierarchy.h"
#include "encoder/core/triangle_mesh.h"
#include "encoder/domain/parameterization.h"

namespace nmc {

struct SemiRegularInput {
  SubdivisionHierarchy hierarchy;    // levels 0 ... L, L >= 1
  std::vector<Triangle> base_faces;  // of level 0
  std::uint32_t base_vertex_count = 0;
  std::vector<std::uint32_t> input_vertex;  // per vertex of level L: its vertex in the given mesh
};

/// Undoes 1-to-4 splits as long as all components allow it, `maximum_level_count` times at most. nullopt
/// where not even one can be undone, or where `mesh` is not an oriented manifold without unused vertices.
/// O(triangles).
std::optional<SemiRegularInput> recognize_subdivision_connectivity(const TriangleMesh& mesh,
                                                                   int maximum_level_count = 16);

/// The same where the base mesh is known: `mesh` is `base` after `level_count` 1-to-4 splits, or after as
/// many as its triangles say. Vertices of the base keep their places up to `tolerance` (a length above 0);
/// vertices, triangles and corners may be in any order, and components turned inside out. Of several tilings,
/// as on a regular grid around a torus, the one that has the vertices of the base on level 0 is taken. Throws
/// Error (kInvalidInput) that says what of `mesh` does not fit. O(n log n).
SemiRegularInput recognize_subdivision_of(const TriangleMesh& base, const TriangleMesh& mesh,
                                          double tolerance, std::optional<int> level_count = {});

/// The finest mesh as a piecewise linear map from its own base mesh: every vertex at its dyadic point.
/// Vertices and triangles are renumbered to the hierarchy's order.
Parameterization identity_parameterization(const SemiRegularInput& input, const TriangleMesh& mesh);

}  // namespace nmc

#endif  // NMC_ENCODER_NORMAL_MESH_SEMI_REGULAR_INPUT_H_
