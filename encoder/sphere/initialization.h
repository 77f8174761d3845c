// SPDX-License-Identifier: Apache-2.0
// The two starts of the thesis for the spherical energy minimization.
//
// Based on: I. Friedel, thesis, section 4.4; S. Haker et al., "Conformal Surface Parameterization for Texture
// Mapping", TVCG 6, 2000 (stereographic); X. Gu et al., TMI 23, 2004 (centred normalisation).
#ifndef NMC_ENCODER_SPHERE_INITIALIZATION_H_
#define NMC_ENCODER_SPHERE_INITIALIZATION_H_

#include <vector>

#include "encoder/core/triangle_mesh.h"

namespace nmc {

/// Every vertex minus the area-weighted centroid of the surface, scaled to unit length. Usually folded.
std::vector<Vec3> centered_normalization(const TriangleMesh& mesh);

/// The surface without one triangle, mapped harmonically (clipped cotangents) into the image of that
/// triangle, then by inverse stereographic projection to the sphere, scaled so that half the vertices lie on
/// each hemisphere. Free of folds in the plane; the projected triangles may fold. One sparse linear solution.
std::vector<Vec3> stereographic_start(const TriangleMesh& mesh);

}  // namespace nmc

#endif  // NMC_ENCODER_SPHERE_INITIALIZATION_H_
