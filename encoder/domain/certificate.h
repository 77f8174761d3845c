// SPDX-License-Identifier: Apache-2.0
// Proof that a parameterization is a bijection.
//
// Based on: Lipman, "Bijective mappings of meshes with boundary and the degree in mesh processing" (2014): a
// simplicial map with all triangles positively oriented and no vertex winding more than once is a local
// homeomorphism; with boundary loops mapped monotonically to boundary loops it is a bijection.
#ifndef NMC_ENCODER_DOMAIN_CERTIFICATE_H_
#define NMC_ENCODER_DOMAIN_CERTIFICATE_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "encoder/domain/parameterization.h"

namespace nmc {

struct Certificate {
  std::size_t flipped = 0;       // triangles that turn clockwise, by the exact predicate
  std::size_t degenerate = 0;    // triangles without area in the domain
  std::size_t inconsistent = 0;  // edges whose two triangles lay them differently
  std::size_t wound = 0;      // vertices whose triangles turn by something else than the angle of their point
  std::size_t uncovered = 0;  // base vertices without their surface vertex
  std::size_t off_boundary =
      0;  // boundary vertices of the surface that are not on a boundary edge of the domain
  std::vector<std::uint32_t> folded_triangles;  // the flipped and degenerate ones
  double area_ratio = 0;  // sum of all signed areas over the area of the domain; 1 up to rounding

  bool is_bijective() const {
    return flipped + degenerate + inconsistent + wound + uncovered + off_boundary == 0;
  }
};

/// O(n).
Certificate certify(const Parameterization& parameterization);

}  // namespace nmc

#endif  // NMC_ENCODER_DOMAIN_CERTIFICATE_H_
