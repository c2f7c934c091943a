#include "native/headless/draw_image.h"

#include <GLES3/gl3.h>

#include <algorithm>

namespace isosplat {

Result<Image> draw_image(Renderer& renderer, int width, int height, FrameStatistics* statistics,
                         bool smooth) {
  GLuint framebuffer = 0, colour = 0;
  glGenFramebuffers(1, &framebuffer);
  glGenRenderbuffers(1, &colour);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glBindRenderbuffer(GL_RENDERBUFFER, colour);
  glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, width, height);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, colour);
  auto drawn = smooth ? renderer.draw_still(width, height, framebuffer)
                      : renderer.draw(width, height, framebuffer);
  if (const auto checked = renderer.check_gpu(); drawn && !checked) {
    drawn = tl::unexpected(checked.error());
  }
  Image image;
  if (drawn) {
    if (statistics) *statistics = *drawn;
    image = {width, height, std::vector<uint8_t>(4 * size_t(width) * size_t(height))};
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, image.rgba.data());
  }
  glDeleteFramebuffers(1, &framebuffer);
  glDeleteRenderbuffers(1, &colour);
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
