// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <vector>

#include "decoder/tool/threads.h"
#include "libnmc/include/nmc/nmc.hpp"
#include "tests/support/stream_decoding.h"
#include "tests/support/stream_generator.h"

extern "C" int decode_in_c(const void* data, size_t size, uint32_t* face_count);

using namespace nmc;
using namespace nmc::test;

namespace {

GeneratedStream example(int level_count = 3, int quality_layers = 2) {
  StreamRecipe recipe;
  recipe.base = grid(4, 3, true);
  recipe.level_count = level_count;
  recipe.quality_layer_count = quality_layers;
  recipe.largest_coordinate = 1000;
  return generate(recipe);
}

/// A reader that has worked through the whole of `stream`.
StreamReader finished_reader(const GeneratedStream& stream) {
  StreamReader reader;
  REQUIRE(reader.status() == NMC_OK);
  REQUIRE(reader.feed(std::span<const std::uint8_t>(stream.bytes)) == NMC_OK);
  nmc_event event{};
  while (reader.next(event) == NMC_OK) {
  }
  REQUIRE(reader.finish() == NMC_OK);
  return reader;
}

}  // namespace

TEST_CASE("nmc.h: the loop of its comment decodes a stream in C", "[api]") {
  const GeneratedStream stream = example();
  uint32_t face_count = 0;
  CHECK(decode_in_c(stream.bytes.data(), stream.bytes.size(), &face_count) == NMC_OK);
  CHECK(face_count == 24 * 64);
}

TEST_CASE("nmc.h: any number of threads gives the same bits", "[api][determinism]") {
  StreamRecipe recipe;
  recipe.base = grid(6, 5, true);
  recipe.level_count = 6;
  recipe.tangential_density = 0.01;
  const GeneratedStream stream = generate(recipe);
  StreamReader alone = finished_reader(stream), many = finished_reader(stream);
  nmc_info info{};
  REQUIRE(alone.info(info) == NMC_OK);
  std::uint64_t expected = 0, hash = 0;
  REQUIRE(alone.position_hash(info.level_count, expected) == NMC_OK);
  for (unsigned count : {2u, 3u, 0u}) {
    ThreadCount threads{count};
    StreamReader reader = finished_reader(stream);
    REQUIRE(reader.set_threads(run_on_threads, &threads) == NMC_OK);
    REQUIRE(reader.position_hash(info.level_count, hash) == NMC_OK);
    INFO(count << " threads");
    CHECK(hash == expected);
  }
  // A level is made in tasks, and each is asked for once.
  std::vector<int> calls;
  const auto count_calls = [](void* user, void (*task)(void*, std::uint32_t), void* context, std::uint32_t task_count) {
    static_cast<std::vector<int>*>(user)->push_back(static_cast<int>(task_count));
    for (std::uint32_t i = task_count; i-- > 0;) task(context, i);
  };
  REQUIRE(many.set_threads(count_calls, &calls) == NMC_OK);
  REQUIRE(many.position_hash(info.level_count, hash) == NMC_OK);
  CHECK(hash == expected);
  CHECK(calls == std::vector<int>{2, 6});
}

TEST_CASE("nmc.h: events come in their order, and what they make legal is legal", "[api]") {
  const GeneratedStream stream = example();
  StreamReader reader;
  nmc_event event{};
  nmc_info info{};
  nmc_layer layer{};
  uint32_t vertex_count = 0, face_count = 0;
  CHECK(reader.next(event) == NMC_NEED_MORE_INPUT);
  CHECK(reader.info(info) == NMC_ERR_STATE);
  CHECK(reader.layer(0, layer) == NMC_ERR_STATE);
  CHECK(reader.mesh_size(0, vertex_count, face_count) == NMC_ERR_STATE);
  REQUIRE(reader.feed(std::span<const std::uint8_t>(stream.bytes)) == NMC_OK);
  REQUIRE(reader.next(event) == NMC_OK);
  REQUIRE(event == NMC_EVENT_HEADER);
  REQUIRE(reader.info(info) == NMC_OK);
  CHECK(info.layer_count == stream.layers.size());
  CHECK(info.stream_size == stream.bytes.size());
  CHECK(info.level_count == 3);
  CHECK(info.quality_layer_count == 2);
  CHECK(reader.current_layer(layer) == NMC_ERR_STATE);
  for (uint32_t i = 0; i < info.layer_count; ++i) {
    REQUIRE(reader.next(event) == NMC_OK);
    REQUIRE(event == NMC_EVENT_LAYER);
    REQUIRE(reader.current_layer(layer) == NMC_OK);
    CHECK(layer.index == i);
    CHECK(layer.end_offset == stream.layers[i].end_offset);
    CHECK(layer.face_count == uint64_t{24} << (2 * layer.level));
  }
  REQUIRE(reader.next(event) == NMC_OK);
  REQUIRE(event == NMC_EVENT_END);
  CHECK(reader.next(event) == NMC_NEED_MORE_INPUT);
  CHECK(reader.finish() == NMC_OK);
}

TEST_CASE("nmc.h: all levels can be read at any time, and vertices keep their numbers", "[api]") {
  const GeneratedStream stream = example();
  StreamReader reader = finished_reader(stream);
  std::vector<float> coarser;
  for (uint32_t level = 0; level <= 3; ++level) {
    uint32_t vertex_count = 0, face_count = 0;
    REQUIRE(reader.mesh_size(level, vertex_count, face_count) == NMC_OK);
    CHECK(face_count == 24u << (2 * level));
    CHECK(vertex_count == 12u << (2 * level));  // a torus
    std::vector<uint32_t> indices(3 * face_count);
    std::vector<float> positions(3 * vertex_count), normals(3 * vertex_count);
    std::vector<double> exact(3 * vertex_count);
    REQUIRE(reader.read_indices(level, indices) == NMC_OK);
    REQUIRE(reader.read_positions(level, std::span<float>(positions)) == NMC_OK);
    REQUIRE(reader.read_positions(level, std::span<double>(exact)) == NMC_OK);
    REQUIRE(reader.read_normals(level, normals) == NMC_OK);
    for (std::size_t i = 0; i < positions.size(); ++i) REQUIRE(positions[i] == static_cast<float>(exact[i]));
    for (std::size_t i = 0; i < coarser.size(); ++i) REQUIRE(positions[i] == coarser[i]);
    for (uint32_t v = 0; v < vertex_count; ++v) {
      const double length = std::sqrt(double{normals[3 * v]} * normals[3 * v] +
                                      double{normals[3 * v + 1]} * normals[3 * v + 1] +
                                      double{normals[3 * v + 2]} * normals[3 * v + 2]);
      REQUIRE(length == Approx(1).epsilon(1e-6));
    }
    coarser = positions;
  }
}

TEST_CASE("nmc.h: indices are those of the subdivided base mesh, level by level", "[api]") {
  const GeneratedStream stream = example();
  StreamReader reader = finished_reader(stream);
  std::vector<uint32_t> base(3 * 24);
  REQUIRE(reader.read_indices(0, base) == NMC_OK);
  LevelTopology topology[4];
  REQUIRE(build_base_topology(base.data(), 24, 12, nullptr, topology[0]).ok());
  for (uint32_t level = 1; level <= 3; ++level) {
    REQUIRE(subdivide(topology[level - 1], false, topology[level]).ok());
    std::vector<uint32_t> indices(std::size_t{72} << (2 * level));
    REQUIRE(reader.read_indices(level, indices) == NMC_OK);
    REQUIRE(std::memcmp(indices.data(), topology[level].face_vertices.data(), indices.size() * 4) == 0);
  }
}

TEST_CASE("nmc.h: normals of a flat mesh in tiny or huge units are exact", "[api]") {
  for (const int exponent : {-150, -30, 0, 60}) {
    Header header;
    header.step_exponent = exponent;
    header.base_vertex_count = 4;
    header.base_face_count = 2;
    StreamWriter writer(header);
    const std::uint32_t faces[6] = {0, 1, 2, 0, 2, 3};
    const std::int32_t corners[12] = {0, 0, 0, 8, 0, 0, 8, 8, 0, 0, 8, 0};
    Array<std::uint32_t> old_index;
    REQUIRE(writer.add_base(faces, corners, nullptr, old_index).ok());
    REQUIRE(writer.end_layer(0, 0, 0).ok());
    Array<std::uint8_t> bytes;
    REQUIRE(writer.write_stream(bytes).ok());
    GeneratedStream stream;
    stream.bytes.assign(bytes.begin(), bytes.end());
    StreamReader reader = finished_reader(stream);
    std::vector<float> normals(12);
    REQUIRE(reader.read_normals(0, normals) == NMC_OK);
    INFO("grid step 2^" << exponent);
    for (int v = 0; v < 4; ++v) {
      CHECK(normals[3 * v] == 0);
      CHECK(normals[3 * v + 1] == 0);
      CHECK(normals[3 * v + 2] == 1);
    }
  }
}

TEST_CASE("nmc.h: strides leave what lies between untouched", "[api]") {
  const GeneratedStream stream = example();
  StreamReader reader = finished_reader(stream);
  uint32_t vertex_count = 0, face_count = 0;
  REQUIRE(reader.mesh_size(2, vertex_count, face_count) == NMC_OK);
  std::vector<float> packed(3 * vertex_count), spread(8 * vertex_count, 77.0f);
  REQUIRE(reader.read_positions(2, std::span<float>(packed)) == NMC_OK);
  REQUIRE(nmc_decoder_read_positions(reader.get(), 2, spread.data(), 32, vertex_count) == NMC_OK);
  REQUIRE(nmc_decoder_read_normals(reader.get(), 2, spread.data() + 4, 32, vertex_count) == NMC_OK);
  for (uint32_t v = 0; v < vertex_count; ++v) {
    for (int k = 0; k < 3; ++k) REQUIRE(spread[8 * v + k] == packed[3 * v + k]);
    REQUIRE(spread[8 * v + 3] == 77.0f);
    REQUIRE(spread[8 * v + 7] == 77.0f);
  }
}

TEST_CASE("nmc.h: mistakes of the caller are refused and leave the decoder usable", "[api]") {
  const GeneratedStream stream = example();
  StreamReader reader = finished_reader(stream);
  nmc_decoder* decoder = reader.get();
  uint32_t n = 0, index = 0;
  std::vector<float> positions(3 * 12);
  std::vector<uint32_t> indices(3 * 24);
  CHECK(nmc_decoder_create(nullptr, nullptr, nullptr) == NMC_ERR_ARGUMENT);
  CHECK(nmc_decoder_feed(decoder, nullptr, 1) == NMC_ERR_ARGUMENT);
  CHECK(nmc_decoder_next(decoder, nullptr) == NMC_ERR_ARGUMENT);
  CHECK(nmc_decoder_next(nullptr, nullptr) == NMC_ERR_ARGUMENT);
  CHECK(nmc_decoder_info(decoder, nullptr) == NMC_ERR_ARGUMENT);
  CHECK(nmc_decoder_mesh_size(decoder, 4, &n, &n) == NMC_ERR_ARGUMENT);
  CHECK(nmc_decoder_mesh_size(decoder, 0xffffffffu, &n, &n) == NMC_ERR_ARGUMENT);
  CHECK(nmc_decoder_read_positions(decoder, 0, positions.data(), 12, 11) == NMC_ERR_ARGUMENT);
  CHECK(nmc_decoder_read_positions(decoder, 0, positions.data(), 8, 12) == NMC_ERR_ARGUMENT);
  CHECK(nmc_decoder_read_positions(decoder, 0, positions.data(), 13, 12) == NMC_ERR_ARGUMENT);
  CHECK(nmc_decoder_read_positions(decoder, 0, nullptr, 12, 12) == NMC_ERR_ARGUMENT);
  CHECK(nmc_decoder_read_indices(decoder, 0, indices.data(), 71) == NMC_ERR_ARGUMENT);
  CHECK(nmc_decoder_layer(decoder, 99, nullptr) == NMC_ERR_ARGUMENT);
  CHECK(nmc_decoder_select_layer(decoder, static_cast<nmc_criterion>(7), 1, &index, nullptr) ==
        NMC_ERR_ARGUMENT);
  nmc_error_detail detail{};
  REQUIRE(nmc_decoder_error(decoder, &detail) == NMC_OK);
  CHECK(detail.status == NMC_ERR_ARGUMENT);
  CHECK(std::string(detail.message).size() > 5);
  CHECK(nmc_decoder_read_positions(decoder, 0, positions.data(), 12, 12) == NMC_OK);
  CHECK(nmc_decoder_read_indices(decoder, 0, indices.data(), 72) == NMC_OK);
  nmc_decoder_destroy(nullptr);
  nmc_decoder* none = nullptr;
  nmc_decoder_destroy(&none);
}

TEST_CASE("nmc.h: a layer can be chosen by error, faces, bytes or level", "[api]") {
  const GeneratedStream stream = example(3, 1);
  StreamReader reader = finished_reader(stream);
  std::vector<nmc_layer> rows(stream.layers.size());
  for (uint32_t i = 0; i < rows.size(); ++i) REQUIRE(reader.layer(i, rows[i]) == NMC_OK);
  uint32_t index = 99;
  bool is_met = false;
  REQUIRE(reader.select_layer(NMC_BY_MAX_ERROR, rows[2].max_error, index, &is_met) == NMC_OK);
  CHECK((index == 2 && is_met));
  REQUIRE(reader.select_layer(NMC_BY_RMS_ERROR, rows[1].rms_error * 1.000001, index, &is_met) == NMC_OK);
  CHECK((index == 1 && is_met));
  REQUIRE(reader.select_layer(NMC_BY_MAX_ERROR, 0, index, &is_met) == NMC_OK);
  CHECK((index == 3 && !is_met));
  REQUIRE(reader.select_layer(NMC_BY_FACES, 24 * 16 + 5, index, &is_met) == NMC_OK);
  CHECK((index == 2 && is_met));
  REQUIRE(reader.select_layer(NMC_BY_FACES, 1, index, &is_met) == NMC_OK);
  CHECK((index == 0 && !is_met));
  REQUIRE(reader.select_layer(NMC_BY_BYTES, static_cast<double>(rows[1].end_offset), index, &is_met) ==
          NMC_OK);
  CHECK((index == 1 && is_met));
  REQUIRE(reader.select_layer(NMC_BY_LEVEL, 1, index, &is_met) == NMC_OK);
  CHECK((index == 1 && is_met));
}

TEST_CASE("nmc.h: should_stop ends the work", "[api]") {
  const GeneratedStream stream = example();
  nmc_limits limits = nmc_default_limits();
  int calls = 0;
  limits.should_stop_user = &calls;
  limits.should_stop = [](void* user) { return ++*static_cast<int*>(user) > 3 ? 1 : 0; };
  const Decoding stopped = decode(stream.bytes, {~std::size_t{0}}, &limits);
  INFO(stopped);
  CHECK(stopped.status == NMC_ERR_STOPPED);
  CHECK(calls >= 4);
}

TEST_CASE("nmc.h: a limits structure of an older caller leaves new fields at their defaults", "[api]") {
  nmc_limits limits = nmc_default_limits();
  limits.struct_size = offsetof(nmc_limits, max_vertices);
  limits.max_vertices = 1;  // beyond struct_size: not looked at
  CHECK(decode(example().bytes, {~std::size_t{0}}, &limits).status == NMC_OK);
  limits.struct_size = 3;
  nmc_decoder* decoder = nullptr;
  CHECK(nmc_decoder_create(&decoder, &limits, nullptr) == NMC_ERR_ARGUMENT);
  CHECK(decoder == nullptr);
}

TEST_CASE("nmc.h: each limit refuses what passes it and keeps the layers before", "[api]") {
  const GeneratedStream stream = example(3, 1);
  const auto with = [&](auto change) {
    nmc_limits limits = nmc_default_limits();
    change(limits);
    return decode(stream.bytes, {~std::size_t{0}}, &limits);
  };
  CHECK(with([](nmc_limits& l) { l.max_base_vertices = 11; }).status == NMC_ERR_LIMIT);
  CHECK(with([](nmc_limits& l) { l.max_base_vertices = 12; }).status == NMC_OK);
  CHECK(with([](nmc_limits& l) { l.max_levels = 2; }).status == NMC_ERR_LIMIT);
  CHECK(with([](nmc_limits& l) { l.max_chunk_size = 4; }).status == NMC_ERR_LIMIT);
  const Decoding cut = with([](nmc_limits& l) { l.max_vertices = 200; });
  INFO(cut);
  CHECK(cut.status == NMC_ERR_LIMIT);
  CHECK(cut.layers.size() == 3);  // levels 0, 1 and 2 with 12, 48 and 192 vertices
  const std::uint64_t peak = decode(stream.bytes).peak_memory;
  for (std::uint64_t limit = 1000; limit < peak + 1000; limit += peak / 50) {
    const Decoding limited = with([&](nmc_limits& l) { l.max_memory = limit; });
    INFO("limit " << limit << ": " << limited);
    CHECK(limited.peak_memory <= limit);
    // Decoding may just fit while reading positions does not; then the hash of that level is missing.
    const bool all_read = limited.status == NMC_OK && limited.layers.back().position_hash != 0;
    CHECK((limited.status == NMC_OK || limited.status == NMC_ERR_LIMIT));
    CHECK(all_read == (limit >= peak));
  }
}

TEST_CASE("nmc.h: statuses have names", "[api]") {
  CHECK(std::string(nmc_status_name(NMC_ERR_CHECKSUM)) == "NMC_ERR_CHECKSUM");
  CHECK(std::string(nmc_status_name(NMC_ERR_STOPPED)) == "NMC_ERR_STOPPED");
  CHECK(std::string(nmc_status_name(static_cast<nmc_status>(-60))) == "NMC_UNKNOWN");
  CHECK(nmc_version() == NMC_VERSION);
  CHECK(nmc_format_version() == 1);
}
