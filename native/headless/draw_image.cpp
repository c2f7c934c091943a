#include "native/headless/draw_image.h"

#include <algorithm>

#include "native/headless/offscreen_target.h"

namespace isosplat {

Result<Image> draw_image(Renderer& renderer, int width, int height, FrameStatistics* statistics,
                         bool smooth) {
  const OffscreenTarget target(width, height);
  auto drawn = smooth ? renderer.draw_still(width, height, target.framebuffer())
                      : renderer.draw(width, height, target.framebuffer());
  if (const auto checked = renderer.check_gpu(); drawn && !checked) {
    drawn = tl::unexpected(checked.error());
  }
  Image image;
  if (drawn) {
    if (statistics) *statistics = *drawn;
    image = {width, height, std::vector<uint8_t>(4 * size_t(width) * size_t(height))};
    glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer());
    glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, image.rgba.data());
  }
  if (!drawn) return tl::unexpected(drawn.error());

  const size_t row = 4 * size_t(width);
  for (int y = 0; y < height / 2; ++y) {
    std::swap_ranges(image.rgba.begin() + std::ptrdiff_t(row * size_t(y)),
                     image.rgba.begin() + std::ptrdiff_t(row * size_t(y + 1)),
                     image.rgba.begin() + std::ptrdiff_t(row * size_t(height - 1 - y)));
  }
  for (size_t i = 0; i < image.rgba.size(); i += 4) {
    const int alpha = image.rgba[i + 3];
    if (alpha == 0 || alpha == 255) continue;
    for (size_t c = i; c < i + 3; ++c) {
      image.rgba[c] =
          static_cast<uint8_t>(std::min(255, (image.rgba[c] * 255 + alpha / 2) / alpha));
    }
  }
  return image;
}

}  // namespace isosplat
