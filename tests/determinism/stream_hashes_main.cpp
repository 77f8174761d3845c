// SPDX-License-Identifier: Apache-2.0
// Prints what a decoder finds in each file given, for comparison between builds: per row of the layer table its end,
// level, state hash, position hash and the hash of its 32-bit positions and normals; at last status, offset, section.
// With nothing but nmc.h and the standard library, so that it builds wherever the decoder does.
#include <cinttypes>
#include <cstdio>
#include <cstring>
#include <vector>

#include "libnmc/include/nmc/nmc.h"

#ifdef NMC_TWO_THREADS
#include "decoder/tool/threads.h"
#endif

namespace {

std::uint64_t hash_of(const std::vector<float>& values) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const float value : values) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    hash = (hash ^ bits) * 0x100000001b3u;
  }
  return hash;
}

void print_row(nmc_decoder* decoder, const char* name) {
  nmc_layer row;
  nmc_decoder_current_layer(decoder, &row);
  std::uint64_t state = 0, positions = 0;
  nmc_decoder_state_hash(decoder, &state);
  nmc_decoder_position_hash(decoder, row.level, &positions);
  std::uint32_t vertex_count = 0, face_count = 0;
  std::vector<float> xyz, normals;
  if (nmc_decoder_mesh_size(decoder, row.level, &vertex_count, &face_count) == NMC_OK) {
    xyz.resize(std::size_t{3} * vertex_count);
    normals.resize(xyz.size());
    nmc_decoder_read_positions(decoder, row.level, xyz.data(), 12, vertex_count);
    nmc_decoder_read_normals(decoder, row.level, normals.data(), 12, vertex_count);
  }
  std::printf("%s row %" PRIu64 " %u %016" PRIx64 " %016" PRIx64 " %016" PRIx64 " %016" PRIx64 "\n", name,
              row.end_offset, row.level, state, positions, hash_of(xyz), hash_of(normals));
}

bool print_file(const char* path, const char* name) {
  std::FILE* file = std::fopen(path, "rb");
  if (!file) return false;
  nmc_decoder* decoder = nullptr;
  if (nmc_decoder_create(&decoder, nullptr, nullptr) != NMC_OK) return false;
#ifdef NMC_TWO_THREADS
  nmc::ThreadCount two{2};
  nmc_decoder_set_threads(decoder, nmc::run_on_threads, &two);
#endif
  std::vector<unsigned char> piece(1 << 16);
  nmc_status status = NMC_OK;
  while (true) {
    nmc_event event;
    status = nmc_decoder_next(decoder, &event);
    if (status == NMC_OK && event == NMC_EVENT_LAYER) print_row(decoder, name);
    if (status == NMC_OK) continue;
    if (status != NMC_NEED_MORE_INPUT) break;
    const std::size_t size = std::fread(piece.data(), 1, piece.size(), file);
    if (size == 0) {
      status = nmc_decoder_finish(decoder);
      break;
    }
    status = nmc_decoder_feed(decoder, piece.data(), size);
    if (status != NMC_OK) break;
  }
  nmc_error_detail error;
  nmc_decoder_error(decoder, &error);
  std::printf("%s %s %" PRIu64 " %s\n", name, nmc_status_name(status), error.byte_offset, error.spec_section);
  nmc_decoder_destroy(&decoder);
  std::fclose(file);
  return true;
}

}  // namespace

int main(int argument_count, char** arguments) {
  for (int i = 1; i < argument_count; ++i) {
    // Vectors are all called stream.nmc: the last two parts of the path tell them apart.
    const char* name = arguments[i];
    int slashes = 0;
    for (const char* c = name + std::strlen(name); c != arguments[i]; --c) {
      if (*c == '/' && ++slashes == 2) {
        name = c + 1;
        break;
      }
    }
    if (!print_file(arguments[i], name)) {
      std::fprintf(stderr, "%s cannot be read\n", arguments[i]);
      return 2;
    }
  }
  return argument_count > 1 ? 0 : 1;
}
