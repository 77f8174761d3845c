// SPDX-License-Identifier: Apache-2.0
// From a surface to maps onto nested base domains: the one call that the rest of the encoder makes.
#ifndef NMC_ENCODER_DOMAIN_PARAMETERIZE_H_
#define NMC_ENCODER_DOMAIN_PARAMETERIZE_H_

#include <vector>

#include "encoder/core/progress.h"
#include "encoder/domain/maps_collapse.h"
#include "encoder/domain/parameterization.h"
#include "encoder/domain/relaxation.h"

namespace nmc {

/// One parameterization per entry of `base_sizes` (numbers of base vertices, summed over all components;
/// reached as nearly as topology, creases and boundaries allow), all from one run of collapses, so the base
/// vertices are nested.
///
/// `mesh` must be an oriented 2-manifold with or without boundary; any genus, any number of components. Every
/// map is a bijection (certify() in certificate.h counts its folds: 0). Deterministic, the same for any
/// number of threads. O(n log n). Throws Error (kInvalidInput) where the mesh is not an oriented manifold.
std::vector<Parameterization> parameterize(const TriangleMesh& mesh, const std::vector<int>& base_sizes,
                                           const CollapseOptions& collapse_options = {},
                                           const RelaxationOptions& relaxation_options = {},
                                           const Progress& progress = {});

}  // namespace nmc

#endif  // NMC_ENCODER_DOMAIN_PARAMETERIZE_H_
