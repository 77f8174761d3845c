// SPDX-License-Identifier: Apache-2.0
#include "encoder/read/mesh_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <new>
#include <utility>

#include "encoder/core/error.h"
#include "encoder/read/format_readers.h"
#include "encoder/read/input_bytes.h"
#include "encoder/read/source.h"

namespace nmc {

std::optional<MeshFormat> mesh_format_from_name(std::string_view name) {
  static constexpr std::array<std::pair<std::string_view, MeshFormat>, 6> kNames = {
      {{"ply", MeshFormat::kPly},
       {"obj", MeshFormat::kObj},
       {"stl", MeshFormat::kStl},
       {"off", MeshFormat::kOff},
       {"gltf", MeshFormat::kGltf},
       {"glb", MeshFormat::kGltf}}};
  if (name.starts_with('.')) name.remove_prefix(1);
  std::string lower(name);
  for (char& c : lower)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  for (const auto& [text, format] : kNames)
    if (text == lower) return format;
  return std::nullopt;
}

std::optional<MeshFormat> mesh_format_from_content(std::span<const std::byte> data) {
  const std::string_view text(reinterpret_cast<const char*>(data.data()), data.size());
  if (text.starts_with("ply\n") || text.starts_with("ply\r")) return MeshFormat::kPly;
  if (text.starts_with("glTF")) return MeshFormat::kGltf;
  for (const std::string_view keyword : {"OFF", "COFF", "NOFF", "CNOFF", "STOFF"})
    if (text.starts_with(keyword)) return MeshFormat::kOff;
  return std::nullopt;
}

namespace {

TriangleMesh read_format(const Source& source, MeshFormat format, const ReadOptions& options) {
  switch (format) {
    case MeshFormat::kPly:
      return read_ply(source, options);
    case MeshFormat::kObj:
      return read_obj(source, options);
    case MeshFormat::kStl:
      return read_stl(source, options);
    case MeshFormat::kOff:
      return read_off(source, options);
    case MeshFormat::kGltf:
      return read_gltf(source, options);
  }
  source.fail("no reader for this format", ExitCode::kInternal);
}

}  // namespace

TriangleMesh read_mesh(std::span<const std::byte> data, MeshFormat format, const std::string& display_name,
                       const ReadOptions& options, const std::string& folder) {
  constexpr std::uint64_t kMaximumIndices = 0xfffffffeu;
  const Source source{data, display_name, folder};
  if (data.empty()) source.fail_at_byte(source.begin(), "the file is empty");
  ReadOptions bounded = options;
  bounded.maximum_vertices = std::min(options.maximum_vertices, kMaximumIndices);
  bounded.maximum_triangles = std::min(options.maximum_triangles, kMaximumIndices);
  try {
    return read_format(source, format, bounded);
  } catch (const std::bad_alloc&) {
    source.fail("not enough memory for this mesh", ExitCode::kLimit);
  }
}

TriangleMesh read_mesh(const std::string& path, const ReadOptions& options) {
  const bool is_standard_input = path == "-";
  const std::string name = is_standard_input ? "standard input" : path;
  const std::filesystem::path file(path);
  std::optional<MeshFormat> format = options.format;
  if (!format && !is_standard_input) format = mesh_format_from_name(file.extension().string());
  const InputBytes input = InputBytes::open(path);
  if (!format) format = mesh_format_from_content(input.bytes());
  if (!format)
    throw Error(
        is_standard_input ? ExitCode::kUsage : ExitCode::kUnsupported,
        fmt::format(
            "{}: the format cannot be told from {}; nmc reads PLY, OBJ, STL, OFF and glTF", name,
            is_standard_input ? "its first bytes, so it must be given" : "the name or the first bytes"));
  std::string folder;
  if (!is_standard_input) folder = file.has_parent_path() ? file.parent_path().string() : ".";
  return read_mesh(input.bytes(), *format, name, options, folder);
}

}  // namespace nmc
