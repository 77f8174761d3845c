// SPDX-License-Identifier: Apache-2.0
// What the fuzz targets of streams share: limits, and a mutator that knows the container. Without it nearly
// every change would end at a checksum.
#ifndef NMC_TESTS_FUZZ_STREAM_FUZZ_H_
#define NMC_TESTS_FUZZ_STREAM_FUZZ_H_

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "libnmc/decode/header_parser.h"
#include "libnmc/encode/stream_writer.h"
#include "tests/support/header_bytes.h"
#include "tests/support/repair_checksums.h"
#include "tests/support/stream_decoding.h"

namespace nmc::fuzz {

/// Room enough for what a few kilobytes may describe, and little enough for thousands of runs a second.
inline nmc_limits limits() {
  nmc_limits limits = nmc_default_limits();
  limits.max_memory = 16 << 20;
  limits.max_vertices = 20000;
  return limits;
}

inline void require(bool condition) {
  if (!condition) std::abort();
}

/// A stream taken apart: the header as numbers, the chunks of each row.
struct StreamParts {
  struct Chunk {
    std::uint8_t type;
    test::Bytes payload;
    std::size_t row;
  };
  Header header;
  std::vector<Chunk> chunks;

  /// False when the bytes have no header or no whole chunk.
  bool take_apart(const std::uint8_t* data, std::size_t size) {
    std::size_t position = 0;
    if (!measure_header(data, size, position).ok() || position > size) return false;
    if (!parse_header(data, position, header).ok()) return false;
    std::size_t row = 0, row_end = position + static_cast<std::size_t>(header.layers[0].size);
    while (position + 6 <= size) {
      while (position >= row_end && row + 1 < header.layers.size()) {
        row_end += static_cast<std::size_t>(header.layers[++row].size);
      }
      ByteReader reader(data + position + 1, size - position - 1);
      const std::uint64_t payload_size = reader.read_varint();
      const std::size_t begin = position + 1 + reader.position();
      if (reader.overrun() || reader.malformed() || size - begin < 4 || payload_size > size - begin - 4) break;
      const std::uint8_t* payload = data + begin;
      chunks.push_back({data[position], test::Bytes(payload, payload + payload_size), row});
      position = begin + static_cast<std::size_t>(payload_size) + 4;
    }
    return !chunks.empty();
  }
  /// The stream again, with sizes of rows and checksums that fit the chunks.
  test::Bytes put_together() {
    for (LayerEntry& entry : header.layers) entry.size = 0;
    test::Bytes body;
    for (const Chunk& chunk : chunks) {
      const test::Bytes bytes = test::chunk(chunk.type, chunk.payload);
      header.layers[std::min(chunk.row, header.layers.size() - 1)].size += bytes.size();
      body.insert(body.end(), bytes.begin(), bytes.end());
    }
    for (LayerEntry& entry : header.layers) {
      if (entry.size == 0) entry.size = 1;
    }
    Array<std::uint8_t> head;
    if (!write_header(header, head).ok()) return {};
    test::Bytes stream(head.begin(), head.end());
    stream.insert(stream.end(), body.begin(), body.end());
    return stream;
  }
};

}  // namespace nmc::fuzz

#ifndef NMC_FUZZ_STANDALONE
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t maximum_size);

/// One change that keeps the container whole: of a payload, of the order, number or type of chunks, of the
/// header; or a change of any bytes, mostly with the checksums repaired.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t maximum_size,
                                               unsigned int seed) {
  using nmc::test::Bytes;
  nmc::fuzz::StreamParts parts;
  const unsigned int choice = seed % 16, pick = seed / 16;
  if (choice >= 12 || !parts.take_apart(data, size)) {
    size = LLVMFuzzerMutate(data, size, maximum_size);
    if (choice != 15) nmc::test::repair_checksums(data, size);
    return size;
  }
  auto& chunks = parts.chunks;
  auto& chunk = chunks[pick % chunks.size()];
  if (choice < 7) {
    Bytes payload = chunk.payload;
    const std::size_t room = payload.size() + std::min<std::size_t>(maximum_size - size, 64);
    payload.resize(std::max<std::size_t>(room, 1));
    payload.resize(LLVMFuzzerMutate(payload.data(), chunk.payload.size(), payload.size()));
    chunk.payload = payload;
  } else if (choice == 7) {
    std::swap(chunk, chunks[(pick / 8) % chunks.size()]);
  } else if (choice == 8) {
    chunks.insert(chunks.begin() + static_cast<std::ptrdiff_t>((pick / 8) % (chunks.size() + 1)),
                  nmc::fuzz::StreamParts::Chunk(chunk));
  } else if (choice == 9 && chunks.size() > 1) {
    chunks.erase(chunks.begin() + static_cast<std::ptrdiff_t>(pick % chunks.size()));
  } else if (choice == 10) {
    chunk.row = (pick / 8) % parts.header.layers.size();
  } else {
    nmc::Header& h = parts.header;
    switch (pick % 8) {
      case 0:
        h.level_count = static_cast<int>((pick / 8) % 6);
        break;
      case 1:
        h.base_face_count = static_cast<std::uint32_t>(1 + (pick / 8) % 64);
        break;
      case 2:
        h.base_vertex_count = static_cast<std::uint32_t>(3 + (pick / 8) % 64);
        break;
      case 3:
        h.has_creases = !h.has_creases;
        break;
      case 4:
        h.step_code[(pick / 8) % 14] = static_cast<std::uint8_t>(pick / 128);
        break;
      case 5:
        h.tension_code[(pick / 8) % 14] = static_cast<std::uint8_t>(pick / 128 % 9);
        break;
      case 6:
        h.tangential_code = static_cast<std::uint8_t>(pick / 8);
        break;
      default:
        h.layers[(pick / 8) % h.layers.size()].level = static_cast<std::uint8_t>(pick / 128 % 6);
        break;
    }
  }
  const Bytes changed = parts.put_together();
  if (changed.empty() || changed.size() > maximum_size) return size;
  std::copy(changed.begin(), changed.end(), data);
  return changed.size();
}
#endif

#endif  // NMC_TESTS_FUZZ_STREAM_FUZZ_H_
