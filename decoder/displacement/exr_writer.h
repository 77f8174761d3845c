// SPDX-License-Identifier: Apache-2.0
// Images of floats: OpenEXR version 2, one part, scan lines, not compressed. Readers need nothing special for
// it, and writing it takes no library.
#ifndef NMC_DECODER_DISPLACEMENT_EXR_WRITER_H_
#define NMC_DECODER_DISPLACEMENT_EXR_WRITER_H_

#include <cstdint>
#include <span>
#include <string>

#include "decoder/write/mesh_writer.h"

namespace nmc {

/// `rgb` holds three values per texel, rows from the top: 3 * width * height.
WriteStatus write_exr(const std::string& path, std::uint32_t width, std::uint32_t height,
                      std::span<const float> rgb);

}  // namespace nmc

#endif  // NMC_DECODER_DISPLACEMENT_EXR_WRITER_H_
