// SPDX-License-Identifier: Apache-2.0
// An 8-bit sRGB picture in memory, a few drawing primitives, and PNG out.
#ifndef NMC_ENCODER_RENDER_IMAGE_H_
#define NMC_ENCODER_RENDER_IMAGE_H_

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "encoder/measure/color_ramp.h"

namespace nmc {

class Image {
 public:
  Image(int width, int height, const RgbColor& background);

  int width() const { return width_; }
  int height() const { return height_; }
  RgbColor& at(int x, int y) { return pixels_[static_cast<std::size_t>(y) * width_ + x]; }
  const RgbColor& at(int x, int y) const { return pixels_[static_cast<std::size_t>(y) * width_ + x]; }
  const std::vector<RgbColor>& pixels() const { return pixels_; }

  /// Parts outside of the image are left out.
  void fill_rectangle(int x, int y, int width, int height, const RgbColor& color);
  /// Copies `source` with its top left corner at (x, y).
  void paste(const Image& source, int x, int y);
  /// One line of ASCII text with its top left corner at (x, y); a capital letter is 7 * scale pixels high.
  void draw_text(int x, int y, int scale, std::string_view text, const RgbColor& color);

 private:
  int width_, height_;
  std::vector<RgbColor> pixels_;
};

/// Width in pixels of what draw_text() draws.
int text_width(std::string_view text, int scale);

/// Averages blocks of factor x factor pixels in linear light. The size must be a multiple of `factor`.
Image reduce(const Image& image, int factor);

/// Throws Error(kInputOutput).
void write_png(const std::string& path, const Image& image);

}  // namespace nmc

#endif  // NMC_ENCODER_RENDER_IMAGE_H_
