#include "shared/render/gl/pixel_reader.h"

#include <algorithm>

namespace isosplat::render {

void read_straight_pixels(GLint left, GLint bottom, int width, int height,
                          std::span<uint8_t> rgba) {
  glReadPixels(left, bottom, width, height, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
  const size_t row = 4 * size_t(width);
  for (int y = 0; y < height / 2; ++y) {
    std::swap_ranges(rgba.begin() + std::ptrdiff_t(row * size_t(y)),
                     rgba.begin() + std::ptrdiff_t(row * size_t(y + 1)),
                     rgba.begin() + std::ptrdiff_t(row * size_t(height - 1 - y)));
  }
  for (size_t i = 0; i < rgba.size(); i += 4) {
    const int alpha = rgba[i + 3];
    if (alpha == 0 || alpha == 255) continue;
    for (size_t c = i; c < i + 3; ++c) {
      rgba[c] = static_cast<uint8_t>(std::min(255, (rgba[c] * 255 + alpha / 2) / alpha));
    }
  }
}

}  // namespace isosplat::render
