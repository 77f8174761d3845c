// SPDX-License-Identifier: Apache-2.0
#include "encoder/tool/progressive_glb.h"

#include <algorithm>
#include <memory>
#include <vector>

#include "decoder/write/mesh_writer.h"
#include "encoder/core/error.h"
#include "libnmc/include/nmc/nmc.h"

namespace nmc {

namespace {

constexpr double kMostCoarseTriangles = 4096;

struct DestroyDecoder {
  void operator()(nmc_decoder* decoder) const { nmc_decoder_destroy(&decoder); }
};
using Decoder = std::unique_ptr<nmc_decoder, DestroyDecoder>;

void check(nmc_status status, const nmc_decoder* decoder) {
  if (status == NMC_OK) return;
  nmc_error_detail detail{};
  nmc_decoder_error(decoder, &detail);
  throw Error(ExitCode::kInternal, std::string("the new stream cannot be read: ") + nmc_status_name(status) +
                                       " " + (detail.message ? detail.message : ""));
}

/// Goes on to the event of layer `index`.
void decode_layer(nmc_decoder* decoder, std::uint32_t index) {
  for (std::uint32_t seen = 0; seen <= index;) {
    nmc_event event = NMC_EVENT_END;
    check(nmc_decoder_next(decoder, &event), decoder);
    if (event == NMC_EVENT_LAYER) ++seen;
  }
}

}  // namespace

void write_stream_as_glb(const std::string& path, std::span<const std::uint8_t> stream) {
  nmc_decoder* created = nullptr;
  check(nmc_decoder_create(&created, nullptr, nullptr), nullptr);
  const Decoder owner(created);
  nmc_decoder* const decoder = owner.get();
  check(nmc_decoder_feed(decoder, stream.data(), stream.size()), decoder);
  nmc_event event = NMC_EVENT_END;
  check(nmc_decoder_next(decoder, &event), decoder);
  nmc_info info;
  check(nmc_decoder_info(decoder, &info), decoder);

  ProgressiveStream progressive;
  progressive.bytes = stream;
  std::copy(info.box_min, info.box_min + 3, progressive.box_minimum.begin());
  std::copy(info.box_max, info.box_max + 3, progressive.box_maximum.begin());
  std::vector<ProgressiveLayer> layers;
  for (std::uint32_t i = 0; i < info.layer_count; ++i) {
    nmc_layer layer;
    check(nmc_decoder_layer(decoder, i, &layer), decoder);
    layers.push_back({layer.end_offset, layer.face_count, layer.has_error != 0, layer.max_error});
  }
  progressive.layers = layers;

  std::uint32_t index = 0;
  check(nmc_decoder_select_layer(decoder, NMC_BY_FACES, kMostCoarseTriangles, &index, nullptr), decoder);
  decode_layer(decoder, index);
  nmc_layer layer;
  check(nmc_decoder_current_layer(decoder, &layer), decoder);
  std::uint32_t vertex_count = 0, face_count = 0;
  check(nmc_decoder_mesh_size(decoder, layer.level, &vertex_count, &face_count), decoder);
  std::vector<std::uint32_t> triangles(std::size_t{3} * face_count);
  std::vector<float> positions(std::size_t{3} * vertex_count), normals(std::size_t{3} * vertex_count);
  check(nmc_decoder_read_indices(decoder, layer.level, triangles.data(), triangles.size()), decoder);
  constexpr std::size_t kStride = 3 * sizeof(float);
  check(nmc_decoder_read_positions(decoder, layer.level, positions.data(), kStride, vertex_count), decoder);
  check(nmc_decoder_read_normals(decoder, layer.level, normals.data(), kStride, vertex_count), decoder);
  std::vector<std::uint8_t> colors;
  if (info.has_colors) {
    colors.resize(std::size_t{3} * vertex_count);
    const nmc_status read = nmc_decoder_read_colors(decoder, layer.level, colors.data(), 3, 3, vertex_count);
    if (read == NMC_ERR_STATE) {
      colors.clear();  // they come with a later layer
    } else {
      check(read, decoder);
    }
  }
  MeshView coarse;
  coarse.positions_single = positions;
  coarse.normals = normals;
  coarse.triangles = triangles;
  coarse.colors = colors;
  const WriteStatus written = write_progressive_glb(path, coarse, progressive);
  if (written.is_ok()) return;
  throw Error(written.outcome == WriteOutcome::kInputOutput ? ExitCode::kInputOutput : ExitCode::kUnsupported,
              written.message);
}

}  // namespace nmc
