// SPDX-License-Identifier: Apache-2.0
// nmc_fuzz_stream_seeds FOLDER: random valid streams and their parts, one folder per fuzz target of streams.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "libnmc/common/byte_reader.h"
#include "libnmc/decode/header_parser.h"
#include "tests/support/stream_generator.h"

namespace {

using Bytes = std::vector<std::uint8_t>;

bool write(const std::filesystem::path& folder, const std::string& name, const Bytes& bytes) {
  std::filesystem::create_directories(folder);
  std::ofstream file(folder / name, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (file.flush()) return true;
  std::fprintf(stderr, "%s: cannot be written\n", (folder / name).c_str());
  return false;
}

}  // namespace

int main(int argument_count, char** arguments) {
  using namespace nmc;
  if (argument_count != 2) {
    std::fprintf(stderr, "usage: nmc_fuzz_stream_seeds FOLDER\n");
    return 1;
  }
  const std::filesystem::path root = arguments[1];
  for (std::uint64_t seed = 1; seed <= 150; ++seed) {
    test::StreamRecipe recipe = test::random_recipe(seed);
    recipe.level_count = recipe.level_count > 2 ? 2 : recipe.level_count;
    const test::GeneratedStream stream = test::generate(recipe);
    if (stream.bytes.size() > 2048) continue;
    const std::string name = "random_" + std::to_string(seed);
    bool written = true;
    for (const char* target : {"stream", "trim", "reference"})
      written &= write(root / target, name, stream.bytes);
    Bytes with_choice = stream.bytes;
    for (const std::uint8_t byte : {7, 3, 40, 128}) with_choice.push_back(byte);
    written &= write(root / "split", name, with_choice);

    std::size_t position = 0;
    Header header;
    if (!measure_header(stream.bytes.data(), stream.bytes.size(), position).ok() ||
        !parse_header(stream.bytes.data(), position, header).ok()) {
      return 3;
    }
    const auto at = [&](std::size_t offset) {
      return stream.bytes.begin() + static_cast<std::ptrdiff_t>(offset);
    };
    written &= write(root / "header", name, Bytes(stream.bytes.begin(), at(position)));
    while (position + 6 <= stream.bytes.size()) {
      ByteReader reader(stream.bytes.data() + position + 1, stream.bytes.size() - position - 1);
      const auto size = static_cast<std::size_t>(reader.read_varint());
      const std::size_t begin = position + 1 + reader.position();
      Bytes payload;
      if (stream.bytes[position] == 1 && header.base_vertex_count < 258 && header.base_face_count < 256) {
        payload = {static_cast<std::uint8_t>(header.base_vertex_count - 3),
                   static_cast<std::uint8_t>(header.base_face_count - 1),
                   static_cast<std::uint8_t>(header.has_creases)};
        payload.insert(payload.end(), at(begin), at(begin + size));
        written &= write(root / "base_mesh", name, payload);
      } else if (stream.bytes[position] == 3) {
        payload = {static_cast<std::uint8_t>(seed), static_cast<std::uint8_t>(seed / 8)};
        payload.insert(payload.end(), at(begin + 3), at(begin + size));
        written &= write(root / "coefficient", name + "_" + std::to_string(position), payload);
      }
      position = begin + size + 4;
    }
    if (!written) return 2;
  }
  return 0;
}
