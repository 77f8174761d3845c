// SPDX-License-Identifier: Apache-2.0
// Writes the table of conformance vectors: for each a folder with stream.nmc and expected.json, and
// index.json with their names in order. What valid streams must decode to comes from the encoder's own state,
// not from a decoder.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/header_bytes.h"
#include "tests/support/stream_decoding.h"
#include "tests/support/stream_generator.h"

using namespace nmc;
using namespace nmc::test;
using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

namespace {

std::string hash_text(std::uint64_t hash) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

class VectorWriter {
 public:
  explicit VectorWriter(fs::path root) : root_(std::move(root)) {}

  void add_valid(const std::string& id, const std::string& section, const std::string& what,
                 const GeneratedStream& stream) {
    Json layers = Json::array();
    for (const ExpectedLayer& layer : stream.layers) layers.push_back(layer_of(layer));
    write(id, {{"id", id}, {"section", section}, {"what", what}, {"status", "NMC_OK"}, {"layers", layers}},
          stream.bytes);
  }
  void add_prefix(const std::string& id, const std::string& what, const GeneratedStream& stream,
                  std::size_t size) {
    Json layers = Json::array();
    for (const ExpectedLayer& layer : stream.layers) {
      if (layer.end_offset <= size) layers.push_back(layer_of(layer));
    }
    write(id,
          {{"id", id},
           {"section", "3.2"},
           {"what", what},
           {"status", "NMC_ERR_TRUNCATED"},
           {"errorOffset", size},
           {"errorSection", "3.2"},
           {"layers", layers}},
          {stream.bytes.begin(), stream.bytes.begin() + static_cast<std::ptrdiff_t>(size)});
  }
  /// `status` is what the author of the vector expects; offset, section and layers are written down from the
  /// decoder, which must agree about the status.
  void add_broken(const std::string& id, const std::string& what, nmc_status status, const Bytes& bytes,
                  const Json& limits = Json()) {
    nmc_limits used = nmc_default_limits();
    if (limits.contains("maxVertices")) used.max_vertices = limits["maxVertices"];
    if (limits.contains("maxMemory")) used.max_memory = limits["maxMemory"];
    if (limits.contains("maxLevels")) used.max_levels = limits["maxLevels"];
    if (limits.contains("maxBaseVertices")) used.max_base_vertices = limits["maxBaseVertices"];
    const Decoding decoding = decode(bytes, {~std::size_t{0}}, &used);
    if (decoding.status != status) {
      std::fprintf(stderr, "%s: expected %s, the decoder says %s: %s\n", id.c_str(), nmc_status_name(status),
                   nmc_status_name(decoding.status), decoding.error.message);
      has_failed_ = true;
    }
    Json layers = Json::array();
    for (const DecodedLayer& layer : decoding.layers) {
      layers.push_back(with_attributes({{"level", layer.level},
                                        {"endByte", layer.end_offset},
                                        {"stateHash", hash_text(layer.state_hash)},
                                        {"positionHash", hash_text(layer.position_hash)}},
                                       layer));
    }
    Json expected = {{"id", id},
                     {"section", decoding.error.spec_section},
                     {"what", what},
                     {"status", nmc_status_name(status)},
                     {"errorOffset", decoding.error.byte_offset},
                     {"errorSection", decoding.error.spec_section}};
    if (!limits.is_null()) expected["limits"] = limits;
    expected["layers"] = layers;
    write(id, expected, bytes);
  }
  bool finish() {
    std::ofstream(root_ / "index.json") << ids_.dump(1) << "\n";
    std::printf("%zu vectors\n", ids_.size());
    return !has_failed_;
  }

 private:
  static Json layer_of(const ExpectedLayer& layer) {
    return with_attributes({{"level", layer.level},
                            {"endByte", layer.end_offset},
                            {"stateHash", hash_text(layer.state_hash)},
                            {"positionHash", hash_text(layer.position_hash)}},
                           layer);
  }
  /// Rows of streams without attributes have no member for them.
  template <class Layer>
  static Json with_attributes(Json row, const Layer& layer) {
    for (const std::uint64_t hash : layer.attribute_hashes) row["attributeHashes"].push_back(hash_text(hash));
    return row;
  }
  void write(const std::string& id, const Json& expected, const Bytes& bytes) {
    fs::create_directories(root_ / id);
    std::ofstream stream(root_ / id / "stream.nmc", std::ios::binary);
    stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    std::ofstream(root_ / id / "expected.json") << expected.dump(1) << "\n";
    ids_.push_back(id);
  }

  fs::path root_;
  Json ids_ = Json::array();
  bool has_failed_ = false;
};

StreamRecipe recipe_of(SmallMesh base, int level_count, std::uint64_t seed = 1) {
  StreamRecipe recipe;
  recipe.base = std::move(base);
  recipe.level_count = level_count;
  recipe.seed = seed;
  return recipe;
}

void add_valid_vectors(VectorWriter& writer) {
  const auto add = [&](const std::string& id, const std::string& section, const std::string& what,
                       const StreamRecipe& recipe) { writer.add_valid(id, section, what, generate(recipe)); };
  add("base-tetrahedron", "4.4", "the smallest closed mesh, no levels", recipe_of(tetrahedron(), 0));
  add("base-triangle", "4.4", "a single face", recipe_of(fan(1, false), 0));
  add("base-torus", "4.4", "genus 1", recipe_of(grid(4, 3, true), 0));
  add("base-disk", "4.4", "a boundary", recipe_of(fan(6, true), 0));
  add("base-sheet", "4.4", "a boundary with corners of one and two faces", recipe_of(grid(3, 3, false), 0));
  SmallMesh two = tetrahedron();
  append_component(two, grid(3, 3, true));
  append_component(two, fan(4, false));
  add("base-three-components", "4.4", "components of different topology", recipe_of(two, 1));
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    RandomIntegers random(seed);
    add("base-random-" + std::to_string(seed), "4.4", "random handles, holes and valences",
        recipe_of(random_base_mesh(random, 60), 1, seed));
  }
  StreamRecipe far = recipe_of(grid(3, 3, true), 1);
  far.largest_coordinate = kMaximumBaseCoordinate;
  add("base-extreme-coordinates", "4.6", "coordinates at both ends of their range", far);
  StreamRecipe zero = recipe_of(grid(4, 4, true), 1);
  zero.density = 0;
  add("level-1-all-zero", "5.3.2", "one empty level", zero);
  zero.level_count = 4;
  add("level-4-all-zero", "5.3.2", "empty levels; deep numbering", zero);
  add("level-5-tetrahedron", "5.2", "deep numbering", recipe_of(tetrahedron(), 5));
  for (const std::uint32_t valence : {3u, 4u, 5u, 7u, 12u, 40u}) {
    add("valence-" + std::to_string(valence), "6.2.3", "stencils of extraordinary vertices",
        recipe_of(bipyramid(valence), 2));
  }
  add("boundary-valence-1", "6.2.2", "a vertex with one face on a boundary", recipe_of(fan(1, false), 3));
  add("boundary-levels", "6.2.2", "curve stencils on a boundary", recipe_of(grid(2, 2, false), 3));
  StreamRecipe extremes = recipe_of(tetrahedron(), 2);
  extremes.density = 1;
  extremes.largest_coefficient = kMaximumMagnitude;
  add("coefficient-extremes", "5.3.3", "magnitudes at both ends, escape codes", extremes);
  extremes.quality_layer_count = 3;
  add("coefficient-extremes-layers", "5.3.3", "the same, corrected in later layers", extremes);
  StreamRecipe dense = recipe_of(grid(5, 5, true), 2);
  dense.density = 1;
  dense.largest_coefficient = 1000;
  add("coefficient-dense", "5.3.3", "no zeros to speak of", dense);
  StreamRecipe tangential = recipe_of(grid(4, 3, true), 2);
  tangential.tangential_density = 0.1;
  add("tangential-sparse", "5.3.4", "tangential coefficients", tangential);
  tangential.tangential_density = 0.9;
  add("tangential-dense", "5.3.4", "nearly every odd vertex is not normal", tangential);
  tangential.quality_layer_count = 4;
  add("tangential-layers", "5.3.4", "tangential coefficients that come, change and go", tangential);
  StreamRecipe creases = recipe_of(grid(4, 3, true), 2);
  creases.has_creases = true;
  add("creases", "4.5", "creases, corners and darts", creases);
  creases.tangential_density = 0.2;
  creases.base = grid(3, 3, false);
  add("creases-and-boundary", "4.5", "creases that meet a boundary", creases);
  StreamRecipe tensions = recipe_of(grid(4, 3, true), 3);
  tensions.has_tensions = true;
  add("tensions", "6.2.1", "a tension per level", tensions);
  for (int k = 2; k <= 4; ++k) {
    StreamRecipe layers = recipe_of(grid(4, 3, true), 2);
    layers.quality_layer_count = k;
    add("layers-" + std::to_string(k), "4.3", "quality layers", layers);
  }
  StreamRecipe grouped = recipe_of(grid(4, 3, true), 3);
  grouped.one_layer_per_chunk = false;
  add("levels-share-a-chunk", "5.3", "several levels in a chunk, several chunks in a row", grouped);
  StreamRecipe ancillary = recipe_of(tetrahedron(), 2);
  ancillary.has_ancillary_chunks = true;
  add("unknown-ancillary-chunk", "3.2", "chunks to be skipped", ancillary);
  for (std::uint64_t seed = 101; seed <= 108; ++seed) {
    add("random-" + std::to_string(seed), "5", "everything at once", random_recipe(seed));
  }
}

void add_header_vectors(VectorWriter& writer) {
  const auto add = [&](const std::string& id, const std::string& what, nmc_status status, auto change) {
    HeaderFields fields;
    change(fields);
    writer.add_broken(id, what, status, fields.bytes());
  };
  add("bad-magic", "a wrong signature", NMC_ERR_NOT_NMC, [](HeaderFields& h) { h.signature[1] = 'n'; });
  add("future-version", "version 2", NMC_ERR_VERSION, [](HeaderFields& h) { h.version = 2; });
  add("reserved-flag", "a reserved bit", NMC_ERR_CORRUPT, [](HeaderFields& h) { h.flags = 0x40; });
  add("unknown-units", "units 9", NMC_ERR_CORRUPT, [](HeaderFields& h) { h.frame = 9; });
  add("step-zero", "a grid step of zero", NMC_ERR_CORRUPT, [](HeaderFields& h) { h.step_mantissa = 0; });
  add("step-exponent", "a grid step out of range", NMC_ERR_CORRUPT,
      [](HeaderFields& h) { h.step_exponent = 200; });
  add("origin-too-far", "an origin out of range", NMC_ERR_CORRUPT,
      [](HeaderFields& h) { h.origin[1] = std::int64_t{1} << 60; });
  add("count-too-large", "2^31 base faces", NMC_ERR_CORRUPT,
      [](HeaderFields& h) { h.base_face_count = std::uint64_t{1} << 31; });
  add("count-overflow-32-bits", "2^32 + 4 base vertices", NMC_ERR_CORRUPT,
      [](HeaderFields& h) { h.base_vertex_count = (std::uint64_t{1} << 32) + 4; });
  add("too-many-levels", "15 levels", NMC_ERR_CORRUPT, [](HeaderFields& h) {
    h.level_count = 15;
    h.step_codes.assign(15, 64);
  });
  add("row-of-no-bytes", "an empty row of the table", NMC_ERR_CORRUPT,
      [](HeaderFields& h) { h.rows[0].size = 0; });
  add("row-level-too-fine", "a row of a level that is not there", NMC_ERR_CORRUPT,
      [](HeaderFields& h) { h.rows[0].level = 9; });
  add("header-bytes-too-many", "bytes behind the last field", NMC_ERR_CORRUPT,
      [](HeaderFields& h) { h.extra = {0}; });
  add("header-too-short", "a table that ends early", NMC_ERR_CORRUPT,
      [](HeaderFields& h) { h.row_count = 3; });
  Bytes wrong = HeaderFields().bytes();
  wrong.back() ^= 1;
  writer.add_broken("header-checksum", "the header's checksum", NMC_ERR_CHECKSUM, wrong);
  Bytes huge = {0x8e, 'N', 'M', 'C', 1};
  put_varint(huge, 1 << 20);
  writer.add_broken("header-too-large", "a header of a mebibyte", NMC_ERR_LIMIT, huge);
  writer.add_broken("empty", "no bytes", NMC_ERR_TRUNCATED, {});
}

/// A header for the base mesh chunk `payload`, and that chunk.
Bytes stream_with(HeaderFields header, const std::vector<Bytes>& chunks) {
  header.rows.assign(1, {0, 0, 1, 1, 0});
  for (const Bytes& c : chunks) header.rows[0].size += c.size();
  Bytes bytes = header.bytes();
  for (const Bytes& c : chunks) bytes.insert(bytes.end(), c.begin(), c.end());
  return bytes;
}

/// The base mesh chunk of a good stream of two levels.
Bytes tetrahedron_base_chunk() {
  Header header;
  header.base_vertex_count = header.base_face_count = 4;
  header.level_count = 2;
  header.step_code[0] = header.step_code[1] = 64;
  header.tangential_code = 64;
  StreamWriter writer(header);
  Array<std::uint32_t> order;
  const std::int32_t corners[12] = {0, 0, 0, 9, 0, 0, 0, 9, 0, 0, 0, 9};
  require(writer.add_base(tetrahedron().faces[0].data(), corners, nullptr, order));
  return Bytes(writer.chunks().begin(), writer.chunks().end());
}

void add_chunk_vectors(VectorWriter& writer) {
  const GeneratedStream good = generate(recipe_of(tetrahedron(), 2));
  const auto changed = [&](std::size_t position, std::uint8_t bits) {
    Bytes bytes = good.bytes;
    bytes[position] = static_cast<std::uint8_t>(bytes[position] ^ bits);
    return bytes;
  };
  for (const std::size_t size :
       {std::size_t{1}, std::size_t{4}, std::size_t{5}, std::size_t{20},
        static_cast<std::size_t>(good.layers[0].end_offset) - 1,
        static_cast<std::size_t>(good.layers[0].end_offset),
        static_cast<std::size_t>(good.layers[1].end_offset) + 2, good.bytes.size() - 1}) {
    writer.add_prefix("prefix-" + std::to_string(size), "a stream cut off", good, size);
  }
  writer.add_broken("checksum-base", "a bit of the base mesh chunk", NMC_ERR_CHECKSUM,
                    changed(good.layers[0].end_offset - 6, 4));
  writer.add_broken("checksum-level", "a bit of the last chunk", NMC_ERR_CHECKSUM,
                    changed(good.bytes.size() - 6, 4));
  writer.add_broken("checksum-field", "a bit of a checksum", NMC_ERR_CHECKSUM,
                    changed(good.bytes.size() - 1, 4));
  Bytes trailing = good.bytes;
  trailing.push_back(7);
  writer.add_broken("trailing-bytes", "a byte behind the last row", NMC_ERR_CORRUPT, trailing);

  HeaderFields header;
  writer.add_broken("unknown-critical-chunk", "type 0x20", NMC_ERR_FEATURE,
                    stream_with(header, {chunk(0x20, {1, 2})}));
  writer.add_broken("no-base-mesh", "a first row with an ancillary chunk only", NMC_ERR_CORRUPT,
                    stream_with(header, {chunk(0xc0, {1, 2})}));
  writer.add_broken("level-before-base", "coefficients first", NMC_ERR_CORRUPT,
                    stream_with(header, {chunk(3, {0, 0, 1, 9, 9})}));
  writer.add_broken("geometry-too-short", "two bytes of payload", NMC_ERR_CORRUPT,
                    stream_with(header, {chunk(3, {0, 0})}));
  Bytes spelling = {1, 0x85, 0x00, 1, 2, 3, 4, 5};
  writer.add_broken("varint-superfluous-byte", "a chunk size in two bytes where one would do",
                    NMC_ERR_CORRUPT, stream_with(header, {with_checksum(spelling)}));
  header.rows.assign(1, {3, 0, 1, 1, 0});
  Bytes beyond = header.bytes();
  const Bytes six = chunk(1, {1, 2, 3, 4, 5, 6});
  beyond.insert(beyond.end(), six.begin(), six.end());
  writer.add_broken("chunk-beyond-row", "a chunk larger than its row", NMC_ERR_CORRUPT, beyond);
  header = HeaderFields();
  header.base_vertex_count = 40;
  header.base_face_count = 60;
  writer.add_broken("base-overread", "a base mesh that needs more bytes than it has", NMC_ERR_CORRUPT,
                    stream_with(header, {chunk(1, {0x12})}));
  header.base_vertex_count = 100000;
  header.base_face_count = 200000;
  writer.add_broken("base-implausible", "200000 faces in four bytes", NMC_ERR_LIMIT,
                    stream_with(header, {chunk(1, {1, 2, 3, 4})}));

  // The base mesh chunk of a good stream, twice; levels out of order.
  const Bytes base = tetrahedron_base_chunk();
  header = HeaderFields();
  writer.add_broken("base-twice", "two base mesh chunks", NMC_ERR_CORRUPT, stream_with(header, {base, base}));
  writer.add_broken("level-skipped", "level 1 before level 0", NMC_ERR_CORRUPT,
                    stream_with(header, {base, chunk(3, {0, 1, 1, 0, 0})}));
  writer.add_broken("level-not-announced", "levels 0 to 2 of two", NMC_ERR_CORRUPT,
                    stream_with(header, {base, chunk(3, {0, 0, 3, 0, 0})}));
  writer.add_broken("layer-not-announced", "quality layer 1 of one", NMC_ERR_CORRUPT,
                    stream_with(header, {base, chunk(3, {1, 0, 1, 0, 0})}));
  writer.add_broken("no-levels-in-chunk", "a chunk of no levels", NMC_ERR_CORRUPT,
                    stream_with(header, {base, chunk(3, {0, 0, 0, 0, 0})}));
  writer.add_broken("correction-out-of-order", "a base correction of layer 1 of one", NMC_ERR_CORRUPT,
                    stream_with(header, {base, chunk(2, {1, 0, 0})}));
  for (int i = 0; i < 6; ++i) {
    RandomIntegers random(static_cast<std::uint64_t>(i) + 50);
    Bytes noise(40);
    for (std::uint8_t& byte : noise) byte = static_cast<std::uint8_t>(random.below(256));
    header.base_vertex_count = static_cast<std::uint64_t>(5 + i);
    header.base_face_count = static_cast<std::uint64_t>(2 * (3 + i));
    writer.add_broken("base-noise-" + std::to_string(i + 1), "a base mesh of random bits", NMC_ERR_CORRUPT,
                      stream_with(header, {chunk(1, noise)}));
  }

  const GeneratedStream larger = generate(recipe_of(grid(4, 3, true), 3));
  writer.add_broken("limit-vertices", "more vertices than the limit", NMC_ERR_LIMIT, larger.bytes,
                    {{"maxVertices", 200}});
  writer.add_broken("limit-levels", "more levels than the limit", NMC_ERR_LIMIT, larger.bytes,
                    {{"maxLevels", 2}});
  writer.add_broken("limit-base-vertices", "more base vertices than the limit", NMC_ERR_LIMIT, larger.bytes,
                    {{"maxBaseVertices", 11}});
}

void add_attribute_vectors(VectorWriter& writer) {
  const auto colored = [](SmallMesh base, int level_count, int attribute_count) {
    StreamRecipe recipe = recipe_of(std::move(base), level_count);
    recipe.attribute_count = attribute_count;
    return recipe;
  };
  const auto add = [&](const std::string& id, const std::string& section, const std::string& what,
                       const StreamRecipe& recipe) { writer.add_valid(id, section, what, generate(recipe)); };
  add("colours-base", "10.4", "colours of a base mesh alone", colored(grid(4, 3, true), 0, 1));
  add("colours-closed", "10.4", "colours of a closed mesh", colored(grid(4, 3, true), 3, 1));
  add("colours-boundary", "10.4", "colours beside a boundary", colored(fan(5, true), 3, 1));
  StreamRecipe dense = colored(bipyramid(7), 2, 1);
  dense.density = 1;
  add("colours-dense", "10.5.2", "no correction is zero", dense);
  add("attributes-four", "10.1", "four attributes of other shapes", colored(grid(3, 3, false), 2, 4));
  StreamRecipe grouped = colored(grid(4, 3, true), 3, 2);
  grouped.one_layer_per_chunk = false;
  grouped.quality_layer_count = 2;
  add("attributes-share-a-chunk", "10.3", "several levels in a chunk, quality layers", grouped);
  const GeneratedStream good = generate(colored(fan(5, true), 2, 1));
  for (std::size_t row = 0; row < 2; ++row) {
    writer.add_prefix("colours-prefix-" + std::to_string(row), "colours that are cut off", good,
                      static_cast<std::size_t>(good.layers[row].end_offset) + 9);
  }

  const auto broken_table = [&](const std::string& id, const std::string& what, std::size_t index,
                                std::uint8_t value) {
    HeaderFields header;
    header.flags = 2;
    header.attributes[index] = value;
    writer.add_broken("attribute-" + id, what, NMC_ERR_CORRUPT, header.bytes());
  };
  broken_table("none", "a table of no attributes", 0, 0);
  broken_table("five", "a table of five attributes", 0, 5);
  broken_table("kind", "kind 0", 1, 0);
  broken_table("components", "five components", 2, 5);
  broken_table("colour-of-two", "a colour of two components", 2, 2);
  broken_table("bits", "fifteen bits", 3, 15);
  broken_table("flag", "a reserved flag", 4, 2);
  broken_table("level", "values for level 3 of two", 5, 3);
  broken_table("step", "a step of zero", 7, 0);

  HeaderFields header;
  header.flags = 2;
  const Bytes base = tetrahedron_base_chunk();
  const auto values = [](std::uint8_t attribute, std::uint8_t first, std::uint8_t count) {
    Bytes payload = {attribute, first, count};
    for (int i = 0; i < 60; ++i) payload.push_back(static_cast<std::uint8_t>(37 * i));
    return chunk(4, payload);
  };
  const auto broken_chunk = [&](const std::string& id, const std::string& what,
                                const std::vector<Bytes>& chunks) {
    writer.add_broken("attribute-" + id, what, NMC_ERR_CORRUPT, stream_with(header, chunks));
  };
  broken_chunk("before-base", "values before the base mesh", {values(0, 0, 1), base});
  broken_chunk("too-short", "two bytes of payload", {base, chunk(4, {0, 0})});
  broken_chunk("no-levels", "a chunk of no levels", {base, values(0, 0, 0)});
  broken_chunk("level-too-fine", "levels 0 to 3 of two", {base, values(0, 0, 4)});
  broken_chunk("not-announced", "attribute 1 of one", {base, values(1, 0, 1)});
  broken_chunk("level-not-announced", "level 2 of one that has 0 and 1", {base, values(0, 0, 3)});
  broken_chunk("level-skipped", "level 1 before level 0", {base, values(0, 1, 1)});
  broken_chunk("level-twice", "level 0 twice", {base, values(0, 0, 1), values(0, 0, 1)});
  broken_chunk("overread", "values that need more bytes than they have", {base, chunk(4, {0, 0, 2})});
}

void add_region_vectors(VectorWriter& writer) {
  const auto divided = [](SmallMesh base, int level_count, int region_count, std::uint64_t seed = 1) {
    StreamRecipe recipe = recipe_of(std::move(base), level_count, seed);
    recipe.region_count = region_count;
    return recipe;
  };
  const auto add = [&](const std::string& id, const std::string& what, const StreamRecipe& recipe) {
    writer.add_valid(id, "5.4", what, generate(recipe));
  };
  add("regions-one", "a single region", divided(grid(4, 3, true), 2, 1));
  add("regions-closed", "regions of a torus", divided(grid(5, 4, true), 3, 4));
  add("regions-boundary", "regions of a sheet", divided(grid(4, 4, false), 3, 3));
  add("regions-each-face", "as many regions as faces", divided(tetrahedron(), 3, 4));
  SmallMesh two = tetrahedron();
  append_component(two, grid(3, 3, true));
  append_component(two, fan(4, false));
  add("regions-two-of-three-components", "a component without a seed belongs to region 0", divided(two, 2, 2));
  StreamRecipe creases = divided(grid(4, 3, true), 3, 3);
  creases.has_creases = true;
  creases.tangential_density = 0.3;
  add("regions-creases", "creases along and across borders, tangential coefficients", creases);
  StreamRecipe layers = divided(grid(4, 3, true), 3, 4, 5);
  layers.quality_layer_count = 3;
  layers.tangential_density = 0.2;
  add("regions-layers", "quality layers, regions that stay behind", layers);
  layers.largest_coefficient = kMaximumMagnitude;
  layers.density = 1;
  add("regions-layers-extremes", "values held while they are brought to finer steps", layers);
  layers.attribute_count = 1;
  layers.largest_coefficient = 6;
  add("regions-colours", "colours, which are not divided", layers);
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    RandomIntegers random(seed);
    StreamRecipe recipe = divided(random_base_mesh(random, 60), 3, 5, seed);
    add("regions-random-" + std::to_string(seed), "random bases", recipe);
  }
  const GeneratedStream good = generate(divided(grid(5, 4, true), 3, 4));
  for (const std::size_t back : {std::size_t{2}, std::size_t{1}}) {
    writer.add_prefix("regions-prefix-" + std::to_string(back), "regions that are cut off", good,
                      static_cast<std::size_t>(good.layers[good.layers.size() - 1 - back].end_offset) + 3);
  }

  const auto broken_header = [&](const std::string& id, const std::string& what, const Bytes& regions) {
    HeaderFields header;
    header.flags = 16;
    header.regions = regions;
    writer.add_broken("regions-" + id, what, NMC_ERR_CORRUPT, header.bytes());
  };
  broken_header("none", "no regions", {0, 1, 1});
  broken_header("too-many", "more regions than faces", {5, 1, 1});
  HeaderFields beyond_limit;
  beyond_limit.flags = 16;
  beyond_limit.base_vertex_count = beyond_limit.base_face_count = 100;
  beyond_limit.regions = {65, 1, 1};
  writer.add_broken("regions-beyond-limit", "65 regions of 100 faces", NMC_ERR_CORRUPT, beyond_limit.bytes());
  broken_header("level-0", "regions from level 0 on", {2, 0, 1});
  broken_header("no-levels", "regions without levels", {2, 1, 0});
  broken_header("level-too-fine", "levels 1 and 2 of two", {2, 1, 2});
  HeaderFields row_of_no_region;
  row_of_no_region.flags = 16;
  row_of_no_region.rows[0].region = 3;
  writer.add_broken("regions-row", "a row of region 2 of two", NMC_ERR_CORRUPT, row_of_no_region.bytes());

  HeaderFields header;
  header.flags = 16;
  const Bytes base = tetrahedron_base_chunk();
  const Bytes shared = chunk(3, {0, 0, 1, 0, 0, 0, 0, 0, 0});
  const auto region = [](std::uint8_t number) {
    Bytes payload = {number};  // one quality layer
    for (int i = 0; i < 60; ++i) payload.push_back(static_cast<std::uint8_t>(41 * i));
    return chunk(5, payload);
  };
  const auto broken = [&](const std::string& id, const std::string& what, const std::vector<Bytes>& chunks) {
    writer.add_broken("regions-" + id, what, NMC_ERR_CORRUPT, stream_with(header, chunks));
  };
  broken("too-short", "no byte of payload", {base, shared, chunk(5, {})});
  broken("before-base", "a region first", {region(0), base});
  broken("not-announced", "region 2 of two", {base, shared, region(2)});
  broken("misspelt", "a place in more bytes than it takes", {base, shared, chunk(5, {0x80, 0x00, 1, 2, 3, 4, 5})});
  broken("before-shared-level", "a region before the level below", {base, region(0)});
  broken("twice", "region 0 twice", {base, shared, region(0), region(0)});
  broken("level-for-all", "a chunk for all of a level that is divided", {base, shared, chunk(3, {0, 1, 1, 0, 0, 0})});
  broken("overread", "a region that needs more bytes than it has", {base, shared, chunk(5, {0, 0x35})});
  header.flags = 0;
  broken("without-flag", "a region in a stream that has none", {base, shared, region(0)});
  header.flags = 16;
  header.rows.assign(2, {0, 0, 1, 1, 0});
  header.row_count = 2;
  const Bytes other = region(1);
  header.rows[0].size = base.size() + shared.size();
  header.rows[1].size = other.size();
  header.rows[1].region = 1;
  Bytes wrong_row = header.bytes();
  for (const Bytes* c : {&base, &shared, &other}) wrong_row.insert(wrong_row.end(), c->begin(), c->end());
  writer.add_broken("regions-wrong-row", "region 1 in the row of region 0", NMC_ERR_CORRUPT, wrong_row);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: conformance_generate DIRECTORY\n");
    return 1;
  }
  fs::remove_all(argv[1]);
  fs::create_directories(argv[1]);
  VectorWriter writer(argv[1]);
  add_valid_vectors(writer);
  add_header_vectors(writer);
  add_chunk_vectors(writer);
  add_attribute_vectors(writer);
  add_region_vectors(writer);
  return writer.finish() ? 0 : 1;
}
