// SPDX-License-Identifier: Apache-2.0
// Mesh files out: PLY, OBJ, STL, OFF and GLB. No dependencies, no exceptions.
#ifndef NMC_DECODER_WRITE_MESH_WRITER_H_
#define NMC_DECODER_WRITE_MESH_WRITER_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace nmc {

enum class OutputFormat {
  kPly,      // binary little-endian
  kPlyText,  // ASCII
  kObj,
  kStl,  // binary; positions, and facet normals from them, in single precision
  kOff,
  kGlb,  // glTF 2.0; positions in single precision about a double-precision node translation where that
         // matters
};

/// A mesh that stays where it is. Exactly one of the two position spans is used: three values per vertex.
struct MeshView {
  std::span<const float> positions_single;
  std::span<const double> positions_double;  // written with all their digits by PLY, OBJ and OFF
  std::span<const std::uint32_t> triangles;  // three vertex indices each, counter-clockwise from outside
  std::span<const std::uint8_t> colors;      // sRGB r g b per vertex, or empty; STL cannot hold them
  std::span<const float> normals;            // unit x y z per vertex, or empty; STL cannot hold them

  bool is_double() const { return !positions_double.empty(); }
  std::size_t vertex_count() const {
    return (is_double() ? positions_double.size() : positions_single.size()) / 3;
  }
  std::size_t triangle_count() const { return triangles.size() / 3; }
  double coordinate(std::size_t i) const {
    return is_double() ? positions_double[i] : static_cast<double>(positions_single[i]);
  }
};

enum class WriteOutcome {
  kOk,
  kInputOutput,  // the file cannot be opened, written or renamed
  kUnsupported,  // the format cannot hold this mesh (above 4 GiB as GLB, say)
  kInvalidMesh,  // spans of wrong length or an index out of range: a fault of the caller
};

struct [[nodiscard]] WriteStatus {
  WriteOutcome outcome = WriteOutcome::kOk;
  std::string message;  // "file: reason", empty where the outcome is kOk
  bool is_ok() const { return outcome == WriteOutcome::kOk; }
};

/// Writes `mesh` to `path`; "-" is standard output. The file appears under its name only when it is complete
/// (see output_file.h). Numbers in text are the shortest that read back to the same value. O(size of the
/// mesh), with constant memory besides it.
WriteStatus write_mesh(const std::string& path, const MeshView& mesh, OutputFormat format);

/// A state of a stream, as a viewer chooses it.
struct ProgressiveLayer {
  std::uint64_t byte_length = 0;  // of the prefix that gives it
  std::uint64_t triangle_count = 0;
  bool has_error = false;
  double maximum_error = 0;  // in model units
};

/// A stream that refines a plain mesh.
struct ProgressiveStream {
  std::span<const std::uint8_t> bytes;
  std::array<double, 3> box_minimum{}, box_maximum{};  // of the finest mesh
  std::span<const ProgressiveLayer> layers;
};

/// A GLB whose plain mesh is `coarse`, with triangles, and whose primitive carries `stream` in the extension
/// NMC_progressive_mesh: programs that do not know it draw the coarse mesh, others refine it.
WriteStatus write_progressive_glb(const std::string& path, const MeshView& coarse,
                                  const ProgressiveStream& stream);

/// "ply", "obj", "stl", "off" or "glb" in any case, with or without a leading dot: the format of a file
/// extension.
std::optional<OutputFormat> output_format_from_name(std::string_view name);

}  // namespace nmc

#endif  // NMC_DECODER_WRITE_MESH_WRITER_H_
