// SPDX-License-Identifier: Apache-2.0
#include "bench/train/integers.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "encoder/core/error.h"
#include "libnmc/decode/stream_decoder.h"
#include "libnmc/encode/base_face_lookup.h"
#include "libnmc/encode/range_encoder.h"

namespace nmc::bench {

namespace {

void check(const Status& status, const std::string& name) {
  if (!status.ok())
    throw Error(ExitCode::kInvalidInput, name + ": " + (status.message() ? status.message() : "failed"));
}

std::vector<std::uint8_t> bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error(ExitCode::kInputOutput, path + ": cannot be read");
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

template <class T>
void assign(const std::vector<T>& from, Array<T>& to) {
  if (!to.resize(from.size())) throw Error(ExitCode::kLimit, "out of memory");
  std::copy(from.begin(), from.end(), to.data());
}

class WordReader {
 public:
  explicit WordReader(const std::string& path) : path_(path), bytes_(bytes_of(path)) {}
  std::uint32_t u32() {
    if (bytes_.size() - at_ < 4) throw Error(ExitCode::kInvalidInput, path_ + ": ends early");
    std::uint32_t word = 0;
    for (int i = 0; i < 4; ++i) word |= std::uint32_t{bytes_[at_++]} << (8 * i);
    return word;
  }
  std::int32_t i32() { return static_cast<std::int32_t>(u32()); }
  /// A count of items of `words` words each, which the file must still hold.
  std::size_t count(std::size_t words) {
    const std::size_t n = u32();
    if (n > (bytes_.size() - at_) / (4 * words)) throw Error(ExitCode::kInvalidInput, path_ + ": ends early");
    return n;
  }

 private:
  std::string path_;
  std::vector<std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

}  // namespace

Integers integers_of_stream(const std::string& path) {
  const std::vector<std::uint8_t> bytes = bytes_of(path);
  StreamDecoder decoder(nullptr, {});
  check(decoder.feed(bytes.data(), bytes.size()), path);
  for (DecoderEvent event = DecoderEvent::kHeader; event != DecoderEvent::kEnd;) {
    check(decoder.next(event), path);
    if (event == DecoderEvent::kNeedMoreInput) throw Error(ExitCode::kInvalidInput, path + ": ends early");
  }
  const Header& header = decoder.header();
  if (header.quality_layer_count != 1 || header.has_creases)
    throw Error(ExitCode::kUnsupported, path + ": has creases or several quality layers");
  Integers integers;
  const CodedMesh& mesh = decoder.mesh();
  integers.vertex_count = mesh.base().vertex_count;
  integers.faces.assign(mesh.base().face_vertices.begin(), mesh.base().face_vertices.end());
  integers.coordinates.assign(mesh.base().coordinates.begin(), mesh.base().coordinates.end());
  for (int l = 0; l < header.level_count && mesh.layer_of_level(l) >= 0; ++l) {
    const LevelCoefficients& level = mesh.coefficients(l);
    integers.levels.push_back(
        {{level.normal.begin(), level.normal.end()}, {level.tangential.begin(), level.tangential.end()}});
  }
  return integers;
}

void write_integers(const Integers& integers, const std::string& path) {
  std::ofstream file(path, std::ios::binary);
  const auto put = [&](std::uint32_t word) {
    for (int i = 0; i < 4; ++i) file.put(static_cast<char>((word >> (8 * i)) & 255));
  };
  const auto put_signed = [&](std::int32_t value) { put(static_cast<std::uint32_t>(value)); };
  put(integers.vertex_count);
  put(static_cast<std::uint32_t>(integers.faces.size() / 3));
  for (const std::uint32_t v : integers.faces) put(v);
  for (const std::int32_t x : integers.coordinates) put_signed(x);
  put(0);  // creases
  put(static_cast<std::uint32_t>(integers.levels.size()));
  for (const Integers::Level& level : integers.levels) {
    put(static_cast<std::uint32_t>(level.normal.size()));
    for (const std::int32_t c : level.normal) put_signed(c);
    put(static_cast<std::uint32_t>(level.tangential.size()));
    for (const TangentialCoefficient& t : level.tangential) {
      put(t.edge);
      put_signed(t.along);
      put_signed(t.across);
    }
  }
  if (!file) throw Error(ExitCode::kInputOutput, path + ": cannot be written");
}

Integers read_integers(const std::string& path) {
  WordReader file(path);
  Integers integers;
  integers.name = std::filesystem::path(path).stem().string();
  integers.vertex_count = file.u32();
  integers.faces.resize(3 * file.count(3));
  for (std::uint32_t& v : integers.faces) v = file.u32();
  integers.coordinates.resize(std::size_t{3} * integers.vertex_count);
  for (std::int32_t& x : integers.coordinates) x = file.i32();
  if (file.u32() != 0) throw Error(ExitCode::kUnsupported, path + ": has creases");
  integers.levels.resize(file.count(2));
  for (Integers::Level& level : integers.levels) {
    level.normal.resize(file.count(1));
    for (std::int32_t& c : level.normal) c = file.i32();
    level.tangential.resize(file.count(3));
    for (TangentialCoefficient& t : level.tangential) {
      t.edge = file.u32();
      t.along = file.i32();
      t.across = file.i32();
    }
  }
  return integers;
}

CodableMesh::CodableMesh(const Integers& integers) : integers_(integers) {
  base_.vertex_count = integers.vertex_count;
  base_.face_count = static_cast<std::uint32_t>(integers.faces.size() / 3);
  assign(integers.faces, base_.face_vertices);
  assign(integers.coordinates, base_.coordinates);
  topology_.resize(std::max<std::size_t>(integers.levels.size(), 1));
  check(build_base_topology(base_.face_vertices.data(), base_.face_count, base_.vertex_count, nullptr,
                            topology_[0]),
        name());
  for (std::size_t l = 1; l < topology_.size(); ++l)
    check(subdivide(topology_[l - 1], false, topology_[l]), name());
  double least = 0;
  for (std::uint32_t share = 0; share < 8; ++share) {
    BaseMeshModel model;
    model.set_parallelogram_share(share);
    BitCounter bits;
    check(model.code_coordinates(bits, nullptr, topology_[0], base_), name());
    if (share == 0 || bits.bits() < least) {
      least = bits.bits();
      parallelogram_share_ = share;
    }
  }
}

CodableMesh::Bits CodableMesh::code(BaseMeshModel& base_model, CoefficientModel& coefficient_model) const {
  // What was decoded is in the stream's order: coding it again numbers the vertices as they are.
  BaseMesh copy;
  copy.vertex_count = base_.vertex_count;
  copy.face_count = base_.face_count;
  BaseFaceLookup lookup(nullptr);
  check(lookup.build(integers_.faces.data(), copy.face_count, copy.vertex_count, nullptr), name());
  Array<std::uint32_t> order;
  BitCounter base_bits, coefficient_bits;
  check(base_model.code_connectivity(base_bits, nullptr, &lookup, lookup.seeds(), copy, order), name());
  assign(integers_.coordinates, copy.coordinates);
  base_model.set_parallelogram_share(parallelogram_share_);
  check(base_model.code_coordinates(base_bits, nullptr, topology_[0], copy), name());

  std::vector<std::int32_t> inserted(integers_.vertex_count, 0);
  for (std::size_t l = 0; l < integers_.levels.size(); ++l) {
    LevelCoefficients level;
    assign(integers_.levels[l].normal, level.normal);
    assign(integers_.levels[l].tangential, level.tangential);
    check(coefficient_model.code_level(coefficient_bits, nullptr, static_cast<int>(l),
                                       l > 0 ? &topology_[l - 1] : nullptr, topology_[l], inserted.data(),
                                       nullptr, level),
          name());
    inserted.insert(inserted.end(), integers_.levels[l].normal.begin(), integers_.levels[l].normal.end());
  }
  return {base_bits.bits(), coefficient_bits.bits()};
}

}  // namespace nmc::bench
