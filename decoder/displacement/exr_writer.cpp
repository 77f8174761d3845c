// SPDX-License-Identifier: Apache-2.0
// After: OpenEXR File Layout, openexr.com/en/latest/OpenEXRFileLayout.html.
#include "decoder/displacement/exr_writer.h"

#include <cstring>

#include "decoder/write/number_text.h"

namespace nmc {

namespace {

constexpr std::uint32_t kMagic = 20000630, kVersion = 2, kFloatPixels = 2;

void append_name(std::string& bytes, const char* name) { bytes.append(name, std::strlen(name) + 1); }

void append_attribute(std::string& bytes, const char* name, const char* type, const std::string& value) {
  append_name(bytes, name);
  append_name(bytes, type);
  append_little_endian(bytes, static_cast<std::uint32_t>(value.size()));
  bytes += value;
}

std::string header(std::uint32_t width, std::uint32_t height) {
  std::string bytes, channels, window, center, one;
  for (const char* name : {"B", "G", "R"}) {
    append_name(channels, name);
    append_little_endian(channels, kFloatPixels);
    append_little_endian(channels, std::uint32_t{0});  // not perceptual, and three reserved bytes
    append_little_endian(channels, std::uint32_t{1});  // every column
    append_little_endian(channels, std::uint32_t{1});  // every row
  }
  channels.push_back('\0');
  for (const std::uint32_t bound : {0u, 0u, width - 1, height - 1}) append_little_endian(window, bound);
  append_little_endian(center, 0.0f);
  append_little_endian(center, 0.0f);
  append_little_endian(one, 1.0f);
  append_little_endian(bytes, kMagic);
  append_little_endian(bytes, kVersion);
  append_attribute(bytes, "channels", "chlist", channels);
  append_attribute(bytes, "compression", "compression", std::string(1, '\0'));
  append_attribute(bytes, "dataWindow", "box2i", window);
  append_attribute(bytes, "displayWindow", "box2i", window);
  append_attribute(bytes, "lineOrder", "lineOrder", std::string(1, '\0'));
  append_attribute(bytes, "pixelAspectRatio", "float", one);
  append_attribute(bytes, "screenWindowCenter", "v2f", center);
  append_attribute(bytes, "screenWindowWidth", "float", one);
  bytes.push_back('\0');
  return bytes;
}

}  // namespace

WriteStatus write_exr(const std::string& path, std::uint32_t width, std::uint32_t height,
                      std::span<const float> rgb) {
  OutputFile file(path);
  {
    BlockWriter out(file);
    out.block() += header(width, height);
    const std::uint64_t data_size = std::uint64_t{12} * width,
                        first = out.block().size() + std::uint64_t{8} * height;
    for (std::uint32_t y = 0; y < height; ++y) {
      append_little_endian(out.block(), first + y * (data_size + 8));
      out.flush_if_full();
    }
    for (std::uint32_t y = 0; y < height; ++y) {
      append_little_endian(out.block(), y);
      append_little_endian(out.block(), static_cast<std::uint32_t>(data_size));
      for (const std::size_t channel : {2, 1, 0}) {
        for (std::size_t x = 0; x < width; ++x) {
          append_little_endian(out.block(), rgb[3 * (std::size_t{y} * width + x) + channel]);
        }
        out.flush_if_full();
      }
    }
  }
  if (!file.commit()) return {WriteOutcome::kInputOutput, file.error()};
  return {};
}

}  // namespace nmc
