// SPDX-License-Identifier: Apache-2.0
// Attributes from the encoder's integers to what a client of nmc.h reads.
#include <catch2/catch.hpp>
#include <vector>

#include "libnmc/common/coded_attribute.h"
#include "libnmc/encode/range_encoder.h"
#include "tests/support/header_bytes.h"
#include "tests/support/stream_decoding.h"
#include "tests/support/stream_generator.h"

using namespace nmc;
using namespace nmc::test;

namespace {

struct ColoredStream {
  Header header;
  std::vector<std::uint8_t> bytes;
  std::vector<std::uint8_t> rgb;  // of the finest level, in the order of the stream
};

/// A torus of two levels whose vertices have colours by chance, coded with steps of 1.
ColoredStream lossless_stream(bool base_colors_only = false) {
  ColoredStream result;
  Header& header = result.header;
  const SmallMesh base = grid(4, 4, true);
  header.base_vertex_count = base.vertex_count;
  header.base_face_count = static_cast<std::uint32_t>(base.faces.size());
  header.level_count = 2;
  header.step_code[0] = header.step_code[1] = 64;
  header.tension_code[0] = header.tension_code[1] = 4;
  header.attribute_count = 1;
  AttributeDescriptor& descriptor = header.attributes[0];
  descriptor.is_decorrelated = true;
  descriptor.finest_level = base_colors_only ? 0 : 2;
  descriptor.levels[1].opposite_share = 2;
  descriptor.levels[2].near_share = 9;

  StreamWriter writer(header);
  std::vector<std::int32_t> coordinates(3 * base.vertex_count);
  RandomIntegers random(7);
  for (std::int32_t& x : coordinates) x = static_cast<std::int32_t>(random.below(1000));
  Array<std::uint32_t> old_index;
  require(writer.add_base(base.faces[0].data(), coordinates.data(), nullptr, old_index));
  require(writer.mesh().ensure_topology(2, true));
  result.rgb.resize(3 * writer.mesh().topology(2).vertex_count);
  for (std::uint8_t& value : result.rgb) value = static_cast<std::uint8_t>(random.below(256));

  CodedAttribute attribute;
  BitCounter counter;
  for (int l = 0; l <= descriptor.finest_level; ++l) {
    std::vector<std::int32_t> corrections;
    const auto exact = [&](std::uint32_t vertex, const std::int32_t* prediction, const AttributeContexts&,
                           AttributeModel&, std::int32_t* chosen) {
      const std::int32_t rgb[3] = {result.rgb[3 * vertex], result.rgb[3 * vertex + 1],
                                   result.rgb[3 * vertex + 2]};
      std::int32_t coded[3];
      luma_chroma_from_rgb(rgb, coded);
      for (int c = 0; c < 3; ++c) corrections.push_back(chosen[c] = coded[c] - prediction[c]);
    };
    require(l == 0 ? attribute.code_base(counter, descriptor, nullptr, writer.mesh().topology(0), exact)
                   : attribute.code_level(counter, descriptor, l, writer.mesh().topology(l - 1), exact));
    const std::int32_t* const pointer = corrections.data();
    require(writer.add_attribute(0, l, 1, &pointer));
    require(writer.end_layer(l, 100, 100));
  }
  Array<std::uint8_t> bytes;
  require(writer.write_stream(bytes));
  result.bytes.assign(bytes.begin(), bytes.end());
  return result;
}

/// A decoder after the first `size` bytes.
struct Decoded {
  explicit Decoded(const std::vector<std::uint8_t>& bytes, std::size_t size = ~std::size_t{0}) {
    nmc_decoder_create(&decoder, nullptr, nullptr);
    decoding = decode_with(decoder, {bytes.data(), std::min(size, bytes.size())});
  }
  ~Decoded() { nmc_decoder_destroy(&decoder); }
  nmc_decoder* decoder = nullptr;
  Decoding decoding;
};

/// The stream's header, the first chunk, which is the base mesh, and `chunks`, all in one row.
Bytes with_chunks(const ColoredStream& stream, const std::vector<Bytes>& chunks) {
  Header header;
  Array<std::uint8_t> head;
  std::size_t header_size = stream.bytes.size();
  std::size_t first_row = 0;
  header.base_vertex_count = stream.header.base_vertex_count;
  header.base_face_count = stream.header.base_face_count;
  header.level_count = stream.header.level_count;
  for (int l = 0; l < header.level_count; ++l) {
    header.step_code[l] = 64;
    header.tension_code[l] = 4;
  }
  header.attribute_count = 1;
  header.attributes[0] = stream.header.attributes[0];
  for (const LayerEntry& row : stream.header.layers) header_size -= static_cast<std::size_t>(row.size);
  const std::size_t base_size =
      stream.bytes[header_size + 1] + std::size_t{6};  // a size below 128 takes one byte
  REQUIRE(stream.bytes[header_size + 1] < 128);
  first_row = base_size;
  for (const Bytes& c : chunks) first_row += c.size();
  REQUIRE(header.layers.push_back({first_row, 0, 100, 100, 0}));
  REQUIRE(write_header(header, head).ok());
  Bytes result(head.begin(), head.end());
  const auto begin = stream.bytes.begin() + static_cast<std::ptrdiff_t>(header_size);
  result.insert(result.end(), begin, begin + static_cast<std::ptrdiff_t>(base_size));
  for (const Bytes& c : chunks) result.insert(result.end(), c.begin(), c.end());
  return result;
}

}  // namespace

TEST_CASE("luma and chroma: every colour of a grid comes back, and values stay within their bounds",
          "[attribute]") {
  const AttributeDescriptor descriptor = [] {
    AttributeDescriptor d;
    d.is_decorrelated = true;
    return d;
  }();
  for (std::int32_t r = 0; r < 256; r += 5)
    for (std::int32_t g = 0; g < 256; g += 3)
      for (std::int32_t b = 0; b < 256; b += 5) {
        const std::int32_t rgb[3] = {r, g, b};
        std::int32_t coded[3], back[3];
        luma_chroma_from_rgb(rgb, coded);
        rgb_from_luma_chroma(coded, 255, back);
        INFO(r << " " << g << " " << b << " became " << back[0] << " " << back[1] << " " << back[2]);
        REQUIRE(std::equal(rgb, rgb + 3, back));
        for (int c = 0; c < 3; ++c) {
          REQUIRE(coded[c] >= descriptor.coded_minimum(c));
          REQUIRE(coded[c] <= 255);
        }
      }
}

TEST_CASE("attributes: the decoder holds the encoder's values after every row", "[attribute]") {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    StreamRecipe recipe = random_recipe(seed);
    recipe.attribute_count = 1 + static_cast<int>(seed % 4);
    const GeneratedStream stream = generate(recipe);
    const Decoding decoding = decode(stream.bytes);
    INFO(stream.name << ": " << decoding);
    REQUIRE(decoding.status == NMC_OK);
    REQUIRE(decoding.layers.size() == stream.layers.size());
    for (std::size_t i = 0; i < stream.layers.size(); ++i) {
      INFO("row " << i);
      CHECK(decoding.layers[i].attribute_hashes == stream.layers[i].attribute_hashes);
      CHECK(decoding.layers[i].state_hash == stream.layers[i].state_hash);
    }
  }
}

TEST_CASE("attributes: steps of 1 keep every colour, through each layout that nmc.h offers", "[attribute]") {
  const ColoredStream stream = lossless_stream();
  const Decoded decoded(stream.bytes);
  REQUIRE(decoded.decoding.status == NMC_OK);
  const auto count = static_cast<std::uint32_t>(stream.rgb.size() / 3);
  std::vector<std::uint8_t> rgb(stream.rgb.size()), rgba(4 * count, 7), wide(12 * count, 9);
  REQUIRE(nmc_decoder_read_colors(decoded.decoder, 2, rgb.data(), 3, 3, count) == NMC_OK);
  CHECK(rgb == stream.rgb);
  REQUIRE(nmc_decoder_read_colors(decoded.decoder, 2, rgba.data(), 4, 4, count) == NMC_OK);
  REQUIRE(nmc_decoder_read_colors(decoded.decoder, 2, wide.data(), 3, 12, count) == NMC_OK);
  std::vector<std::uint16_t> values(3 * count);
  REQUIRE(nmc_decoder_read_attribute(decoded.decoder, 0, 2, values.data(), 6, count) == NMC_OK);
  bool equal = true;
  for (std::size_t v = 0; v < count; ++v) {
    equal &= rgba[4 * v + 3] == 255 && wide[12 * v + 3] == 9;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint8_t expected = stream.rgb[3 * v + c];
      equal &= rgba[4 * v + c] == expected && wide[12 * v + c] == expected && values[3 * v + c] == expected;
    }
  }
  CHECK(equal);
  nmc_info info{};
  nmc_attribute attribute{};
  REQUIRE(nmc_decoder_info(decoded.decoder, &info) == NMC_OK);
  CHECK(info.has_colors == 1);
  REQUIRE(nmc_decoder_attribute(decoded.decoder, 0, &attribute) == NMC_OK);
  CHECK(attribute.kind == NMC_ATTRIBUTE_COLOR);
  CHECK(attribute.levels_complete == 3);
  CHECK(attribute.byte_count > 3 * count);  // noise does not compress
  CHECK(nmc_decoder_attribute(decoded.decoder, 1, &attribute) == NMC_ERR_ARGUMENT);
  CHECK(nmc_decoder_read_colors(decoded.decoder, 2, rgb.data(), 2, 3, count) == NMC_ERR_ARGUMENT);
  CHECK(nmc_decoder_read_colors(decoded.decoder, 2, rgb.data(), 3, 2, count) == NMC_ERR_ARGUMENT);
  CHECK(nmc_decoder_read_colors(decoded.decoder, 2, rgb.data(), 3, 3, count - 1) == NMC_ERR_ARGUMENT);
  CHECK(nmc_decoder_read_colors(decoded.decoder, 2, nullptr, 3, 3, count) == NMC_ERR_ARGUMENT);
}

TEST_CASE("attributes: a prefix shows finer levels in the means of the coarser ones", "[attribute]") {
  const ColoredStream stream = lossless_stream(true);
  const Decoded decoded(stream.bytes);
  REQUIRE(decoded.decoding.status == NMC_OK);
  const std::uint32_t base_count = stream.header.base_vertex_count;
  std::uint32_t count = 0, faces = 0;
  REQUIRE(nmc_decoder_mesh_size(decoded.decoder, 1, &count, &faces) == NMC_OK);
  std::vector<std::uint16_t> values(3 * count);
  std::vector<std::uint32_t> indices(3 * faces);
  REQUIRE(nmc_decoder_read_attribute(decoded.decoder, 0, 1, values.data(), 6, count) == NMC_OK);
  REQUIRE(nmc_decoder_read_indices(decoded.decoder, 1, indices.data(), indices.size()) == NMC_OK);
  const auto coded = [&](std::uint32_t v) {
    const std::int32_t rgb[3] = {values[3 * v], values[3 * v + 1], values[3 * v + 2]};
    std::int32_t result[3];
    luma_chroma_from_rgb(rgb, result);
    return std::vector<std::int32_t>(result, result + 3);
  };
  // Face 4f is (v0, m2, m1) and 4f + 1 is (m2, v1, m0): m2 lies between their first and second corners.
  for (std::uint32_t f = 0; f < faces / 4; ++f) {
    const std::uint32_t a = indices[12 * f], b = indices[12 * f + 4], m = indices[12 * f + 1];
    REQUIRE(a < base_count);
    REQUIRE(m >= base_count);
    std::int32_t mean[3], rgb[3];
    for (int c = 0; c < 3; ++c)
      mean[c] = (coded(a)[static_cast<std::size_t>(c)] + coded(b)[static_cast<std::size_t>(c)] + 1) >> 1;
    rgb_from_luma_chroma(mean, 255, rgb);
    INFO("face " << f);
    for (std::size_t c = 0; c < 3; ++c) CHECK(values[3 * m + c] == rgb[c]);
  }
}

TEST_CASE("attributes: chunks out of order, too short or not announced are refused",
          "[attribute][malformed]") {
  const ColoredStream stream = lossless_stream();
  const Bytes noise(40, 0x5a);
  const auto attribute = [&](std::uint8_t index, std::uint8_t first, std::uint8_t count) {
    Bytes payload = {index, first, count};
    payload.insert(payload.end(), noise.begin(), noise.end());
    return chunk(4, payload);
  };
  struct Case {
    const char* name;
    std::vector<Bytes> chunks;
    nmc_status status;
    const char* section;
  };
  const Case cases[] = {
      {"nothing after the base", {}, NMC_OK, ""},
      {"two bytes", {chunk(4, {0, 0})}, NMC_ERR_CORRUPT, "10.3"},
      {"no level", {attribute(0, 0, 0)}, NMC_ERR_CORRUPT, "10.3"},
      {"more levels than the stream has", {attribute(0, 0, 4)}, NMC_ERR_CORRUPT, "10.3"},
      {"an attribute that is not there", {attribute(1, 0, 1)}, NMC_ERR_CORRUPT, "10.3"},
      {"level 1 first", {attribute(0, 1, 1)}, NMC_ERR_CORRUPT, "10.3"},
      {"level 0 twice", {attribute(0, 0, 1), attribute(0, 0, 1)}, NMC_ERR_CORRUPT, ""},
      {"nothing to decode", {chunk(4, {0, 0, 3})}, NMC_ERR_CORRUPT, "5.1"},
  };
  for (const Case& c : cases) {
    const Decoding decoding = decode(with_chunks(stream, c.chunks));
    INFO(c.name << ": " << decoding);
    CHECK(decoding.status == c.status);
    if (*c.section) CHECK(std::string(decoding.error.spec_section) == c.section);
    CHECK(decoding.layers.size() == (c.status == NMC_OK ? 1 : 0));
  }
}

TEST_CASE("attributes: a level larger than its bytes may describe is refused before it is allocated",
          "[attribute][malformed]") {
  ColoredStream stream = lossless_stream();
  stream.header.level_count = 9;
  stream.header.attributes[0].finest_level = 9;
  const Decoding decoding = decode(with_chunks(stream, {chunk(4, {0, 0, 10, 0, 0, 0, 0})}));
  INFO(decoding);
  CHECK(decoding.status < 0);
  CHECK(decoding.peak_memory < 4'000'000);
}
