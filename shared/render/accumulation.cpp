#include "shared/render/accumulation.h"

#include <cmath>

namespace isosplat {

ImageOffset Accumulation::offset(int n) {
  // Powers of the inverse of the plastic number, the root of x³ = x + 1.
  constexpr double kAcross = 0.7548776662466927, kUp = 0.5698402909980532;
  const auto centred = [](double x) { return x - std::floor(x) - 0.5; };
  return {centred(0.5 + n * kAcross), centred(0.5 + n * kUp)};
}

Result<void> Accumulation::begin(int width, int height) {
  if (width != width_ || height != height_) {
    release();
    glGenTextures(1, &sums_);
    glBindTexture(GL_TEXTURE_2D, sums_);
    glTexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA16F, width, height);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glGenFramebuffers(1, &framebuffer_);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, sums_, 0);
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
      release();
      return fail(Status::gl_error, "the GPU has no room to smooth an image of this size");
    }
    width_ = width;
    height_ = height;
    bytes_ = uint64_t(width) * uint64_t(height) * 8;
  }
  pictures_ = 0;
  const float nothing[4] = {0, 0, 0, 0};
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glClearBufferfv(GL_COLOR, 0, nothing);
  return {};
}

void Accumulation::release() {
  if (sums_) glDeleteTextures(1, &sums_);
  if (framebuffer_) glDeleteFramebuffers(1, &framebuffer_);
  forget();
}

void Accumulation::forget() {
  width_ = height_ = pictures_ = 0;
  framebuffer_ = sums_ = 0;
  bytes_ = 0;
}

}  // namespace isosplat
