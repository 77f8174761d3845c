// SPDX-License-Identifier: Apache-2.0
#include "encoder/render/image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "encoder/core/error.h"

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_easy_font.h>
#include <stb/stb_image_write.h>
#pragma GCC diagnostic pop

namespace nmc {
namespace {

struct TextVertex {
  float x, y, z;
  unsigned char color[4];
};
static_assert(sizeof(TextVertex) == 16, "the layout that stb_easy_font documents");

double to_linear(std::uint8_t value) {
  static const std::array<double, 256> table = [] {
    std::array<double, 256> values{};
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double s = static_cast<double>(i) / 255;
      values[i] = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
    }
    return values;
  }();
  return table[value];
}

std::uint8_t to_srgb(double linear) {
  const double s = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(s, 0.0, 1.0)));
}

}  // namespace

Image::Image(int width, int height, const RgbColor& background)
    : width_(width), height_(height), pixels_(static_cast<std::size_t>(width) * height, background) {}

void Image::fill_rectangle(int x, int y, int width, int height, const RgbColor& color) {
  for (int row = std::max(0, y); row < std::min(height_, y + height); ++row) {
    for (int column = std::max(0, x); column < std::min(width_, x + width); ++column) at(column, row) = color;
  }
}

void Image::paste(const Image& source, int x, int y) {
  for (int row = std::max(0, -y); row < std::min(source.height_, height_ - y); ++row) {
    for (int column = std::max(0, -x); column < std::min(source.width_, width_ - x); ++column) {
      at(x + column, y + row) = source.at(column, row);
    }
  }
}

void Image::draw_text(int x, int y, int scale, std::string_view text, const RgbColor& color) {
  std::string line(text);
  std::vector<char> buffer(line.size() * 600 + 600);
  const int quads =
      stb_easy_font_print(0, 0, line.data(), nullptr, buffer.data(), static_cast<int>(buffer.size()));
  for (int quad = 0; quad < quads; ++quad) {
    TextVertex corners[4];
    std::memcpy(corners, buffer.data() + static_cast<std::size_t>(quad) * sizeof(corners), sizeof(corners));
    const auto left = static_cast<int>(corners[0].x), top = static_cast<int>(corners[0].y);
    const auto right = static_cast<int>(corners[2].x), bottom = static_cast<int>(corners[2].y);
    fill_rectangle(x + scale * left, y + scale * top, scale * (right - left), scale * (bottom - top), color);
  }
}

int text_width(std::string_view text, int scale) {
  std::string line(text);
  return scale * stb_easy_font_width(line.data());
}

Image reduce(const Image& image, int factor) {
  Image reduced(image.width() / factor, image.height() / factor, {});
  for (int y = 0; y < reduced.height(); ++y) {
    for (int x = 0; x < reduced.width(); ++x) {
      double sum[3] = {0, 0, 0};
      for (int k = 0; k < factor * factor; ++k) {
        const RgbColor& color = image.at(x * factor + k % factor, y * factor + k / factor);
        for (std::size_t i = 0; i < 3; ++i) sum[i] += to_linear(color[i]);
      }
      for (std::size_t i = 0; i < 3; ++i) reduced.at(x, y)[i] = to_srgb(sum[i] / (factor * factor));
    }
  }
  return reduced;
}

void write_png(const std::string& path, const Image& image) {
  if (stbi_write_png(path.c_str(), image.width(), image.height(), 3, image.pixels().data(),
                     3 * image.width()) == 0) {
    throw Error(ExitCode::kInputOutput, path + ": the picture cannot be written");
  }
}

}  // namespace nmc
