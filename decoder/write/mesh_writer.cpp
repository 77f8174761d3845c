// SPDX-License-Identifier: Apache-2.0
#include "decoder/write/mesh_writer.h"

#include <algorithm>
#include <array>
#include <utility>

#include "decoder/write/format_writers.h"
#include "decoder/write/output_file.h"

namespace nmc {

namespace {

/// What is wrong with the spans of `mesh`; nullptr where they fit together.
const char* defect_of(const MeshView& mesh) {
  if (!mesh.positions_single.empty() && !mesh.positions_double.empty())
    return "positions in single and in double precision";
  if (mesh.positions_single.size() % 3 != 0 || mesh.positions_double.size() % 3 != 0)
    return "positions are not whole points";
  if (mesh.triangles.size() % 3 != 0) return "triangles are not whole";
  const std::size_t count = mesh.vertex_count();
  if (count > 0xfffffffeu || mesh.triangle_count() > 0xfffffffeu)
    return "more than 2^32 - 2 vertices or triangles";
  if (!mesh.colors.empty() && mesh.colors.size() != 3 * count) return "not one colour per vertex";
  if (!mesh.normals.empty() && mesh.normals.size() != 3 * count) return "not one normal per vertex";
  if (std::any_of(mesh.triangles.begin(), mesh.triangles.end(), [&](std::uint32_t i) { return i >= count; }))
    return "a triangle refers to a vertex that is not there";
  return nullptr;
}

WriteStatus refused(const std::string& path, WriteOutcome outcome, const std::string& reason) {
  return {outcome, (path == "-" ? "standard output" : path) + ": " + reason};
}

}  // namespace

WriteStatus write_mesh(const std::string& path, const MeshView& mesh, OutputFormat format) {
  if (const char* const defect = defect_of(mesh)) return refused(path, WriteOutcome::kInvalidMesh, defect);
  if (format == OutputFormat::kGlb) {
    const std::string reason = reason_against_glb(mesh, nullptr);
    if (!reason.empty()) return refused(path, WriteOutcome::kUnsupported, reason);
  }
  OutputFile file(path);
  switch (format) {
    case OutputFormat::kPly:
      write_ply(mesh, false, file);
      break;
    case OutputFormat::kPlyText:
      write_ply(mesh, true, file);
      break;
    case OutputFormat::kObj:
      write_obj(mesh, file);
      break;
    case OutputFormat::kStl:
      write_stl(mesh, file);
      break;
    case OutputFormat::kOff:
      write_off(mesh, file);
      break;
    case OutputFormat::kGlb:
      write_glb(mesh, nullptr, file);
      break;
  }
  if (!file.commit()) return {WriteOutcome::kInputOutput, file.error()};
  return {};
}

WriteStatus write_progressive_glb(const std::string& path, const MeshView& coarse,
                                  const ProgressiveStream& stream) {
  if (const char* const defect = defect_of(coarse)) return refused(path, WriteOutcome::kInvalidMesh, defect);
  if (coarse.triangles.empty()) {
    return refused(path, WriteOutcome::kInvalidMesh, "the coarse mesh has no triangles");
  }
  const std::string reason = reason_against_glb(coarse, &stream);
  if (!reason.empty()) return refused(path, WriteOutcome::kUnsupported, reason);
  OutputFile file(path);
  write_glb(coarse, &stream, file);
  if (!file.commit()) return {WriteOutcome::kInputOutput, file.error()};
  return {};
}

std::optional<OutputFormat> output_format_from_name(std::string_view name) {
  static constexpr std::array<std::pair<std::string_view, OutputFormat>, 5> kNames = {
      {{"ply", OutputFormat::kPly},
       {"obj", OutputFormat::kObj},
       {"stl", OutputFormat::kStl},
       {"off", OutputFormat::kOff},
       {"glb", OutputFormat::kGlb}}};
  if (name.starts_with('.')) name.remove_prefix(1);
  std::string lower(name);
  for (char& c : lower)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  for (const auto& [text, format] : kNames)
    if (text == lower) return format;
  return std::nullopt;
}

}  // namespace nmc
