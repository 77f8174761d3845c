// SPDX-License-Identifier: Apache-2.0
// The writers of the single formats behind write_mesh(). The mesh is checked before they are called; errors
// of the file stick to it. Only the GLB writer can find a mesh its format does not hold.
#ifndef NMC_DECODER_WRITE_FORMAT_WRITERS_H_
#define NMC_DECODER_WRITE_FORMAT_WRITERS_H_

#include <string>

#include "decoder/write/mesh_writer.h"
#include "decoder/write/output_file.h"

namespace nmc {

void write_ply(const MeshView& mesh, bool as_text, OutputFile& file);
void write_obj(const MeshView& mesh, OutputFile& file);
void write_stl(const MeshView& mesh, OutputFile& file);
void write_off(const MeshView& mesh, OutputFile& file);

/// Why GLB cannot hold `mesh` and the stream that refines it (null: none); empty where it can.
std::string reason_against_glb(const MeshView& mesh, const ProgressiveStream* progressive);
void write_glb(const MeshView& mesh, const ProgressiveStream* progressive, OutputFile& file);

}  // namespace nmc

#endif  // NMC_DECODER_WRITE_FORMAT_WRITERS_H_
