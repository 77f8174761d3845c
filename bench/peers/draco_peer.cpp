// SPDX-License-Identifier: Apache-2.0
#include <draco/compression/decode.h>
#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>

#include <array>

#include "bench/peers/peer.h"
#include "encoder/core/error.h"

namespace nmc::bench {
namespace {

// Centred first: Draco keeps positions as floats, and a user with large coordinates would do the same.
void to_draco(const TriangleMesh& mesh, const Vec3& center, draco::Mesh& converted) {
  converted.SetNumFaces(mesh.triangle_count());
  for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
    draco::Mesh::Face face;
    for (std::size_t i = 0; i < 3; ++i) face[i] = mesh.triangles[t][i];
    converted.SetFace(draco::FaceIndex(t), face);
  }
  const auto vertex_count = static_cast<std::uint32_t>(mesh.vertex_count());
  converted.set_num_points(vertex_count);
  draco::GeometryAttribute description;
  description.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false,
                   3 * sizeof(float), 0);
  const int id = converted.AddAttribute(description, true, vertex_count);
  for (std::uint32_t v = 0; v < vertex_count; ++v) {
    const Vec3 p = mesh.positions[v] - center;
    const std::array<float, 3> values = {static_cast<float>(p.x), static_cast<float>(p.y),
                                         static_cast<float>(p.z)};
    converted.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v), values.data());
  }
}

TriangleMesh from_draco(const draco::Mesh& mesh, const Vec3& center) {
  TriangleMesh converted;
  const draco::PointAttribute* positions = mesh.GetNamedAttribute(draco::GeometryAttribute::POSITION);
  for (std::uint32_t v = 0; v < mesh.num_points(); ++v) {
    std::array<float, 3> values{};
    positions->GetMappedValue(draco::PointIndex(v), values.data());
    converted.positions.push_back(center + Vec3{values[0], values[1], values[2]});
  }
  for (std::uint32_t t = 0; t < mesh.num_faces(); ++t) {
    const draco::Mesh::Face& face = mesh.face(draco::FaceIndex(t));
    converted.triangles.push_back({face[0].value(), face[1].value(), face[2].value()});
  }
  return converted;
}

}  // namespace

CodecResult code_with_draco(const TriangleMesh& mesh, int position_bits) {
  const Vec3 center = bounding_box(mesh).center();
  draco::Mesh input;
  to_draco(mesh, center, input);
  CodecResult result;

  const Stopwatch encode_watch;
  draco::Encoder encoder;
  encoder.SetSpeedOptions(0, 0);
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, position_bits);
  draco::EncoderBuffer buffer;
  const draco::Status encoded = encoder.EncodeMeshToBuffer(input, &buffer);
  if (!encoded.ok()) throw Error(ExitCode::kUnsupported, "Draco: " + encoded.error_msg_string());
  result.encode_seconds = encode_watch.seconds();
  result.bytes = buffer.size();

  const Stopwatch decode_watch;
  draco::DecoderBuffer compressed;
  compressed.Init(buffer.data(), buffer.size());
  draco::Decoder decoder;
  const auto decoded = decoder.DecodeMeshFromBuffer(&compressed);
  if (!decoded.ok()) throw Error(ExitCode::kUnsupported, "Draco: " + decoded.status().error_msg_string());
  result.decode_seconds = decode_watch.seconds();
  result.decoded = from_draco(*decoded.value(), center);
  return result;
}

}  // namespace nmc::bench
