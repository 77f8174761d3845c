// SPDX-License-Identifier: Apache-2.0
// A decoded level as renderers like it: the base mesh with texture coordinates, and an image of vector
// displacements.
//
// Each base face has a square tile of (2^level + 1)^2 texels. The texel at column b0 and row b1 of a tile,
// counted from its upper left one, belongs to the point of the face with barycentric coordinates (b0, b1,
// 2^level - b0 - b1) / 2^level, and holds the decoded vertex minus that point of the flat base face: object
// space, model units, 32-bit floats, red = x, green = y, blue = z. The texels just beyond the diagonal
// continue it linearly, so that a bilinear look-up along the edge of a face gives what the neighbour's tile
// gives there: no cracks at any rate of dicing. The other texels are zero. A renderer that splits the base
// faces into 4^level flat triangles and displaces their corners has the decoded mesh, exactly up to rounding
// to floats.
#ifndef NMC_DECODER_DISPLACEMENT_BASE_AND_DISPLACEMENT_H_
#define NMC_DECODER_DISPLACEMENT_BASE_AND_DISPLACEMENT_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "decoder/write/mesh_writer.h"

namespace nmc {

struct BaseAndDisplacement {
  std::uint32_t base_vertex_count = 0;
  std::vector<std::uint32_t> base_triangles;  // three vertices each
  std::vector<double> texture_coordinates;    // u, v per corner, six per triangle; v points up, as in OBJ
  std::uint32_t image_width = 0, image_height = 0;
  std::vector<float> displacement;  // x, y, z per texel, rows from the top
};

/// Larger images are not made: renderers do not read them.
inline constexpr std::uint32_t kLargestImageSide = 32768;

/// Whether the image of so many base faces at `level` keeps to kLargestImageSide in both directions.
bool fits_in_image(std::uint32_t base_face_count, int level);

/// `triangles` are those of level `level` as nmc_decoder_read_indices gives them, `positions` three
/// coordinates per vertex, base vertices first. Precondition: fits_in_image(). O(size of the image).
BaseAndDisplacement make_base_and_displacement(std::span<const std::uint32_t> triangles,
                                               std::span<const double> positions, int level);

/// Writes PREFIX.obj, whose comments say how to use the image, and PREFIX.exr, uncompressed OpenEXR. `level`
/// is for the comment.
WriteStatus write_base_and_displacement(const std::string& prefix, const BaseAndDisplacement& data,
                                        std::span<const double> positions, int level);

}  // namespace nmc

#endif  // NMC_DECODER_DISPLACEMENT_BASE_AND_DISPLACEMENT_H_
