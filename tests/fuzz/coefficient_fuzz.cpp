// SPDX-License-Identifier: Apache-2.0
// The coefficients alone: the first byte chooses a small base mesh, the second the quality layers; the rest
// is the payload of one level after the other. Values stay in range, and coding what was decoded gives the
// same values.
#include "libnmc/common/coded_mesh.h"
#include "libnmc/decode/range_decoder.h"
#include "tests/fuzz/stream_fuzz.h"
#include "tests/support/random_base_mesh.h"

namespace {

using namespace nmc;

const test::SmallMesh& base_mesh(std::size_t number) {
  static const std::vector<test::SmallMesh> meshes = [] {
    std::vector<test::SmallMesh> list = {test::tetrahedron(), test::grid(3, 3, true), test::grid(2, 3, false),
                                         test::bipyramid(9), test::fan(1, false)};
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      test::RandomIntegers random(seed);
      list.push_back(test::random_base_mesh(random, 20));
    }
    return list;
  }();
  return meshes[number % meshes.size()];
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const test::SmallMesh& base = base_mesh(data[0]);
  Header header;
  header.base_vertex_count = base.vertex_count;
  header.base_face_count = static_cast<std::uint32_t>(base.faces.size());
  header.level_count = 2;
  header.quality_layer_count = 1 + data[1] % 3;
  for (int k = 1; k < header.quality_layer_count; ++k)
    header.layer_ratio[k] = static_cast<std::uint8_t>(1 + data[1] / 3 % 4);
  for (int l = 0; l < 2; ++l) {
    header.step_code[l] = 64;
    header.tension_code[l] = 4;
  }
  StreamWriter writer(header);
  Array<std::uint32_t> order;
  const std::vector<std::int32_t> corners(std::size_t{3} * base.vertex_count, 5);
  fuzz::require(writer.add_base(base.faces[0].data(), corners.data(), nullptr, order).ok());
  // A decoder's state after the same base mesh.
  CodedMesh mesh(nullptr, &header);
  ByteReader chunk(writer.chunks().data() + 1, writer.chunks().size() - 1);
  const auto payload_size = static_cast<std::size_t>(chunk.read_varint());
  RangeDecoder base_coder(chunk.current(), payload_size);
  fuzz::require(mesh.code_base(base_coder, nullptr, nullptr, nullptr, nullptr, nullptr).ok());

  RangeDecoder coder(data + 2, size - 2);
  for (int layer = 0; layer < header.quality_layer_count; ++layer) {
    for (int level = 0; level < 2; ++level) {
      if (!mesh.code_level(coder, layer, level, nullptr).ok()) return 0;
      const LevelCoefficients& decoded = mesh.coefficients(level);
      for (const std::int32_t c : decoded.normal)
        fuzz::require(c >= -kMaximumMagnitude && c <= kMaximumMagnitude);
      std::uint32_t next = 0;
      for (const TangentialCoefficient& t : decoded.tangential) {
        fuzz::require(t.edge >= next && t.edge < mesh.topology(level).edge_count &&
                      (t.along != 0 || t.across != 0));
        next = t.edge + 1;
      }
      const LevelCoefficients* target = &decoded;
      fuzz::require(writer.add_levels(layer, level, 1, &target).ok());
      fuzz::require(writer.mesh().state_hash() == mesh.state_hash());
    }
    if (layer + 1 < header.quality_layer_count) {
      // Both sides go on from what they hold; positions of every level stay finite.
      fuzz::require(mesh.update_positions(2).ok());
      for (std::uint32_t v = 0; v < mesh.topology(1).vertex_count + mesh.topology(1).edge_count; ++v)
        fuzz::require(is_finite(mesh.positions()[v]));
    }
  }
  return 0;
}
