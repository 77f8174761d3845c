// SPDX-License-Identifier: Apache-2.0
#include "bench/decode/timed_codecs.h"

#include <draco/compression/decode.h>
#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>

#include "decoder/tool/stream_source.h"
#include "decoder/tool/tool_error.h"

namespace nmc::bench {

namespace {

double processor_seconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Best of `runs`.
template <class Work>
double best_seconds(int runs, const Work& work) {
  double best = 0;
  for (int run = 0; run < runs; ++run) {
    const double start = processor_seconds();
    work();
    const double seconds = processor_seconds() - start;
    if (run == 0 || seconds < best) best = seconds;
  }
  return best;
}

void check(bool condition, const char* what) {
  if (!condition) throw ToolError(ToolExit::kInternal, what);
}

}  // namespace

DecodeTime time_nmc(const std::vector<std::uint8_t>& stream, int runs, FloatMesh& mesh, nmc_layer& layer,
                    nmc_info& info) {
  DecodeTime result;
  result.bytes = stream.size();
  result.seconds = best_seconds(runs, [&] {
    StreamReader reader;
    check(reader.feed(std::span<const std::uint8_t>(stream)) == NMC_OK, "feeding failed");
    nmc_event event{};
    while (reader.next(event) == NMC_OK) {
    }
    std::uint32_t vertex_count = 0, face_count = 0;
    check(reader.current_layer(layer) == NMC_OK &&
              reader.mesh_size(layer.level, vertex_count, face_count) == NMC_OK,
          "the stream does not decode");
    mesh.positions.resize(std::size_t{3} * vertex_count);
    mesh.indices.resize(std::size_t{3} * face_count);
    check(reader.read_positions(layer.level, std::span<float>(mesh.positions)) == NMC_OK &&
              reader.read_indices(layer.level, mesh.indices) == NMC_OK && reader.info(info) == NMC_OK,
          "the mesh cannot be read");
    std::uint64_t used = 0, peak = 0;
    check(reader.memory(used, peak) == NMC_OK, "no memory figures");
    result.memory_per_triangle =
        (static_cast<double>(peak) + 4.0 * static_cast<double>(mesh.positions.size() + mesh.indices.size())) /
        face_count;
  });
  return result;
}

DecodeTime time_draco(const FloatMesh& mesh, int position_bits, int speed, int runs) {
  draco::Mesh input;
  const std::size_t face_count = mesh.indices.size() / 3;
  const auto vertex_count = static_cast<std::uint32_t>(mesh.positions.size() / 3);
  input.SetNumFaces(face_count);
  for (std::uint32_t f = 0; f < face_count; ++f) {
    draco::Mesh::Face face;
    for (std::size_t k = 0; k < 3; ++k) face[k] = mesh.indices[3 * f + k];
    input.SetFace(draco::FaceIndex(f), face);
  }
  input.set_num_points(vertex_count);
  draco::GeometryAttribute description;
  description.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false, 12, 0);
  const int id = input.AddAttribute(description, true, vertex_count);
  for (std::uint32_t v = 0; v < vertex_count; ++v) {
    input.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v),
                                           mesh.positions.data() + std::size_t{3} * v);
  }
  draco::Encoder encoder;
  encoder.SetSpeedOptions(speed, speed);
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, position_bits);
  draco::EncoderBuffer buffer;
  check(encoder.EncodeMeshToBuffer(input, &buffer).ok(), "Draco refuses the mesh");
  DecodeTime result;
  result.bytes = buffer.size();
  FloatMesh decoded;
  result.seconds = best_seconds(runs, [&] {
    draco::DecoderBuffer compressed;
    compressed.Init(buffer.data(), buffer.size());
    draco::Decoder decoder;
    auto outcome = decoder.DecodeMeshFromBuffer(&compressed);
    check(outcome.ok(), "Draco does not decode");
    const draco::Mesh& output = *outcome.value();
    decoded.positions.resize(std::size_t{3} * output.num_points());
    decoded.indices.resize(std::size_t{3} * output.num_faces());
    const draco::PointAttribute* positions = output.GetNamedAttribute(draco::GeometryAttribute::POSITION);
    for (std::uint32_t v = 0; v < output.num_points(); ++v) {
      positions->GetMappedValue(draco::PointIndex(v), decoded.positions.data() + std::size_t{3} * v);
    }
    for (std::uint32_t f = 0; f < output.num_faces(); ++f) {
      const draco::Mesh::Face& face = output.face(draco::FaceIndex(f));
      for (std::size_t k = 0; k < 3; ++k) decoded.indices[3 * f + k] = face[k].value();
    }
  });
  return result;
}

DecodeTime time_meshopt(const FloatMesh& mesh, int position_bits, int runs) {
  const std::size_t vertex_count = mesh.positions.size() / 3, index_count = mesh.indices.size();
  float low[3] = {INFINITY, INFINITY, INFINITY}, size = 0;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    low[i % 3] = std::min(low[i % 3], mesh.positions[i]);
  for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    size = std::max(size, mesh.positions[i] - low[i % 3]);
  std::vector<std::uint32_t> indices(index_count), remap(vertex_count);
  meshopt_optimizeVertexCache(indices.data(), mesh.indices.data(), index_count, vertex_count);
  meshopt_optimizeVertexFetchRemap(remap.data(), indices.data(), index_count, vertex_count);
  meshopt_remapIndexBuffer(indices.data(), indices.data(), index_count, remap.data());
  std::vector<std::array<std::uint16_t, 4>> vertices(vertex_count);
  const float scale = static_cast<float>((1 << std::min(position_bits, 16)) - 1) / size;
  for (std::size_t v = 0; v < vertex_count; ++v) {
    for (std::size_t k = 0; k < 3; ++k) {
      vertices[remap[v]][k] =
          static_cast<std::uint16_t>(std::lround((mesh.positions[3 * v + k] - low[k]) * scale));
    }
  }
  std::vector<unsigned char> vertex_bytes(meshopt_encodeVertexBufferBound(vertex_count, 8));
  vertex_bytes.resize(
      meshopt_encodeVertexBuffer(vertex_bytes.data(), vertex_bytes.size(), vertices.data(), vertex_count, 8));
  std::vector<unsigned char> index_bytes(meshopt_encodeIndexBufferBound(index_count, vertex_count));
  index_bytes.resize(
      meshopt_encodeIndexBuffer(index_bytes.data(), index_bytes.size(), indices.data(), index_count));
  DecodeTime result;
  result.bytes = vertex_bytes.size() + index_bytes.size();
  FloatMesh decoded;
  result.seconds = best_seconds(runs, [&] {
    decoded.positions.resize(3 * vertex_count);
    decoded.indices.resize(index_count);
    check(meshopt_decodeVertexBuffer(vertices.data(), vertex_count, 8, vertex_bytes.data(),
                                     vertex_bytes.size()) == 0 &&
              meshopt_decodeIndexBuffer(decoded.indices.data(), index_count, 4, index_bytes.data(),
                                        index_bytes.size()) == 0,
          "meshoptimizer does not decode");
    for (std::size_t v = 0; v < vertex_count; ++v) {
      for (std::size_t k = 0; k < 3; ++k)
        decoded.positions[3 * v + k] = low[k] + static_cast<float>(vertices[v][k]) / scale;
    }
  });
  return result;
}

}  // namespace nmc::bench
