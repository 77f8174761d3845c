// SPDX-License-Identifier: Apache-2.0
// How fast streams decode, against Draco and meshoptimizer on the very same triangles: in process, one
// thread, best of several runs with memory warm, processor time, from compressed bytes to float positions and
// 32-bit indices.
//
// Usage: nmc-bench-decode [--csv] [--runs N] FILE.nmc...
//
// Draco and meshoptimizer get the decoded mesh with as many bits per coordinate as keep their rounding below
// the root mean square error that the stream states (and at least 10), so that all three deliver the surface
// at that quality.
#include <draco/compression/decode.h>
#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>
#include <malloc.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <string>
#include <vector>

#include "decoder/tool/stream_source.h"
#include "decoder/tool/tool_error.h"

namespace {

using namespace nmc;

struct Mesh {
  std::vector<float> positions;
  std::vector<std::uint32_t> indices;
};

struct Measurement {
  std::size_t bytes = 0;
  double seconds = 0;
  double memory_per_triangle = 0;  // 0: not known
};

double processor_seconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
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

Measurement measure_nmc(const std::vector<std::uint8_t>& stream, int runs, Mesh& mesh, nmc_layer& layer,
                        nmc_info& info) {
  Measurement result;
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

Measurement measure_draco(const Mesh& mesh, int bits, int speed, int runs) {
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
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, bits);
  draco::EncoderBuffer buffer;
  check(encoder.EncodeMeshToBuffer(input, &buffer).ok(), "Draco refuses the mesh");
  Measurement result;
  result.bytes = buffer.size();
  Mesh decoded;
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

Measurement measure_meshopt(const Mesh& mesh, int bits, int runs) {
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
  const float scale = static_cast<float>((1 << std::min(bits, 16)) - 1) / size;
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
  Measurement result;
  result.bytes = vertex_bytes.size() + index_bytes.size();
  Mesh decoded;
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

void print(bool csv, const std::string& file, const char* codec, std::size_t triangle_count,
           const Measurement& m) {
  const double millions = static_cast<double>(triangle_count) / m.seconds / 1e6;
  const double output = static_cast<double>(triangle_count) * 18 / m.seconds / 1e6;  // 12 + 12 / 2 bytes
  if (csv) {
    std::printf("%s,%s,%zu,%zu,%.6f,%.3f,%.1f,%.1f\n", file.c_str(), codec, triangle_count, m.bytes,
                m.seconds, millions, output, m.memory_per_triangle);
  } else {
    std::printf("  %-14s %10zu bytes %9.2f ms %8.2f Mtriangles/s %8.1f MB/s", codec, m.bytes, m.seconds * 1e3,
                millions, output);
    if (m.memory_per_triangle > 0) std::printf("  %.1f bytes of memory per triangle", m.memory_per_triangle);
    std::printf("\n");
  }
}

}  // namespace

int main(int argc, char** argv) {
  // Freed memory stays with the process: page faults of the system are not what is measured.
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  mallopt(M_TRIM_THRESHOLD, 2000000000);
  bool csv = false;
  int runs = 7;
  try {
    std::vector<std::string> files;
    for (int i = 1; i < argc; ++i) {
      const std::string argument = argv[i];
      if (argument == "--csv") {
        csv = true;
      } else if (argument == "--runs" && i + 1 < argc) {
        runs = std::max(1, std::atoi(argv[++i]));
      } else {
        files.push_back(argument);
      }
    }
    if (files.empty())
      throw ToolError(ToolExit::kUsage, "usage: nmc-bench-decode [--csv] [--runs N] FILE.nmc...");
    if (csv)
      std::printf("file,codec,triangles,bytes,seconds,million_triangles_per_s,mb_per_s,bytes_per_triangle\n");
    for (const std::string& file : files) {
      const std::vector<std::uint8_t> stream = read_file(file);
      Mesh mesh;
      nmc_layer layer{};
      nmc_info info{};
      const Measurement own = measure_nmc(stream, runs, mesh, layer, info);
      const std::size_t triangle_count = mesh.indices.size() / 3;
      const std::string name = file.substr(file.rfind('/') + 1);
      // Rounding to a step s has a root mean square of s / sqrt(12) along the normal.
      const double error = layer.has_error ? layer.rms_error : info.diagonal * 1e-4;
      double size = 0;
      for (int k = 0; k < 3; ++k) size = std::max(size, info.box_max[k] - info.box_min[k]);
      const int bits =
          std::clamp(static_cast<int>(std::ceil(std::log2(size / (error * std::sqrt(12.0))))), 10, 16);
      if (!csv) std::printf("%s: %zu triangles, peers at %d bits\n", name.c_str(), triangle_count, bits);
      print(csv, name, "nmc", triangle_count, own);
      print(csv, name, "draco -cl 7", triangle_count, measure_draco(mesh, bits, 3, runs));
      print(csv, name, "draco -cl 10", triangle_count, measure_draco(mesh, bits, 0, runs));
      print(csv, name, "meshoptimizer", triangle_count, measure_meshopt(mesh, bits, runs));
    }
  } catch (const ToolError& error) {
    std::fprintf(stderr, "nmc-bench-decode: %s\n", error.what());
    return static_cast<int>(error.code());
  }
  return 0;
}
