// SPDX-License-Identifier: Apache-2.0
#include "encoder/measure/stream_layers.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <vector>

#include "encoder/core/error.h"
#include "libnmc/include/nmc/nmc.hpp"

namespace nmc {
namespace {

ExitCode exit_code_of(nmc_status status) {
  switch (status) {
    case NMC_ERR_VERSION:
    case NMC_ERR_FEATURE:
      return ExitCode::kUnsupported;
    case NMC_ERR_LIMIT:
    case NMC_ERR_NO_MEMORY:
      return ExitCode::kLimit;
    case NMC_ERR_TRUNCATED:
      return ExitCode::kCutOff;
    default:
      return ExitCode::kInvalidInput;
  }
}

void check(nmc_status status, const StreamReader& reader, const std::string& path) {
  if (status == NMC_OK) return;
  const nmc_error_detail detail = reader.error();
  throw Error(exit_code_of(status), path + ": byte offset " + std::to_string(detail.byte_offset) + ": " +
                                        (detail.message[0] != 0 ? detail.message : nmc_status_name(status)));
}

std::vector<char> read_bytes(const std::string& path) {
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error(ExitCode::kInputOutput, path + ": cannot be opened: " + std::strerror(errno));
  std::vector<char> bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (file.bad()) throw Error(ExitCode::kInputOutput, path + ": cannot be read");
  return bytes;
}

TriangleMesh current_mesh(StreamReader& reader, std::uint32_t level, const std::string& path) {
  std::uint32_t vertex_count = 0, face_count = 0;
  check(reader.mesh_size(level, vertex_count, face_count), reader, path);
  std::vector<std::uint32_t> indices(std::size_t{3} * face_count);
  std::vector<double> coordinates(std::size_t{3} * vertex_count);
  check(reader.read_indices(level, indices), reader, path);
  check(reader.read_positions(level, std::span<double>(coordinates)), reader, path);
  TriangleMesh mesh;
  mesh.positions.resize(vertex_count);
  for (std::size_t v = 0; v < vertex_count; ++v) {
    mesh.positions[v] = {coordinates[3 * v], coordinates[3 * v + 1], coordinates[3 * v + 2]};
  }
  mesh.triangles.resize(face_count);
  for (std::size_t t = 0; t < face_count; ++t) {
    mesh.triangles[t] = {indices[3 * t], indices[3 * t + 1], indices[3 * t + 2]};
  }
  nmc_info info{};
  check(reader.info(info), reader, path);
  std::vector<std::uint8_t> rgb(info.has_colors ? std::size_t{3} * vertex_count : 0);
  // The first layers of a stream may come without their colours.
  if (info.has_colors && reader.read_colors(level, rgb) == NMC_OK) {
    mesh.colors.resize(vertex_count);
    for (std::size_t v = 0; v < vertex_count; ++v)
      mesh.colors[v] = {rgb[3 * v], rgb[3 * v + 1], rgb[3 * v + 2]};
  }
  return mesh;
}

// Feeds the whole stream, calls visit(layer) at every layer that is whole, and returns the last of them.
template <class Visit>
nmc_layer decode(StreamReader& reader, std::span<const std::byte> bytes, const std::string& path,
                 const Visit& visit) {
  check(reader.status(), reader, path);
  check(reader.feed(bytes), reader, path);
  nmc_layer layer{};
  bool any_layer = false;
  while (true) {
    nmc_event event{};
    const nmc_status status = reader.next(event);
    if (status == NMC_NEED_MORE_INPUT) break;
    check(status, reader, path);
    if (event == NMC_EVENT_END) break;
    if (event != NMC_EVENT_LAYER) continue;
    check(reader.current_layer(layer), reader, path);
    visit(layer);
    any_layer = true;
  }
  if (!any_layer) {
    throw Error(ExitCode::kCutOff, path + ": the file ends after " + std::to_string(bytes.size()) +
                                       " bytes, before its first layer is whole");
  }
  return layer;
}

}  // namespace

bool is_stream_name(const std::string& path) {
  std::string ending = path.size() > 4 ? path.substr(path.size() - 4) : "";
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return ending == ".nmc";
}

void visit_stream_layers(const std::string& path,
                         const std::function<void(const StreamLayer&, const TriangleMesh&)>& visit) {
  const std::vector<char> bytes = read_bytes(path);
  StreamReader reader;
  decode(reader, std::as_bytes(std::span(bytes)), path, [&](const nmc_layer& layer) {
    visit({layer.end_offset, layer.level, layer.has_error != 0, layer.rms_error, layer.max_error},
          current_mesh(reader, layer.level, path));
  });
}

TriangleMesh read_stream(const std::string& path) {
  const std::vector<char> bytes = read_bytes(path);
  return read_stream(std::as_bytes(std::span(bytes)), path);
}

TriangleMesh read_stream(std::span<const std::byte> bytes, const std::string& name) {
  StreamReader reader;
  const nmc_layer last = decode(reader, bytes, name, [](const nmc_layer&) {});
  return current_mesh(reader, last.level, name);
}

}  // namespace nmc
